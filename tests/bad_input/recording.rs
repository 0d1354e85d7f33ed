//! Recordings that break: the file, its table, its time, and what the problem file wants of it.

use crate::bench::Bench;
use crate::{Case, case};
use flate2::Compression;
use flate2::write::GzEncoder;
use std::fs;
use std::io::{self, Read, Write};

/// Compresses the recording, under a name that says so.
fn compress(bench: &Bench) -> Vec<u8> {
    let text = fs::read(bench.path("train.csv")).unwrap();
    bench.call_recording("train.csv.gz");
    let mut out = GzEncoder::new(Vec::new(), Compression::fast());
    out.write_all(&text).unwrap();
    out.finish().unwrap()
}

/// A text and then a gigabyte of one letter, compressed.
fn gigabyte(text: &str, letter: u8) -> Vec<u8> {
    let mut out = GzEncoder::new(Vec::new(), Compression::fast());
    out.write_all(text.as_bytes()).unwrap();
    io::copy(&mut io::repeat(letter).take(1 << 30), &mut out).unwrap();
    out.finish().unwrap()
}

/// Adds a key to `[recordings]`.
fn key(bench: &Bench, text: &str) {
    let train = "train = [\"train.csv\"]";
    bench.problem(train, &format!("{train}\n{text}"));
}

/// Lines of the recording from one on, with its time from 0 and six decimals.
fn piece(bench: &Bench, name: &str, from: usize) {
    let text = fs::read_to_string(bench.path("train.csv")).unwrap();
    let mut lines = text.lines();
    let mut out = lines.next().unwrap().to_string();
    for (k, line) in lines.skip(from - 1).enumerate() {
        let fields = line.split(',').skip(1);
        let numbers = fields.map(|x| format!("{:.6}", x.parse::<f64>().unwrap()));
        let numbers: Vec<String> = numbers.collect();
        out.push_str(&format!("\n{:.2},{}", 0.01 * k as f64, numbers.join(",")));
    }
    bench.write(name, out + "\n");
}

/// Repeats every second value of the first signal and every third of the other.
fn held_apart(lines: &mut [String]) {
    let kept = lines.to_vec();
    for (k, line) in lines.iter_mut().enumerate().skip(1) {
        let field = |row: usize, field: usize| kept[row].split(',').nth(field).unwrap();
        let (second, third) = ((k - 1) / 2 * 2 + 1, (k - 1) / 3 * 3 + 1);
        let own = [0, 1, 2].map(|at| field(k, at)).join(",");
        *line = format!("{own},{},{}", field(second, 3), field(third, 4));
    }
}

/// Files that are no table.
#[rustfmt::skip]
pub const FILE_CASES: &[Case] = &[
    case("no recording", 3, ["none.csv: ", "no such file", "relative to that file"], |b| b.problem("train.csv", "none.csv")),
    case("a directory for a recording", 3, ["runs.csv: ", "this is a directory", "name a recording inside"], |b| { b.folder("runs.csv"); b.problem("train.csv", "runs.csv"); }),
    case("a recording nobody may read", 3, ["train.csv: ", "may not be read", "permission"], |b| b.forbid("train.csv", 0o000)),
    case("an unknown extension", 3, ["train.xlsx: ", "\".xlsx\"", "convert the recording to one of .csv"], |b| b.call_recording("train.xlsx")),
    case("an empty recording", 3, ["train.csv: ", "the file is empty", "header line"], |b| b.write("train.csv", "")),
    case("a header alone", 3, ["train.csv: ", "0 rows", "at least 20"], |b| b.recording(|lines| lines.truncate(1))),
    case("too few rows", 3, ["train.csv: ", "19 rows", "at least 20"], |b| b.recording(|lines| lines.truncate(20))),
    case("no header", 3, ["train.csv:1: ", "holds numbers", "name of every column first"], |b| b.recording(|lines| { lines.remove(0); })),
    case("a gigabyte of zeros", 3, ["train.csv:1: ", "NUL byte", "export the recording again"], |b| b.sparse("train.csv", 1 << 30)),
    case("zeros after the header", 3, ["train.csv:2: ", "NUL byte", "export the recording again"], |b| { b.recording(|lines| lines.truncate(1)); fs::OpenOptions::new().write(true).open(b.path("train.csv")).unwrap().set_len(1 << 30).unwrap(); }),
    case("a gigabyte without a line end", 3, ["train.csv.gz:1: ", "longer than 1048576 bytes", "what its name says"], |b| { b.call_recording("train.csv.gz"); b.write("train.csv.gz", gigabyte("", b'x')); }),
    case("a gigabyte of empty lines", 3, ["train.csv.gz", "is empty", "header line"], |b| { b.call_recording("train.csv.gz"); b.write("train.csv.gz", gigabyte("", b'\n')); }),
    case("rows and a gigabyte of empty lines", 3, ["train.csv.gz:3: ", "0 fields and the header 5", "remove it"], |b| { b.call_recording("train.csv.gz"); b.write("train.csv.gz", gigabyte("t,q1,q2,i1,i2\n0,0,0,0,0\n", b'\n')); }),
    case("a recording without end", 3, ["zero.csv: ", "a pipe or a device", "to a file"], |b| { std::os::unix::fs::symlink("/dev/zero", b.path("zero.csv")).unwrap(); b.problem("train.csv", "zero.csv"); }),
    case("a recording in Latin-1 without the columns", 3, ["train.csv: q", "Zeit f\u{fc}r, q1", "q1"], |b| b.write("train.csv", b"Zeit f\xfcr;q1\n")),
    case("compressed data cut off", 3, ["train.csv.gz:", "end before their end mark", "copy or compress"], |b| { let all = compress(b); b.write("train.csv.gz", &all[..all.len() / 2]); }),
    case("no compressed data", 3, ["train.csv.gz:1: ", "invalid gzip header", "drop .gz"], |b| b.call_recording("train.csv.gz")),
    case("compressed data that are damaged", 3, ["train.csv.gz:", "checksum", "compress it again"], |b| {
        let mut all = compress(b);
        // The last eight bytes are checksum and length of what was compressed.
        let sum = all.len() - 8;
        all[sum] ^= 1;
        b.write("train.csv.gz", all);
    }),
];

/// Tables that break, and tables that do not fit what is said of them.
#[rustfmt::skip]
pub const CASES: &[Case] = &[
    case("a missing column", 3, ["train.csv: i2", "current of joint elbow", "present are t, q1, q2, i1, j2"], |b| b.recording(|lines| lines[0] = "t,q1,q2,i1,j2".into())),
    case("a missing column with a pattern", 3, ["train.csv: pos1", "\"pos1\" for the position of joint shoulder", "[recordings.columns]"], |b| key(b, "columns = { position = \"pos{n}\" }")),
    case("a missing mask", 3, ["train.csv: ok", "\"ok\" for the mask", "present are"], |b| key(b, "columns = { mask = \"ok\" }")),
    case("two columns of one name", 3, ["train.csv:1:3: ", "\"q1\"", "its own name"], |b| b.recording(|lines| lines[0] = "t,q1,q1,i1,i2".into())),
    case("a row with too few fields", 3, ["train.csv:7: ", "4 fields and the header 5", "complete the row"], |b| b.recording(|lines| lines[6] = "0.05,1,1,1".into())),
    case("a row with too many fields", 3, ["train.csv:9: ", "6 fields and the header 5", "complete the row"], |b| b.recording(|lines| lines[8] = "0.07,1,1,1,1,1".into())),
    case("a row cut off at the end", 3, ["train.csv:801: ", "2 fields and the header 5", "complete the row"], |b| b.recording(|lines| lines[800] = "7.99,1.0".into())),
    case("an empty line between rows", 3, ["train.csv:30: ", "0 fields and the header 5", "complete the row"], |b| b.recording(|lines| lines.insert(29, String::new()))),
    case("a decimal comma", 3, ["train.csv:2: ", "9 fields and the header 5", "complete the row"], |b| b.recording(|lines| lines[1..].iter_mut().for_each(|line| *line = line.replacen('.', ",", 4)))),
    case("text in a number", 3, ["train.csv:12:3: q2", "\"off\"", "decimal point"], |b| b.field(12, 2, "off")),
    case("a column without a number", 3, ["train.csv: i1", "none of its 800 rows", "name another column"], |b| b.recording(|lines| lines[1..].iter_mut().for_each(|line| { let mut fields: Vec<&str> = line.split(',').collect(); fields[3] = "nan"; *line = fields.join(","); }))),
    case("two thirds of the rows without a number", 3, ["train.csv: i2", "534 of 800 rows", "exid joins them by time"], |b| b.recording(|lines| (1..lines.len()).filter(|k| k % 3 > 0).for_each(|k| lines[k] = format!("{},", lines[k].rsplit_once(',').unwrap().0)))),
    case("an infinite number", 3, ["train.csv:401:5: i2", "value is -inf", "leave the cell empty"], |b| b.field(401, 4, "-inf")),
    case("a number beyond all numbers", 3, ["train.csv:402:5: i2", "value is 1e999", "leave the cell empty"], |b| b.field(402, 4, "1e999")),
    case("time that jumps back", 3, ["train.csv:62: time", "0.4 s does not come after 0.59 s", "sort or remove"], |b| b.field(62, 0, "0.40")),
    case("time that stands still", 3, ["train.csv:63: time", "0.6 s does not come after 0.6 s", "sort or remove"], |b| b.field(63, 0, "0.60")),
    case("one stamp in another unit", 3, ["train.csv:801: time", "7992", "split the recording"], |b| b.field(801, 0, "8000")),
    case("no time and no rate", 3, ["train.csv: ", "neither a time column nor a rate", "recordings.rate"], |b| b.recording(|lines| lines[0] = "k,q1,q2,i1,i2".into())),
    case("a rate that contradicts the time", 3, ["train.csv: rate", "give 100.000000 Hz and the rate given is 250 Hz", "remove the rate"], |b| key(b, "rate = 250")),
    case("time in milliseconds", 3, ["train.csv: time", "look like milliseconds", "divide the time column by 1000"], |b| { key(b, "rate = 100"); b.recording(|lines| lines[1..].iter_mut().enumerate().for_each(|(k, line)| *line = format!("{}{}", 10 * k, &line[4..]))); }),
    case("a period longer than the file", 3, ["train.csv: period", "lasts 8.0000 s, less than one period of 12.5 s", "one whole period"], |b| key(b, "period = 12.5")),
    case("a cut-off above half of the rate found", 2, ["problem.toml:18:13: recordings.differentiation.cutoff_hz", "value is 51", "below 50.000000 Hz for train.csv"], |b| b.problem("12.0\n", "51.0\n")),
    case("a parallel filter above half of the rate found", 2, ["problem.toml:19:15: recordings.differentiation.parallel_hz", "value is 75", "below 50.000000 Hz for train.csv"], |b| b.problem("cutoff_hz = 12.0", "cutoff_hz = 12.0\nparallel_hz = 75")),
    case("too short for the filter", 3, ["train.csv", "25 samples leave nothing", "raise the cut-off"], |b| { b.recording(|lines| lines.truncate(26)); b.problem("cutoff_hz = 12.0", "cutoff_hz = 1.0"); }),
    case("a mask that leaves nothing", 3, ["train.csv", "leaves out too many", "samples with 0 are left out"], |b| { b.recording(|lines| { lines[0] += ",ok"; lines[1..].iter_mut().for_each(|line| line.push_str(",0")); }); key(b, "columns = { mask = \"ok\", current = \"i{n}\" }"); }),
    case("a pattern that names one column", 2, ["problem.toml:16:24: recordings.columns.position", "\"q1\"", "{n}"], |b| key(b, "columns = { position = \"q1\" }")),
    case("a pattern with an unknown placeholder", 2, ["problem.toml:16:23: recordings.columns.current", "{axis}", "use {joint}"], |b| key(b, "columns = { current = \"i{axis}\" }")),
    case("a column in two roles", 2, ["problem.toml: recordings.columns", "\"q1\" is asked for in two roles", "another column"], |b| key(b, "columns = { current = \"q{n}\" }")),
    case("a fault in the validation recording", 3, ["validation.csv:1: ", "holds numbers", "name of every column first"], |b| { b.write("validation.csv", "0,0,0,0,0\n"); key(b, "validation = [\"validation.csv\"]"); }),
    case("a held-out piece of the fitted run", 3, ["validation.csv:2: ", "5.0000 s of it (100.0 % of its samples) are also in train.csv", "leave recordings.validation out"], |b| { piece(b, "validation.csv", 301); key(b, "validation = [\"validation.csv\"]"); }),
    case("a run that is given twice", 3, ["again.csv:2: ", "(100.0 % of its samples) are given twice, also in train.csv", "remove one of the two"], |b| { piece(b, "again.csv", 1); b.problem("[\"train.csv\"]", "[\"train.csv\", \"again.csv\"]"); }),
    case("signals held at other instants than positions", 3, ["train.csv: ", "over 3.0000 rows and one over 2.0000", "at common instants"], |b| b.recording(|lines| held_apart(lines))),
];
