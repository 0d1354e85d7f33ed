//! Where an input is broken and run: a sound problem in a folder, the command line, and who runs it.

use crate::common::arm::Arm;
use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Most memory of a run in KiB, of the heap and all stacks: 200 MB.
const MEMORY_KIB: &str = "195312";

/// User without rights, as most systems number it.
const NOBODY: &str = "65534";

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Identity {
    /// Whoever runs the tests.
    Own,
    /// A user to whom permissions apply, from the superuser.
    Nobody,
    /// The superuser runs the tests, and cannot run anything as another.
    Unavailable,
}

/// A sound problem, to be broken.
pub struct Bench {
    arm: Arm,
    pub identity: Identity,
    arguments: Vec<String>,
}

/// What a run did.
pub struct Outcome {
    pub exit: Option<i32>,
    pub stdout: String,
    /// The folder's name, which differs from run to run, is left out.
    pub stderr: String,
    pub took: Duration,
    /// Files and folders that the run has made or changed.
    pub left: Vec<String>,
}

impl Bench {
    pub fn new() -> Self {
        let arguments = ["fit", "problem.toml", "--quiet", "--out", "out"];
        Self {
            arm: Arm::new(4),
            identity: Identity::Own,
            arguments: arguments.map(String::from).to_vec(),
        }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.arm.path(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        self.arm.write(name, content);
    }

    pub fn folder(&self, name: &str) {
        fs::create_dir(self.path(name)).unwrap();
    }

    pub fn robot(&self, from: &str, to: &str) {
        self.arm.edit("arm.urdf", from, to);
    }

    pub fn problem(&self, from: &str, to: &str) {
        self.arm.edit("problem.toml", from, to);
    }

    /// Adds text at the end of the problem file.
    pub fn append(&self, text: &str) {
        let path = self.path("problem.toml");
        let mut file = fs::OpenOptions::new().append(true).open(path).unwrap();
        file.write_all(text.as_bytes()).unwrap();
    }

    /// Lines of the recording, changed.
    pub fn recording(&self, change: impl Fn(&mut Vec<String>)) {
        let text = fs::read_to_string(self.path("train.csv")).unwrap();
        let mut lines: Vec<String> = text.lines().map(String::from).collect();
        change(&mut lines);
        self.write("train.csv", lines.join("\n") + "\n");
    }

    /// Replaces a field, counted from 0, of a line of the recording, counted from 1.
    pub fn field(&self, line: usize, field: usize, value: &str) {
        self.recording(|lines| {
            let mut fields: Vec<&str> = lines[line - 1].split(',').collect();
            fields[field] = value;
            lines[line - 1] = fields.join(",");
        });
    }

    /// Another name for the recording, in the problem file too.
    pub fn call_recording(&self, name: &str) {
        fs::rename(self.path("train.csv"), self.path(name)).unwrap();
        self.problem("train.csv", name);
    }

    /// A file of so many bytes, all zero, that takes no room on the disk.
    pub fn sparse(&self, name: &str, bytes: u64) {
        let file = fs::File::create(self.path(name)).unwrap();
        file.set_len(bytes).unwrap();
    }

    /// Replaces the command line.
    pub fn command(&mut self, arguments: &[&str]) {
        self.arguments = arguments.iter().map(|a| a.to_string()).collect();
    }

    /// Further arguments after `fit problem.toml --quiet --out out`.
    pub fn with(&mut self, further: &[&str]) {
        self.arguments.extend(further.iter().map(|a| a.to_string()));
    }

    /// Sets the permissions of a file or folder, and sees to it that they apply to whoever runs the program.
    pub fn forbid(&mut self, name: &str, mode: u32) {
        let permit = |path: &Path, mode| {
            fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
        };
        permit(self.arm.folder(), 0o777);
        permit(&self.path(name), mode);
        // A process belongs to its user; permissions mean nothing to the superuser.
        if fs::metadata("/proc/self").is_ok_and(|process| process.uid() == 0) {
            let other = self.as_nobody("true").status();
            self.identity = match other {
                Ok(status) if status.success() => Identity::Nobody,
                _ => Identity::Unavailable,
            };
        }
    }

    fn as_nobody(&self, program: &str) -> Command {
        let mut command = Command::new("setpriv");
        command
            .args(["--reuid", NOBODY, "--regid", NOBODY, "--clear-groups"])
            .arg(program);
        command
    }

    /// Runs the program with bounded memory.
    pub fn run(&self) -> Outcome {
        let mut command = match self.identity {
            Identity::Nobody => self.as_nobody("sh"),
            _ => Command::new("sh"),
        };
        command
            .args(["-c", "ulimit -d \"$0\"; exec \"$@\"", MEMORY_KIB])
            .arg(env!("CARGO_BIN_EXE_exid"))
            .args(&self.arguments)
            .current_dir(self.arm.folder())
            .stdin(Stdio::null());
        let before = listing(self.arm.folder());
        let started = Instant::now();
        let output = command.output().unwrap();
        let took = started.elapsed();
        let after = listing(self.arm.folder());
        let left = (after.iter())
            .filter(|(path, state)| before.get(*path) != Some(state))
            .map(|(path, _)| path.clone());
        let gone = before.keys().filter(|path| !after.contains_key(*path));
        let folder = self.arm.folder().display().to_string();
        Outcome {
            exit: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr)
                .unwrap()
                .replace(&folder, "FOLDER"),
            took,
            left: left.chain(gone.cloned()).collect(),
        }
    }
}

/// Every file and folder below, with its size and the time of its last change.
fn listing(root: &Path) -> BTreeMap<String, (u64, std::time::SystemTime)> {
    let mut found = BTreeMap::new();
    let mut folders = vec![root.to_path_buf()];
    while let Some(folder) = folders.pop() {
        let Ok(entries) = fs::read_dir(&folder) else {
            continue;
        };
        for entry in entries.flatten() {
            let metadata = entry.metadata().unwrap();
            let path = entry.path();
            let name = path.strip_prefix(root).unwrap().display().to_string();
            if metadata.is_dir() {
                // Its entries tell what happened in it.
                found.insert(name, (0, std::time::UNIX_EPOCH));
                folders.push(path);
            } else {
                found.insert(name, (metadata.len(), metadata.modified().unwrap()));
            }
        }
    }
    found
}
