//! The schema of problem files against the reader: what one takes the other takes, key by key.

use exid::chain::effect;
use exid::fault::Fault;
use exid::problem_file::key::{Form, Key, REQUIRED, sections};
use exid::problem_file::{KEYS, ProblemFile, ProblemFileError, reference, schema};
use jsonschema::Validator;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

fn validator() -> Validator {
    let schema = schema::schema(&effect::ids());
    assert!(jsonschema::meta::is_valid(&schema));
    jsonschema::validator_for(&schema).unwrap()
}

/// What stands before every setting.
const BASE: &str = "[robot]\nurdf = \"r.urdf\"\n[recordings]\ntrain = [\"train.csv\"]\n";

fn parse(base: &str, settings: &[String]) -> Result<ProblemFile, ProblemFileError> {
    ProblemFile::parse(Path::new("p.toml"), base, settings, &effect::ids())
}

/// Settings without which a key cannot stand, and the base where it is another.
fn companions(path: &str) -> (&'static str, &'static [&'static str]) {
    const RECORDINGS: &str = "[recordings]\ntrain = [\"train.csv\"]\n[robot]\n";
    const H4: &str = "[recordings]\ntrain = [\"train.csv\"]\n[robot]\nmechanism = \"h4\"\n";
    match path {
        "robot.mdh" | "robot.mjcf" | "robot.mechanism" => (RECORDINGS, &[]),
        "robot.h4" => (H4, &[]),
        "recordings.loaded" => (BASE, &["robot.payload=last"]),
        "fit.feasible_by" | "fit.prior.kind" => (BASE, &["fit.estimator=feasible"]),
        "fit.prior.strength" => (BASE, &["fit.estimator=feasible", "fit.prior.kind=entropic"]),
        path if path.starts_with("controller") => (BASE, &["recordings.signal=position_command"]),
        path if path.starts_with("recordings.platform.") => (BASE, &["recordings.platform={}"]),
        _ => (BASE, &[]),
    }
}

/// A key, the base it stands on, and the settings that give it a value.
struct Setting {
    key: &'static Key,
    path: String,
    base: &'static str,
    /// Before the value, and after it.
    around: [String; 2],
    companions: Vec<String>,
}

impl Setting {
    fn with(&self, value: &str) -> Vec<String> {
        let [before, after] = &self.around;
        let mut settings = self.companions.clone();
        settings.push(format!("{before}{value}{after}"));
        settings
    }
}

/// Every key that has values of its own.
fn settings() -> Vec<Setting> {
    let mut all = Vec::new();
    for section in sections(KEYS) {
        for key in section.keys.iter().filter(|key| !key.example.is_empty()) {
            all.push(setting(&section.path, section.keys, key));
        }
    }
    assert!(all.len() > 120, "{}", all.len());
    all
}

fn setting(path: &[&'static str], keys: &'static [Key], key: &'static Key) -> Setting {
    let dotted = [path, &[key.name]].concat().join(".");
    let siblings = keys
        .iter()
        .filter(|k| k.default == REQUIRED && k.name != key.name);
    let siblings = siblings.filter(|k| !k.example.is_empty());
    let (base, further) = companions(&match path {
        ["robot", "h4"] => "robot.h4".to_owned(),
        _ => dotted.clone(),
    });
    let mut companions: Vec<String> = further.iter().map(|s| (*s).to_owned()).collect();
    let mut among = KEYS;
    let mut prefix: Vec<&str> = Vec::new();
    let mut around = [String::new(), String::new()];
    for part in path {
        prefix.push(part);
        let found = among.iter().find(|k| k.name == *part).unwrap();
        match &found.form {
            Form::Table(below) => {
                among = below;
                continue;
            }
            Form::List(Form::Table(below), _) if *path != prefix => {
                around = ["[{ ".into(), " }]".into()];
                let further = below.iter().filter(|k| k.default == REQUIRED);
                for k in further {
                    around[0].push_str(&format!("{} = {}, ", k.name, k.example));
                }
                let inner = path[prefix.len()..].join(".");
                around[0].push_str(&format!("{inner} = {{ first = {{ "));
                around[1].insert_str(0, " } }");
            }
            Form::List(..) => around = ["[{ ".into(), " }]".into()],
            Form::Either(_) => around = ["{ ".into(), " }".into()],
            Form::Named(_) | Form::NamedTables(_) => {
                around = ["{ first = { ".into(), " } }".into()]
            }
            _ => unreachable!("{dotted}"),
        }
        break;
    }
    if around[0].is_empty() {
        companions.extend(siblings.map(|k| format!("{}.{}={}", path.join("."), k.name, k.example)));
        companions.retain(|setting| !setting.starts_with('.'));
        around[0] = format!("{dotted}=");
    } else {
        let mut siblings: String = siblings
            .map(|k| format!("{} = {}, ", k.name, k.example))
            .collect();
        if key.name == "per_turn" {
            siblings.push_str("unit = \"count\", ");
        }
        if key.name == "share_of" {
            siblings.push_str("search = [0.5], ");
        }
        around[0] = format!(
            "{}={}{siblings}{} = ",
            prefix.join("."),
            around[0],
            key.name
        );
    }
    Setting {
        key,
        path: dotted,
        base,
        around,
        companions,
    }
}

/// A problem as JSON, in which tools write what is infinite as null.
fn as_json(problem: &Value) -> Value {
    match problem {
        Value::String(text) if ["inf", "-inf", "NaN"].contains(&text.as_str()) => Value::Null,
        Value::Array(items) => items.iter().map(as_json).collect(),
        Value::Object(entries) => {
            let entries = entries
                .iter()
                .map(|(key, value)| (key.clone(), as_json(value)));
            Value::Object(entries.collect())
        }
        other => other.clone(),
    }
}

#[test]
fn every_key_takes_its_example_in_reader_and_schema() {
    let validator = validator();
    for setting in settings() {
        let settings = setting.with(setting.key.example);
        let read = parse(setting.base, &settings);
        let problem = read.unwrap_or_else(|e| panic!("{settings:?}: {e}"));
        let found: Vec<String> = validator
            .iter_errors(&as_json(&problem.json))
            .map(|e| e.to_string())
            .collect();
        assert!(found.is_empty(), "{settings:?}: {found:?}");
    }
}

/// Values of every form, right for some keys and wrong for others.
const VALUES: &[&str] = &[
    "true",
    "-1",
    "0",
    "1",
    "0.5",
    "2.5",
    "inf",
    "\"x\"",
    "\" \"",
    "[]",
    "[1]",
    "[-1.5]",
    "[true]",
    "[\"a\"]",
    "[\"a\", \"a\"]",
    "[\"a\", \"b\"]",
    "[[1.0]]",
    "[[\"a\"]]",
    "[0, 0, 1]",
    "[1, 2, 3, 4]",
    "{}",
    "{ a = 1 }",
    "{ a = -1 }",
    "{ a = \"x\" }",
    "{ a = [\"time_delay\"] }",
    "[{}]",
    "[\"time_delay\"]",
    "{ column = 1 }",
    "{ a = { value = 1, std_dev = 1 } }",
    "[0]",
    "2000000",
    "[0, 1]",
];

/// Faults that lie between keys or entries, of which a schema knows nothing.
const BETWEEN: &[&str] = &[
    "conflict",
    "missing-key",
    "lower-above-upper",
    "not-a-folder-name",
    "cutoff-above-nyquist",
    // The law of this name may stand elsewhere in the file.
    "unknown-effect",
    // An axis of three zeros; rows of a matrix that is not square; a name with dots and no quotes.
    "zero",
    "wrong-length",
    "unquoted-name",
];

#[test]
fn reader_and_schema_refuse_the_same_values() {
    let validator = validator();
    let mut faults = Vec::new();
    let mut refused = 0;
    for setting in settings() {
        for value in VALUES {
            let settings = setting.with(value);
            // A key that is not there fails nothing else: the reader stops before it has the JSON.
            let json = match json_of(setting.base, &settings) {
                Some(json) => json,
                None => continue,
            };
            let valid = validator.is_valid(&json);
            match parse(setting.base, &settings) {
                // The lengths of a mechanism are read with the robot.
                Ok(_) if setting.path.starts_with("robot.h4.") => {}
                // Files of laws are read with the problem.
                Err(_) if setting.path == "laws" && valid => refused += 1,
                Ok(_) if !valid => {
                    faults.push(format!("{}: {value}: the schema refuses it", setting.path))
                }
                Err(error) if valid && !BETWEEN.contains(&error.describe().code) => {
                    faults.push(format!(
                        "{}: {value}: the schema takes it: {error}",
                        setting.path
                    ));
                }
                Err(_) => refused += 1,
                Ok(_) => {}
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(refused > 1000, "{refused}");
}

/// What a TOML of these settings is as JSON.
fn json_of(base: &str, settings: &[String]) -> Option<Value> {
    let mut root: toml::Table = toml::from_str(base).unwrap();
    for setting in settings {
        let (path, value) = setting.split_once('=')?;
        let parsed: Result<toml::Table, _> = toml::from_str(&format!("value = {value}"));
        // A bare word is a text.
        let value = parsed.map_or_else(
            |_| toml::Value::String(value.to_owned()),
            |mut t| t.remove("value").unwrap(),
        );
        let parts: Vec<&str> = path.split('.').collect();
        let (last, parents) = parts.split_last()?;
        let mut table = &mut root;
        for part in parents {
            let below = table
                .entry(*part)
                .or_insert_with(|| toml::Value::Table(toml::Table::new()));
            table = below.as_table_mut()?;
        }
        table.insert((*last).to_owned(), value);
    }
    serde_json::to_value(root).ok()
}

/// What was read, without where it stands.
fn without_places(problem: &ProblemFile) -> String {
    let ProblemFile {
        name,
        robot,
        drive,
        recordings,
        fit,
        design,
        simulate,
        diagnose,
        ..
    } = problem;
    let text = format!(
        "{name:?} {robot:?} {drive:?} {recordings:?} {fit:?} {design:?} {simulate:?} {diagnose:?}"
    );
    let mut rest = text.as_str();
    let mut out = String::new();
    while let Some((before, after)) = rest.split_once("place: Place {") {
        out.push_str(before);
        rest = after.split_once('}').unwrap().1;
    }
    out + rest
}

#[test]
fn defaults_are_those_of_the_reader() {
    let mut stated = 0;
    for setting in settings() {
        let is_value =
            toml::from_str::<toml::Table>(&format!("value = {}", setting.key.default)).is_ok();
        // In a list of tables the rest of the table is not there without the key.
        if !is_value || !setting.around[1].is_empty() {
            continue;
        }
        stated += 1;
        let with = parse(setting.base, &setting.with(setting.key.default)).unwrap();
        let without = parse(setting.base, &setting.companions).unwrap();
        assert_eq!(
            without_places(&with),
            without_places(&without),
            "{}",
            setting.path
        );
    }
    assert!(stated > 25, "{stated}");
}

/// Every problem file of the repository that is one.
fn shipped() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut folders = ["problems", "tests", "examples"]
        .map(|f| root.join(f))
        .to_vec();
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if path.is_dir() {
                folders.push(path);
            } else if name.ends_with(".toml") && !name.ends_with(".mdh.toml") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

#[test]
fn shipped_problems_pass() {
    let validator = validator();
    let shipped = shipped();
    assert!(shipped.len() >= 20, "{}", shipped.len());
    for path in shipped {
        let text = fs::read_to_string(&path).unwrap();
        // Files of tests in which folders are filled in are no TOML before.
        let Ok(problem) = toml::from_str::<toml::Table>(&text) else {
            assert!(text.contains("{data}"), "{}", path.display());
            continue;
        };
        let json = serde_json::to_value(problem).unwrap();
        let faults: Vec<String> = validator
            .iter_errors(&json)
            .map(|e| e.to_string())
            .collect();
        assert!(faults.is_empty(), "{}: {faults:?}", path.display());
    }
}

#[test]
fn reference_has_every_key_with_its_meaning() {
    let text = reference::markdown();
    for section in sections(KEYS) {
        for key in section.keys {
            let row = format!("| `{}` | ", key.name);
            assert!(text.contains(&row), "{row}");
            assert!(
                !key.meaning.is_empty() && !key.meaning.ends_with('.'),
                "{}",
                key.name
            );
            assert!(!key.default.is_empty(), "{}", key.name);
        }
    }
    let cells = |line: &str| line.replace("\\|", "").matches('|').count();
    let rows = text.lines().filter(|line| line.starts_with('|'));
    assert!(rows.clone().all(|row| cells(row) == 7), "{text}");
}
