//! Any bytes as a compressed recording: as they are, or as the text of a stream that is cut off.
#![no_main]

use flate2::Compression;
use flate2::write::GzEncoder;
use libfuzzer_sys::fuzz_target;
use std::io::Write;

fuzz_target!(|bytes: &[u8]| {
    let Some((&choice, rest)) = bytes.split_first() else {
        return;
    };
    if choice == 0 {
        exid_fuzz::recording::is_sound(".csv.gz", rest);
        return;
    }
    let mut out = GzEncoder::new(Vec::new(), Compression::fast());
    out.write_all(rest).unwrap();
    let mut whole = out.finish().unwrap();
    // The largest choice keeps the whole stream.
    whole.truncate(whole.len() * usize::from(choice) / 255);
    exid_fuzz::recording::is_sound(".csv.gz", &whole);
});
