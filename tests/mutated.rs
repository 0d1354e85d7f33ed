//! Files that are broken at random: a reader answers with a table that can be worked with or with an error that says what is
//! wrong, and it answers soon. What has to hold is that of the fuzzing targets, `fuzz/src`.
//!
//! `EXID_MUTATIONS=10000 cargo test --release --test mutated -- --nocapture` tries so many files for each reader.

#[path = "../fuzz/src/description.rs"]
mod description;
#[path = "../fuzz/src/recording.rs"]
mod recording;

use description::describes_itself;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

/// Files for each reader without another word.
const FILES: usize = 12;

/// A reader that takes longer over a small file hangs.
const SOON: Duration = Duration::from_secs(5);

/// Bytes of the largest seed.
const LARGEST: usize = 60_000;

/// The shipped recordings by their extension.
fn seeds() -> BTreeMap<String, Vec<Vec<u8>>> {
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/recordings")];
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
            if extension != ".py" && bytes.len() <= LARGEST {
                seeds.entry(extension).or_default().push(bytes);
            }
        }
    }
    seeds
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
    for (extension, seeds) in seeds() {
        let mut random = ChaCha8Rng::seed_from_u64(files as u64);
        let mut slowest = Duration::ZERO;
        for number in 0..files {
            let bytes = mutated(&mut random, &seeds);
            let started = Instant::now();
            let answer = catch_unwind(AssertUnwindSafe(|| recording::is_sound(&extension, &bytes)));
            slowest = slowest.max(started.elapsed());
            if answer.is_err() || started.elapsed() > SOON {
                faults.push(format!(
                    "{extension}, file {number} of {files}: {:?}",
                    started.elapsed()
                ));
            }
        }
        eprintln!(
            "{extension}: {files} files of {} seeds, the slowest in {slowest:?}",
            seeds.len()
        );
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
