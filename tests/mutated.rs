//! Files that are broken at random: a reader answers with a table that can be worked with or with an error that says what is
//! wrong, and it answers soon. What has to hold is that of the fuzzing targets, `fuzz/src`.
//!
//! `EXID_MUTATIONS=10000 cargo test --release --test mutated -- --nocapture` tries so many files for each reader.

#[path = "../fuzz/src/description.rs"]
mod description;
#[path = "../fuzz/src/recording.rs"]
mod recording;
#[path = "../fuzz/src/robot.rs"]
mod robot;

use description::describes_itself;
use exid::chain::effect::ids;
use exid::problem_file::ProblemFile;
use exid::robot::{mdh, mjcf, urdf};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Files for each reader without another word.
const FILES: usize = 12;

/// A reader that takes longer over a small file hangs.
const SOON: Duration = Duration::from_secs(5);

/// Bytes of the largest seed.
const LARGEST: usize = 60_000;

/// Reads bytes. Fails where what is accepted cannot be worked with, or an error does not say what is wrong.
type Answer = Box<dyn Fn(&[u8])>;

/// What files are read as, with sound ones of the kind.
struct Reader {
    name: String,
    seeds: Vec<Vec<u8>>,
    answer: Answer,
}

impl Reader {
    /// Of texts.
    fn of_text(name: &str, seeds: Vec<Vec<u8>>, answer: impl Fn(&str) + 'static) -> Self {
        Self {
            name: name.to_string(),
            seeds,
            answer: Box::new(move |bytes| answer(&String::from_utf8_lossy(bytes))),
        }
    }
}

/// The shipped files of some folders by what their names have from the first dot on.
fn shipped(folders: &[&str]) -> BTreeMap<String, Vec<Vec<u8>>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut folders: Vec<PathBuf> = folders.iter().map(|folder| root.join(folder)).collect();
    let mut seeds: BTreeMap<String, Vec<Vec<u8>>> = BTreeMap::new();
    while let Some(folder) = folders.pop() {
        let mut entries: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|e| e.unwrap().path())
            .collect();
        entries.sort();
        for path in entries {
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let name = path.file_name().unwrap().to_string_lossy();
            let extension = name[name.find('.').unwrap()..].to_string();
            let bytes = fs::read(&path).unwrap();
            if bytes.len() <= LARGEST {
                seeds.entry(extension).or_default().push(bytes);
            }
        }
    }
    seeds
}

/// Readers of recordings, of robots and of problems.
fn readers() -> Vec<Reader> {
    let recordings = shipped(&["tests/data/recordings"]).into_iter();
    let recordings = recordings.filter(|(extension, _)| extension != ".py");
    let mut readers: Vec<Reader> = recordings
        .map(|(extension, seeds)| Reader {
            name: extension.clone(),
            seeds,
            answer: Box::new(move |bytes| recording::is_sound(&extension, bytes)),
        })
        .collect();
    let mut others = shipped(&["problems", "tests/mjcf/models"]);
    let mut of = |extension: &str| others.remove(extension).unwrap();
    readers.push(Reader::of_text("URDF", of(".urdf"), |text| {
        robot::is_sound(urdf::parse(text, Path::new("robot")));
    }));
    readers.push(Reader::of_text("MDH", of(".mdh.toml"), |text| {
        robot::is_sound(mdh::parse(text, Path::new("robot")));
    }));
    readers.push(Reader::of_text("problem", of(".toml"), |text| {
        let path = Path::new("folder/problem.toml");
        if let Err(fault) = ProblemFile::parse(path, text, &[], &ids()) {
            describes_itself(&fault);
        }
    }));
    let folder = tempfile::tempdir().unwrap();
    readers.push(Reader::of_text("MJCF", of(".xml"), move |text| {
        let path = folder.path().join("model.xml");
        fs::write(&path, text).unwrap();
        robot::is_sound(mjcf::read(&path).map(|description| description.tree));
    }));
    readers
}

/// One to four changes of a file: bits, bytes, lengths, pieces that are lost, doubled or come from another file.
fn mutated(random: &mut ChaCha8Rng, seeds: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = seeds[random.random_range(0..seeds.len())].clone();
    for _ in 0..random.random_range(1..=4) {
        if bytes.is_empty() {
            break;
        }
        let at = random.random_range(0..bytes.len());
        let length = random.random_range(1..=64).min(bytes.len() - at);
        match random.random_range(0..8) {
            0 => bytes[at] ^= 1 << random.random_range(0..8),
            1 => bytes[at] = random.random_range(0..=255),
            2 => bytes[at..at + length].fill([0, 0xff, b'9', b','][random.random_range(0..4)]),
            3 => drop(bytes.drain(at..at + length)),
            4 => bytes.truncate(at),
            5 => {
                let piece = bytes[at..at + length].to_vec();
                bytes.splice(at..at, piece);
            }
            6 => {
                let other = &seeds[random.random_range(0..seeds.len())];
                let from = random.random_range(0..other.len());
                let piece = &other[from..(from + length).min(other.len())];
                bytes.splice(at..at + length, piece.iter().copied());
            }
            // A count or an offset of 32 bits.
            _ => {
                let number: u32 = random.random_range(0..=u32::MAX) >> random.random_range(0..32);
                let end = (at + 4).min(bytes.len());
                bytes[at..end].copy_from_slice(&number.to_le_bytes()[..end - at]);
            }
        }
    }
    bytes
}

#[test]
fn readers_answer_to_every_broken_file_and_soon() {
    let stated = std::env::var("EXID_MUTATIONS").ok();
    let files = stated.map_or(FILES, |text| text.parse().unwrap());
    let mut faults = Vec::new();
    for Reader {
        name,
        seeds,
        answer,
    } in readers()
    {
        let mut random = ChaCha8Rng::seed_from_u64(files as u64);
        let mut slowest = Duration::ZERO;
        for number in 0..files {
            let bytes = mutated(&mut random, &seeds);
            let started = Instant::now();
            let answered = catch_unwind(AssertUnwindSafe(|| answer(&bytes)));
            slowest = slowest.max(started.elapsed());
            if answered.is_err() || started.elapsed() > SOON {
                faults.push(format!(
                    "{name}, file {number} of {files}: {:?}",
                    started.elapsed()
                ));
            }
        }
        eprintln!(
            "{name}: {files} files of {} seeds, the slowest in {slowest:?}",
            seeds.len()
        );
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
