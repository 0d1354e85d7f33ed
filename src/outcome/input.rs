//! An input file and its SHA-256, computed in one pass of bounded memory.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::outcome::error::{Action, OutcomeError};

/// Bytes read at a time: large enough that the hash, not the call, takes the time.
const CHUNK_BYTES: usize = 256 * 1024;

/// A file that the run read.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Input {
    /// Path as written by the user.
    pub path: String,
    /// SHA-256 of the bytes, 64 hexadecimal digits in lower case.
    pub sha256: String,
}

impl Input {
    /// Hashes the file at `path`.
    ///
    /// # Errors
    /// `not-readable` if the file cannot be opened or read.
    pub fn of(path: &Path) -> Result<Self, OutcomeError> {
        let sha256 =
            sha256(path).map_err(|error| OutcomeError::io(path, Action::ReadInput, &error))?;
        Ok(Self {
            path: path.display().to_string(),
            sha256,
        })
    }

    /// What stands in the place of a file at `path`, hashed as the text that it would hold.
    pub fn of_text(path: &Path, text: &str) -> Self {
        Self {
            path: path.display().to_string(),
            sha256: digits(Sha256::new_with_prefix(text)),
        }
    }
}

fn sha256(path: &Path) -> io::Result<String> {
    let mut file = File::open(path)?;
    let mut hash = Sha256::new();
    let mut chunk = vec![0; CHUNK_BYTES];
    loop {
        match file.read(&mut chunk) {
            Ok(0) => break,
            Ok(count) => hash.update(&chunk[..count]),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(digits(hash))
}

fn digits(hash: Sha256) -> String {
    let bytes = hash.finalize();
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// FIPS 180-2, appendix B.1 and B.3: "abc", and one million times "a".
    #[test]
    fn matches_published_digests_across_chunks() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("input");
        for (content, digest) in [
            (
                "abc".to_string(),
                "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad",
            ),
            (
                "a".repeat(1_000_000),
                "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0",
            ),
        ] {
            std::fs::write(&path, content).unwrap();
            assert_eq!(Input::of(&path).unwrap().sha256, digest);
        }
    }

    #[test]
    fn names_a_file_that_is_not_there() {
        let error = Input::of(Path::new("no/such/file.csv")).unwrap_err();
        assert!(error.to_string().starts_with("no/such/file.csv: "));
    }
}
