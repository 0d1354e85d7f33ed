//! Manifests of three formats say the same, and faults have their place.

use super::*;
use crate::fault::Fault;
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use std::fs;
use std::sync::Arc;

const CSV: &str = "robot,type,recordings,problem,time\n\
                   r1,small,a.csv;b.csv,p.toml,86400\n\
                   r2,,c.csv,p.toml,1970-01-03\n";

const TOML: &str = "[[item]]\nrobot = 'r1'\ntype = 'small'\nrecordings = ['a.csv', 'b.csv']\nproblem = 'p.toml'\ntime = 86400\n\
                    [[item]]\nrobot = 'r2'\nrecordings = 'c.csv'\nproblem = 'p.toml'\ntime = 1970-01-03\n";

fn parquet_file(path: &Path) {
    let schema = "message m { required binary robot (UTF8); optional binary type (UTF8); required binary recordings (UTF8); \
                  required binary problem (UTF8); required double time; }";
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let file = fs::File::create(path).unwrap();
    let mut writer = SerializedFileWriter::new(file, schema, Arc::default()).unwrap();
    let mut group = writer.next_row_group().unwrap();
    let texts: [(&[&str], Option<&[i16]>); 4] = [
        (&["r1", "r2"], None),
        (&["small"], Some(&[1, 0])),
        (&["a.csv;b.csv", "c.csv"], None),
        (&["p.toml", "p.toml"], None),
    ];
    for (values, levels) in texts {
        let mut column = group.next_column().unwrap().unwrap();
        let values: Vec<ByteArray> = values.iter().map(|v| ByteArray::from(*v)).collect();
        column
            .typed::<ByteArrayType>()
            .write_batch(&values, levels, None)
            .unwrap();
        column.close().unwrap();
    }
    let mut column = group.next_column().unwrap().unwrap();
    column
        .typed::<DoubleType>()
        .write_batch(&[86_400.0, 172_800.0], None, None)
        .unwrap();
    column.close().unwrap();
    group.close().unwrap();
    writer.close().unwrap();
}

#[test]
fn three_formats_say_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("m.csv"), CSV).unwrap();
    fs::write(at("m.toml"), TOML).unwrap();
    parquet_file(&at("m.parquet"));
    let read = |name: &str| -> Vec<Entry> {
        Manifest::open(&at(name))
            .unwrap()
            .map(Result::unwrap)
            .collect()
    };
    let items = read("m.csv");
    assert_eq!(items, read("m.toml"));
    assert_eq!(items, read("m.parquet"));
    assert_eq!(items[0].recordings, [at("a.csv"), at("b.csv")]);
    assert_eq!(
        (items[1].kind.as_str(), items[1].time, items[1].position),
        ("p.toml", 172_800.0, 1)
    );
    assert_eq!(items[0].verb, Verb::Fit);
}

#[test]
fn faults_name_the_line_and_the_column() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.csv");
    for (text, code) in [
        (
            "robot,recordings,problem\nr,a.csv,p.toml\n",
            "manifest-column-missing",
        ),
        (
            "robot,recording,problem,time\nr,a.csv,p.toml,1\n",
            "manifest-column-unknown",
        ),
        (
            "robot,recordings,problem,time\nr,a.csv,p.toml,soon\n",
            "manifest-cell",
        ),
        (
            "robot,recordings,problem,time\n,a.csv,p.toml,1\n",
            "manifest-cell",
        ),
        (
            "robot,recordings,problem,time,verb\nr,a.csv,p.toml,1,fly\n",
            "manifest-cell",
        ),
        (
            "robot,recordings,problem,time\nr,a.csv\n",
            "manifest-not-parsed",
        ),
    ] {
        fs::write(&path, text).unwrap();
        let fault = match Manifest::open(&path) {
            Err(fault) => fault,
            Ok(mut manifest) => manifest.next().unwrap().unwrap_err(),
        };
        assert_eq!(fault.describe().code, code, "{fault}");
        if code == "manifest-cell" {
            assert!(fault.to_string().contains("m.csv:2: "), "{fault}");
        }
    }
    let other = Manifest::open(&folder.path().join("m.xlsx")).err().unwrap();
    assert_eq!(other.describe().code, "unknown-manifest");
    let absent = Manifest::open(&folder.path().join("none.csv"))
        .err()
        .unwrap();
    assert_eq!(absent.describe().code, "manifest-not-readable");
}
