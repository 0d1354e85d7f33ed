//! Files that give no text, or none of TOML.

use std::fs;
use std::path::Path;

use super::EFFECTS;
use crate::fault::Fault;
use crate::problem_file::{ProblemFile, ProblemFileError};

fn read(path: &Path) -> ProblemFileError {
    ProblemFile::read(path, &[], EFFECTS).unwrap_err()
}

#[test]
fn files_that_cannot_be_read_have_their_own_codes() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        path
    };
    let absent = folder.path().join("absent.toml");
    let below_a_file = write("file.toml", b"x = 1").join("p.toml");
    for (path, code) in [
        (absent, "file-missing"),
        (below_a_file, "file-missing"),
        (folder.path().to_path_buf(), "file-is-directory"),
        (write("empty.toml", b""), "empty-file"),
        (write("blank.toml", b"\xef\xbb\xbf \n\t\n"), "empty-file"),
    ] {
        let error = read(&path);
        assert_eq!(error.describe().code, code, "{}", path.display());
        assert_eq!(error.place().file, path);
        assert_eq!(error.place().line, None);
    }
}

#[test]
fn bytes_that_are_no_text_are_shown_at_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.toml");
    fs::write(&path, b"[robot]\nurdf = \"\xc3\xa9\xff\"\n").unwrap();
    let error = read(&path);
    assert_eq!(error.describe().code, "not-utf8");
    assert!(error.describe().message.contains("0xff"));
    // The two bytes of the letter before it are one column.
    assert_eq!(
        (error.place().line, error.place().column),
        (Some(2), Some(10))
    );
}

#[cfg(unix)]
#[test]
fn a_file_without_permission_says_so() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.toml");
    fs::write(&path, "[robot]\nurdf = \"r.urdf\"").unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o000)).unwrap();
    // The superuser may read everything; then there is no fault to show.
    match (fs::read(&path), ProblemFile::read(&path, &[], EFFECTS)) {
        (Ok(_), result) => assert!(result.is_ok()),
        (Err(_), result) => {
            assert_eq!(result.unwrap_err().describe().code, "permission-denied");
        }
    }
}

#[test]
fn a_byte_order_mark_and_carriage_returns_are_no_fault() {
    let text = "\u{feff}[robot]\r\nurdf = \"r.urdf\"\r\n";
    assert!(super::parse(text, &[]).is_ok());
}

#[test]
fn deep_nesting_is_an_error_and_no_overflow() {
    let deep = format!("a = {}", "[".repeat(200_000));
    assert_eq!(
        super::parse(&deep, &[]).unwrap_err().describe().code,
        "syntax"
    );
    let dotted = format!("{}a = 1", "a.".repeat(500_000));
    assert!(super::parse(&dotted, &[]).is_err());
}
