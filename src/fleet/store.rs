//! The folder of items: one file for each, written whole or not at all.
//!
//! `ab/abcd….json` is what an item came to, `ab/abcd….attempt` how often it was begun without an end: it is there while an
//! item is under way, and stays where the process is killed. A file is written under a name of its own and renamed; one that
//! a failing machine left torn cannot be read and counts as absent, so that nothing waits for the disk.

use crate::fleet::error::FleetError;
use crate::fleet::item::Kept;
use crate::outcome::provenance::VERSION;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs;
use std::io;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

/// A folder of items that come to values of a type.
#[derive(Debug)]
pub struct Store<T> {
    folder: PathBuf,
    came_to: PhantomData<fn() -> T>,
}

/// Digits of a key that name the folder of its file: 256 folders.
const PREFIX: usize = 2;

impl<T: Serialize + DeserializeOwned> Store<T> {
    /// The folder, made where it is missing.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn open(folder: &Path) -> Result<Self, FleetError> {
        fs::create_dir_all(folder).map_err(|e| FleetError::not_written(folder, &e))?;
        Ok(Self {
            folder: folder.to_path_buf(),
            came_to: PhantomData,
        })
    }

    fn place(&self, key: &str, extension: &str) -> PathBuf {
        let prefix = key.get(..PREFIX).unwrap_or(key);
        self.folder.join(prefix).join(format!("{key}.{extension}"))
    }

    /// What an item came to; `None` where it is not done.
    pub fn read(&self, key: &str) -> Option<T> {
        let text = fs::read(self.place(key, "json")).ok()?;
        let kept: Kept<T> = serde_json::from_slice(&text).ok()?;
        (kept.key == key).then_some(kept.came_to)
    }

    /// Attempts that a killed process has not ended.
    pub fn abandoned(&self, key: &str) -> u32 {
        let text = fs::read_to_string(self.place(key, "attempt"));
        text.ok().and_then(|t| t.trim().parse().ok()).unwrap_or(0)
    }

    /// Says that an item is under way, after so many attempts that were abandoned.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn begin(&self, key: &str, abandoned: u32) -> Result<(), FleetError> {
        self.put(&self.place(key, "attempt"), &(abandoned + 1).to_string())
    }

    /// Says that an item is under way no more and came to nothing that is kept.
    pub fn give_up(&self, key: &str, abandoned: u32) {
        let marker = self.place(key, "attempt");
        // What cannot be undone counts as one attempt more, which the limit has room for.
        let _ = match abandoned {
            0 => fs::remove_file(marker),
            _ => fs::write(marker, abandoned.to_string()),
        };
    }

    /// Keeps what an item came to.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn keep(&self, key: &str, came_to: &T) -> Result<(), FleetError> {
        let kept = Kept {
            key: key.to_string(),
            version: VERSION.to_string(),
            came_to,
        };
        let place = self.place(key, "json");
        let text = serde_json::to_string(&kept).map_err(|e| FleetError::not_written(&place, &e))?;
        self.put(&place, &text)?;
        match fs::remove_file(self.place(key, "attempt")) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                Err(FleetError::not_written(&self.folder, &error))
            }
            _ => Ok(()),
        }
    }

    /// Writes a file whole or not at all.
    fn put(&self, place: &Path, text: &str) -> Result<(), FleetError> {
        let folder = place.parent().unwrap_or(&self.folder);
        let write = || -> io::Result<()> {
            fs::create_dir_all(folder)?;
            let mut partial = tempfile::Builder::new()
                .prefix(".partial-")
                .tempfile_in(folder)?;
            io::Write::write_all(&mut partial, text.as_bytes())?;
            partial.persist(place).map_err(|e| e.error)?;
            Ok(())
        };
        write().map_err(|e| FleetError::not_written(place, &e))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fleet::item::{Done, ItemOutcome};

    const KEY: &str = "ab12";

    #[test]
    fn what_is_kept_is_read_and_what_is_torn_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::<ItemOutcome>::open(&folder.path().join("items")).unwrap();
        assert_eq!(store.read(KEY), None);
        let done = ItemOutcome::Done(Done::default());
        store.begin(KEY, 0).unwrap();
        assert_eq!(store.abandoned(KEY), 1);
        store.keep(KEY, &done).unwrap();
        assert_eq!(
            (store.read(KEY), store.abandoned(KEY)),
            (Some(done.clone()), 0)
        );
        let place = folder.path().join("items/ab/ab12.json");
        fs::copy(&place, folder.path().join("items/ab/ab34.json")).unwrap();
        assert_eq!(store.read("ab34"), None, "the result of another item");
        let whole = fs::read(&place).unwrap();
        fs::write(&place, &whole[..whole.len() - 3]).unwrap();
        assert_eq!(store.read(KEY), None);
        store.keep(KEY, &done).unwrap();
        let names = fs::read_dir(folder.path().join("items/ab")).unwrap();
        assert_eq!(names.count(), 2, "nothing else is left");
    }

    #[test]
    fn abandoned_attempts_are_counted() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::<ItemOutcome>::open(folder.path()).unwrap();
        store.begin(KEY, 0).unwrap();
        store.begin(KEY, store.abandoned(KEY)).unwrap();
        assert_eq!(store.abandoned(KEY), 2);
        store.give_up(KEY, 1);
        assert_eq!(store.abandoned(KEY), 1);
        store.give_up(KEY, 0);
        assert_eq!(store.abandoned(KEY), 0);
    }
}
