//! Where two answers differ: the leaves of their JSON that are not the same, each with its path in words.

use serde_json::Value;

/// A leaf that two answers have differently.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Difference {
    /// Keys, and entries of lists by their name where they have one: `parameters[a1.Fc].value`.
    pub path: String,
    /// Null where only the second has it.
    pub first: Value,
    /// Null where only the first has it.
    pub second: Value,
}

/// Every leaf that differs, in the order of the first answer, then what only the second has.
pub fn differences(first: &Value, second: &Value) -> Vec<Difference> {
    let mut found = Vec::new();
    compare(String::new(), first, second, &mut found);
    found
}

fn compare(path: String, first: &Value, second: &Value, found: &mut Vec<Difference>) {
    match (first, second) {
        (Value::Object(a), Value::Object(b)) => {
            let only_second = b.keys().filter(|key| !a.contains_key(*key));
            for key in a.keys().chain(only_second) {
                let below = match path.as_str() {
                    "" => key.clone(),
                    path => format!("{path}.{key}"),
                };
                let of = |side: &'_ serde_json::Map<String, Value>| {
                    side.get(key).cloned().unwrap_or_default()
                };
                compare(below, &of(a), &of(b), found);
            }
        }
        (Value::Array(a), Value::Array(b)) => {
            for k in 0..a.len().max(b.len()) {
                let (x, y) = (a.get(k), b.get(k));
                let label = x.or(y).and_then(name).unwrap_or_else(|| k.to_string());
                let or_null = |side: Option<&Value>| side.cloned().unwrap_or_default();
                compare(format!("{path}[{label}]"), &or_null(x), &or_null(y), found);
            }
        }
        (first, second) if first != second => found.push(Difference {
            path,
            first: first.clone(),
            second: second.clone(),
        }),
        _ => {}
    }
}

/// What an entry of a list is called.
fn name(entry: &Value) -> Option<String> {
    let keys = ["name", "joint", "path", "expression"];
    let name = keys.iter().find_map(|key| entry.get(key))?;
    name.as_str().map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn leaves_are_named_by_their_entries() {
        let first =
            json!({"rank": 2, "parameters": [{"name": "a1.Fc", "value": 1.5}], "list": [1, 2]});
        let second = json!({"rank": 2, "parameters": [{"name": "a1.Fc", "value": 1.25}], "list": [1], "more": true});
        let found = differences(&first, &second);
        let paths: Vec<&str> = found.iter().map(|d| d.path.as_str()).collect();
        assert_eq!(paths, ["parameters[a1.Fc].value", "list[1]", "more"]);
        assert_eq!(
            (&found[0].first, &found[0].second),
            (&json!(1.5), &json!(1.25))
        );
        assert_eq!(
            (&found[1].first, &found[1].second),
            (&json!(2), &Value::Null)
        );
        assert!(differences(&first, &first).is_empty());
    }

    /// The nearest neighbour of a number is another number.
    #[test]
    fn a_difference_of_the_last_bit_is_one() {
        let of = |x: f64| serde_json::from_str(&json!({ "x": x }).to_string()).unwrap();
        for x in [
            0.1,
            1.0 / 3.0,
            1.7976931348623157e308,
            5e-324_f64,
            123456.789,
        ] {
            let next = f64::from_bits(x.to_bits() - 1);
            assert!(differences(&of(x), &of(x)).is_empty());
            assert_eq!(differences(&of(x), &of(next)).len(), 1, "{x}");
        }
    }
}
