//! JSON Schema (draft 7, the newest that editors of TOML read) of problem files, from the tables of keys.
//!
//! It refuses no file that the reader takes. What one key says of another, such as one of `urdf`, `mdh` and `mechanism`, is
//! left to the reader.

use serde_json::{Map, Value, json};

use crate::problem_file::KEYS;
use crate::problem_file::key::{Form, Key, Length, REQUIRED, Range};

/// The schema, with the identifiers that lists of effects may hold.
pub fn schema(effect_ids: &[&str]) -> Value {
    let Value::Object(table) = of_table(KEYS, effect_ids) else {
        return Value::Null;
    };
    let mut schema = Map::new();
    schema.insert(
        "$schema".into(),
        "http://json-schema.org/draft-07/schema#".into(),
    );
    schema.insert("title".into(), "Problem file of exid".into());
    schema.extend(table);
    Value::Object(schema)
}

fn of_table(keys: &[Key], effect_ids: &[&str]) -> Value {
    let required: Vec<&str> = keys
        .iter()
        .filter(|key| key.default == REQUIRED)
        .map(|key| key.name)
        .collect();
    let properties: Map<String, Value> = keys
        .iter()
        .map(|key| (key.name.to_owned(), of_key(key, effect_ids)))
        .collect();
    let mut table = json!({
        "type": "object",
        "additionalProperties": false,
        "properties": properties,
    });
    if !required.is_empty() {
        table["required"] = json!(required);
    }
    table
}

fn of_key(key: &Key, effect_ids: &[&str]) -> Value {
    let mut schema = of_form(&key.form, effect_ids);
    schema["description"] = key.in_words().into();
    if let Some(default) = value(key.default) {
        schema["default"] = default;
    }
    if let Some(example) = value(key.example) {
        schema["examples"] = json!([example]);
    }
    schema
}

fn of_form(form: &Form, effect_ids: &[&str]) -> Value {
    let below = |form: &Form| of_form(form, effect_ids);
    match form {
        Form::Text | Form::File => json!({ "type": "string", "pattern": "\\S" }),
        Form::Boolean => json!({ "type": "boolean" }),
        Form::Number(range) => number(*range),
        Form::PerJoint(range) => {
            json!({ "anyOf": [number(*range), { "type": "array", "items": number(*range), "minItems": 1 }] })
        }
        Form::Count(least) => {
            json!({ "type": "integer", "minimum": least, "maximum": crate::problem_file::values::LARGEST_COUNT })
        }
        Form::Words(words) => json!({ "enum": words() }),
        // The law of a file has an identifier of its own.
        Form::Effect => {
            json!({ "anyOf": [{ "enum": effect_ids }, { "type": "string", "pattern": "\\S" }] })
        }
        Form::List(item, length) => {
            let mut list = json!({ "type": "array", "items": below(item) });
            let (least, most, is_distinct) = match length {
                Length::Any => (0, None, false),
                Length::Distinct => (0, None, true),
                Length::SomeDistinct => (1, None, true),
                Length::SeveralDistinct => (2, None, true),
                Length::Some => (1, None, false),
                Length::Exactly(count) => (*count, Some(*count), false),
                Length::OneOrTwo => (1, Some(2), false),
                Length::TwoDistinct => (2, Some(2), true),
            };
            if least > 0 {
                list["minItems"] = json!(least);
            }
            if let Some(most) = most {
                list["maxItems"] = json!(most);
            }
            if is_distinct {
                list["uniqueItems"] = json!(true);
            }
            list
        }
        Form::Table(keys) => of_table(keys, effect_ids),
        Form::Named(form) => of_names(below(form)),
        Form::NamedTables(keys) => of_names(of_table(keys, effect_ids)),
        Form::Either(forms) => {
            let forms: Vec<Value> = forms.iter().map(below).collect();
            json!({ "anyOf": forms })
        }
    }
}

fn of_names(value: Value) -> Value {
    json!({ "type": "object", "propertyNames": { "pattern": "\\S" }, "additionalProperties": value })
}

fn number(range: Range) -> Value {
    match range {
        // JSON has no infinity: tools that turn TOML into JSON write null.
        Range::Any => json!({ "type": ["number", "null"] }),
        Range::Finite => json!({ "type": "number" }),
        Range::Positive => json!({ "type": "number", "exclusiveMinimum": 0 }),
        Range::NonNegative => json!({ "type": "number", "minimum": 0 }),
        Range::Nonzero => json!({ "type": "number", "not": { "const": 0 } }),
        Range::Correlation => json!({ "type": "number", "minimum": 0, "exclusiveMaximum": 1 }),
        Range::Probability => {
            json!({ "type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1 })
        }
    }
}

/// The value that a text is as TOML; none of words, and of numbers that JSON does not hold.
fn value(text: &str) -> Option<Value> {
    let table: toml::Table = toml::from_str(&format!("value = {text}")).ok()?;
    serde_json::to_value(table.get("value")?).ok()
}
