//! What pages show of the program, run again.
//!
//! A block of commands behind the mark `<!-- run -->` is run, line by line in a folder of its own in which `problems` are those
//! of the repository; the block of text that follows it, if one does, is what the commands print. `<!-- run exit 3 -->` says
//! with which code the last of them ends, and `<!-- printed by: COMMAND -->` stands before a text whose command is shown
//! elsewhere. A line `...` in the text stands for lines that are left out. Numbers may differ by [`TOLERANCE`] or by one in their
//! last place, as rounding does from processor to processor; everything else has to be the same.

use crate::pages::{self, Page, remakes, root};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// Relative difference of two numbers that counts as none.
const TOLERANCE: f64 = 5e-3;

/// Commands of a page with the text that they print.
struct Shown {
    /// Line of the mark, from 1.
    line: usize,
    commands: Vec<String>,
    exit: i32,
    /// Lines of the text, as a range of lines of the page from 0; empty where nothing is shown.
    text: std::ops::Range<usize>,
}

/// The marked commands of a page.
fn shown(page: &Page) -> Vec<Shown> {
    let lines: Vec<&str> = page.text.lines().collect();
    let mut found = Vec::new();
    for (k, line) in lines.iter().enumerate() {
        let Some(mark) = line
            .strip_prefix("<!-- ")
            .and_then(|l| l.strip_suffix(" -->"))
        else {
            continue;
        };
        let mut one = Shown {
            line: k + 1,
            commands: Vec::new(),
            exit: 0,
            text: 0..0,
        };
        if let Some(command) = mark.strip_prefix("printed by: ") {
            one.commands = vec![command.to_owned()];
            one.text = block(&lines, k + 1, "```text").expect("a block of text");
        } else if mark == "run" || mark.starts_with("run exit ") {
            one.exit = mark
                .strip_prefix("run exit ")
                .map_or(0, |code| code.parse().unwrap());
            let commands = block(&lines, k + 1, "```sh").expect("a block of commands");
            one.text = block(&lines, commands.end + 1, "```text").unwrap_or(0..0);
            one.commands = commands_of(&lines[commands]);
        } else {
            continue;
        }
        found.push(one);
    }
    found
}

/// The lines of the fenced block that opens at `from`, blank lines aside.
fn block(lines: &[&str], from: usize, fence: &str) -> Option<std::ops::Range<usize>> {
    let open = (from..lines.len()).find(|k| !lines[*k].is_empty())?;
    if lines[open] != fence {
        return None;
    }
    let close = (open + 1..lines.len()).find(|k| lines[*k] == "```")?;
    Some(open + 1..close)
}

/// Commands of a block: lines that end with a backslash go on, and so do those that are indented; comments are none.
fn commands_of(lines: &[&str]) -> Vec<String> {
    let mut commands: Vec<String> = Vec::new();
    let mut goes_on = false;
    for line in lines
        .iter()
        .filter(|l| !l.is_empty() && !l.starts_with('#'))
    {
        match commands
            .last_mut()
            .filter(|_| goes_on || line.starts_with(' '))
        {
            Some(last) => *last = format!("{last}\n{line}"),
            None => commands.push((*line).to_owned()),
        }
        goes_on = line.ends_with('\\');
    }
    commands
}

/// A folder in which commands run, and what they printed.
struct Workplace {
    folder: TempDir,
    printed: BTreeMap<String, String>,
}

impl Workplace {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let (from, to) = (root().join("problems"), folder.path().join("problems"));
        copy(&from, &to);
        Self {
            folder,
            printed: BTreeMap::new(),
        }
    }

    /// What a command prints, on both streams; the same command runs once.
    fn run(&mut self, command: &str, exit: i32) -> Result<String, String> {
        if let Some(text) = self.printed.get(command) {
            return Ok(text.clone());
        }
        let program = command.replace("cargo run --release -- ", "exid ");
        let exid = PathBuf::from(env!("CARGO_BIN_EXE_exid"));
        let path = std::env::var("PATH").unwrap_or_default();
        let output = Command::new("bash")
            .args(["-euo", "pipefail", "-c", &format!("{{ {program}\n}} 2>&1")])
            .current_dir(self.folder.path())
            .env(
                "PATH",
                format!("{}:{path}", exid.parent().unwrap().display()),
            )
            .env("NO_COLOR", "1")
            .output()
            .map_err(|e| format!("bash: {e}"))?;
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        if output.status.code() != Some(exit) {
            return Err(format!(
                "`{command}` ends with {:?}:\n{text}",
                output.status.code()
            ));
        }
        self.printed.insert(command.to_owned(), text.clone());
        Ok(text)
    }
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        match path.is_dir() {
            true => copy(&path, &target),
            false => drop(fs::copy(&path, &target).unwrap()),
        }
    }
}

/// A line without its numbers, and the numbers as they are written; digits of a name belong to the name.
fn parted(line: &str) -> (String, Vec<String>) {
    let chars: Vec<char> = line
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
        .chars()
        .collect();
    let (mut words, mut numbers) = (String::new(), Vec::new());
    let mut k = 0;
    while k < chars.len() {
        let before = k.checked_sub(1).map_or(' ', |b| chars[b]);
        let in_name = before.is_alphanumeric() || ['_', '.', '-', '/'].contains(&before);
        let starts = chars[k].is_ascii_digit()
            || (chars[k] == '-' && chars.get(k + 1).is_some_and(char::is_ascii_digit));
        if !starts || in_name {
            words.push(chars[k]);
            k += 1;
            continue;
        }
        let mut end = k + 1;
        while end < chars.len() {
            let c = chars[end];
            let exponent = c == 'e'
                && chars
                    .get(end + 1)
                    .is_some_and(|n| n.is_ascii_digit() || *n == '-');
            let sign = c == '-' && chars[end - 1] == 'e';
            let point = c == '.' && chars.get(end + 1).is_some_and(char::is_ascii_digit);
            if !(c.is_ascii_digit() || exponent || sign || point) {
                break;
            }
            end += 1;
        }
        numbers.push(chars[k..end].iter().collect());
        words.push('#');
        k = end;
    }
    (words, numbers)
}

/// One unit in the last place of a number as it is written.
fn last_place(number: &str) -> f64 {
    let (digits, exponent) = number.split_once('e').unwrap_or((number, "0"));
    let decimals = digits.split_once('.').map_or(0, |(_, d)| d.len() as i32);
    10f64.powi(exponent.parse::<i32>().unwrap() - decimals)
}

/// Whether two lines say the same but for noise.
fn agree(shown: &str, printed: &str) -> bool {
    let ((words, numbers), (others, found)) = (parted(shown), parted(printed));
    let close = |(a, b): (&String, &String)| {
        // Versions and dates have too many points for a number.
        let (Ok(x), Ok(y)) = (a.parse::<f64>(), b.parse::<f64>()) else {
            return a == b;
        };
        let room = last_place(a)
            .max(last_place(b))
            .max(TOLERANCE * x.abs().max(y.abs()));
        (x - y).abs() <= 1.000_001 * room
    };
    words == others && numbers.len() == found.len() && numbers.iter().zip(&found).all(close)
}

/// Lines of which some are left out.
const LEFT_OUT: &str = "...";

/// The shown lines as they are printed now: each run of lines between those that are left out stands where its first line has the
/// same words, behind the run before it.
fn refreshed(shown: &[&str], printed: &[&str]) -> Result<Vec<String>, String> {
    if shown == [LEFT_OUT] {
        return Err("nothing is shown of what is printed".into());
    }
    if !shown.contains(&LEFT_OUT) {
        return Ok(printed.iter().map(|l| (*l).to_owned()).collect());
    }
    let mut out = Vec::new();
    let mut from = 0;
    for (k, part) in shown.split(|line| *line == LEFT_OUT).enumerate() {
        if k > 0 {
            out.push(LEFT_OUT.to_owned());
        }
        let Some(first) = part.first() else {
            continue;
        };
        let words = parted(first).0;
        let found = (from..printed.len()).find(|at| parted(printed[*at]).0 == words);
        let start = found.ok_or_else(|| format!("no line like `{first}` is printed any more"))?;
        from = (start + part.len()).min(printed.len());
        out.extend(printed[start..from].iter().map(|l| (*l).to_owned()));
    }
    Ok(out)
}

/// What differs between the lines that are shown and those that are printed.
fn differences(shown: &[&str], printed: &[String]) -> Vec<String> {
    let mut found: Vec<String> = shown
        .iter()
        .zip(printed)
        .filter(|(a, b)| !agree(a, b))
        .map(|(a, b)| format!("  shown   {a}\n  printed {b}"))
        .collect();
    if shown.len() != printed.len() {
        found.push(format!(
            "  {} lines shown, {} printed",
            shown.len(),
            printed.len()
        ));
    }
    found
}

#[test]
fn pages_show_what_the_program_prints() {
    let mut workplace = Workplace::new();
    let mut faults = Vec::new();
    let mut texts = 0;
    for page in pages::all() {
        let mut lines: Vec<String> = page.text.lines().map(str::to_owned).collect();
        // From the last to the first, so that places of earlier texts stay; commands run in their order.
        let mut written: Vec<(std::ops::Range<usize>, Vec<String>)> = Vec::new();
        for one in shown(&page) {
            let place = format!("{}:{}", page.path.display(), one.line);
            let mut printed = String::new();
            let last = one.commands.len().saturating_sub(1);
            let mut failed = false;
            for (k, command) in one.commands.iter().enumerate() {
                let exit = if k == last { one.exit } else { 0 };
                match workplace.run(command, exit) {
                    Ok(text) => printed.push_str(&text),
                    Err(fault) => {
                        faults.push(format!("{place}: {fault}"));
                        failed = true;
                    }
                }
            }
            if failed || one.text.is_empty() && !page_has_text(&page, &one) {
                continue;
            }
            texts += 1;
            let shown: Vec<&str> = page.text.lines().collect::<Vec<_>>()[one.text.clone()].to_vec();
            let printed: Vec<&str> = printed.trim_end().lines().collect();
            match refreshed(&shown, &printed) {
                Err(fault) => faults.push(format!("{place}: {fault}")),
                Ok(fresh) if remakes() => written.push((one.text, fresh)),
                Ok(fresh) => {
                    let differs = differences(&shown, &fresh);
                    if !differs.is_empty() {
                        faults.push(format!("{place}:\n{}", differs.join("\n")));
                    }
                }
            }
        }
        for (range, fresh) in written.into_iter().rev() {
            lines.splice(range, fresh);
        }
        if remakes() {
            let text = lines.join("\n") + "\n";
            if text != page.text {
                fs::write(root().join(&page.path), text).unwrap();
            }
        }
    }
    assert!(
        faults.is_empty(),
        "{}\nrun docs/remake, and read what it changes",
        faults.join("\n")
    );
    assert!(texts >= 8, "{texts} texts");
}

/// Whether a text follows, though it is empty still.
fn page_has_text(page: &Page, one: &Shown) -> bool {
    let lines: Vec<&str> = page.text.lines().collect();
    one.text.start > 0 && lines[one.text.start - 1] == "```text"
}

/// Every command of the tutorial is run: none stands there without a mark.
#[test]
fn tutorial_is_executed_line_by_line() {
    let pages = pages::all();
    let is_tutorial = |p: &&Page| p.path == Path::new("docs/src/tutorial.md");
    let tutorial = pages.iter().find(is_tutorial).unwrap();
    let blocks = tutorial.text.lines().filter(|l| *l == "```sh").count();
    let run = shown(tutorial);
    assert_eq!(run.len(), blocks);
    let commands: usize = run.iter().map(|one| one.commands.len()).sum();
    assert!(commands >= 8, "{commands} commands");
}

#[test]
fn numbers_differ_by_noise_and_by_more() {
    assert!(agree(
        "  a3  A  0.1092  0.38 %",
        "  a3   A   0.1093  0.38 %"
    ));
    assert!(!agree("rank 60, 0.1141", "rank 60, 0.1092"));
    assert!(!agree("rank 60 of 84", "rank 58 of 84"));
    assert!(!agree("link1.Izz 1.0", "link2.Izz 1.0"));
    assert!(agree("1.389e-7 ± 2.1e-9", "1.390e-7 ± 2.2e-9"));
    assert!(!agree("note: a", "note: b"));
    let printed = ["a 1", "b 2", "c 3", "d 4"];
    assert_eq!(
        refreshed(&["a 9", "...", "d 5"], &printed).unwrap(),
        ["a 1", "...", "d 4"]
    );
    assert!(refreshed(&["a 9", "...", "e 5"], &printed).is_err());
}
