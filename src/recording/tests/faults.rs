//! Files that cannot be read: each fault has its code and its place.

use super::{HEADER, gzip, read_content, rows};
use crate::fault::Fault;

/// Code, file name, content and part of the place of each fault.
type FileFault = (&'static str, &'static str, Vec<u8>, &'static str);

fn file_faults() -> Vec<FileFault> {
    let good = rows(HEADER, ',');
    let with = |from: &str, to: &str| good.replace(from, to).into_bytes();
    let row = "5,105,205,305,405";
    vec![
        ("empty-file", "a.csv", Vec::new(), "a.csv"),
        (
            "no-header",
            "a.csv",
            with(&format!("{HEADER}\n"), ""),
            "a.csv:1",
        ),
        ("duplicate-column", "a.csv", with("q2", "q1"), "a.csv:1:3"),
        ("missing-column", "a.csv", with("q2", "q_2nd"), "a.csv: q2"),
        (
            "wrong-field-count",
            "a.csv",
            with(row, "5,105,205"),
            "a.csv:7",
        ),
        ("wrong-field-count", "a.csv", with(row, ""), "a.csv:7"),
        (
            "not-a-number",
            "a.csv",
            with(row, "5,105,x,305,405"),
            "a.csv:7:3: q2",
        ),
        (
            "not-finite",
            "a.csv",
            with(row, "5,1e999,205,305,405"),
            "a.csv:7:2: q1",
        ),
        (
            "nul-byte",
            "a.csv",
            with(row, "5,10\0,205,305,405"),
            "a.csv:7",
        ),
        (
            "not-a-number",
            "a.csv",
            [good.as_bytes(), b"\xff\n"].concat(),
            "a.csv:32:1: t",
        ),
    ]
}

/// Faults of the file as a whole: its length, its name, its compression.
fn whole_faults() -> Vec<FileFault> {
    let good = rows(HEADER, ',');
    let zipped = gzip(good.as_bytes());
    let mut corrupt = zipped.clone();
    // The check sum stands eight bytes before the end.
    let check = corrupt.len() - 8;
    corrupt[check] ^= 0xff;
    let short: String = good
        .lines()
        .take(10)
        .map(|line| format!("{line}\n"))
        .collect();
    vec![
        ("line-too-long", "a.csv", vec![b'x'; 3 << 20], "a.csv:1"),
        ("too-few-rows", "a.csv", short.into_bytes(), "a.csv"),
        (
            "unknown-extension",
            "a.xlsx",
            good.clone().into_bytes(),
            "a.xlsx",
        ),
        (
            "truncated-gzip",
            "a.csv.gz",
            zipped[..zipped.len() - 12].to_vec(),
            "a.csv.gz:",
        ),
        ("corrupt-gzip", "a.csv.gz", corrupt, "a.csv.gz:"),
        (
            "corrupt-gzip",
            "a.csv.gz",
            good.clone().into_bytes(),
            "a.csv.gz:1",
        ),
    ]
}

#[test]
fn every_fault_of_a_file_has_its_code_and_place() {
    for (code, name, content, place) in file_faults().into_iter().chain(whole_faults()) {
        let error = read_content(name, &content).unwrap_err();
        assert_eq!(error.describe().code, code, "{error}");
        let shown = error.to_string();
        assert!(shown.contains(place), "{shown} has no {place}");
    }
}
