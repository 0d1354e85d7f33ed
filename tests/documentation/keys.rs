//! Every key of problem files is documented: meaning, type, unit where it is a quantity, default, example.

use exid::problem_file::KEYS;
use exid::problem_file::key::{Form, Key, Range, sections};

/// Numbers without a unit: ratios, shares, relative deviations, orders, directions.
const DIMENSIONLESS: &[&str] = &[
    "torque_constant_std",
    "ratio",
    "coupling",
    "axis",
    "normal",
    "per_turn",
    "strength",
    "accuracy",
];

/// Whether the key holds numbers that are not counts.
fn is_numeric(form: &Form) -> bool {
    match form {
        Form::Number(range) | Form::PerJoint(range) => {
            !matches!(range, Range::Probability | Range::Correlation)
        }
        Form::List(item, _) | Form::Named(item) => is_numeric(item),
        Form::Either(forms) => forms.iter().any(is_numeric),
        _ => false,
    }
}

/// Whether the key opens a table with keys of its own, which have the examples.
fn is_table(form: &Form) -> bool {
    match form {
        Form::Table(_) | Form::NamedTables(_) => true,
        Form::List(item, _) | Form::Named(item) => is_table(item),
        _ => false,
    }
}

fn lacks(key: &Key) -> Vec<&'static str> {
    let mut lacks = Vec::new();
    if key.meaning.split_whitespace().count() < 2 {
        lacks.push("meaning");
    }
    if key.default.is_empty() {
        lacks.push("default");
    }
    if key.example.is_empty() && !is_table(&key.form) {
        lacks.push("example");
    }
    if key.unit.is_empty() && is_numeric(&key.form) && !DIMENSIONLESS.contains(&key.name) {
        lacks.push("unit");
    }
    lacks
}

#[test]
fn every_key_is_documented() {
    let mut faults = Vec::new();
    let mut count = 0;
    for section in sections(KEYS) {
        for key in section.keys {
            count += 1;
            let lacks = lacks(key);
            if !lacks.is_empty() {
                faults.push(format!(
                    "{} {}: no {}",
                    section.header,
                    key.name,
                    lacks.join(", ")
                ));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(count > 150, "{count} keys");
}
