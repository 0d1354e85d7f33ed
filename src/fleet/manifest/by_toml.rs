//! Manifests as TOML, for fleets that a person writes down: `[[item]]` tables.

use super::{Placed, Row, Rows, check_columns};
use crate::fault::Place;
use crate::fleet::error::{FleetError, FleetErrorKind};
use crate::fleet::time;
use std::path::Path;
use toml::{Table, Value};

pub fn rows(path: &Path) -> Result<Rows, FleetError> {
    let place = Place::file(path);
    let text = std::fs::read_to_string(path).map_err(|e| FleetError::not_read(path, &e))?;
    let table: Table = text
        .parse()
        .map_err(|e| FleetError::not_parsed(place.clone(), &e))?;
    let items = match table.get("item") {
        Some(Value::Array(items)) => items.clone(),
        _ => return Err(FleetError::new(place, FleetErrorKind::Empty)),
    };
    if let Some(other) = table.keys().find(|key| *key != "item") {
        let kind = FleetErrorKind::UnknownColumn {
            name: other.as_str().into(),
            nearest: Some("item"),
        };
        return Err(FleetError::new(place, kind));
    }
    let rows = items.into_iter().enumerate().map(move |(number, item)| {
        let place = place.clone().key(format!("item {}", number + 1));
        row(item, &place).map(|row| Placed { row, place })
    });
    Ok(Box::new(rows))
}

fn row(item: Value, place: &Place) -> Result<Row, FleetError> {
    let bad = |found: &Value, expected| {
        let kind = FleetErrorKind::BadCell {
            found: found.to_string().into(),
            expected,
        };
        FleetError::new(place.clone(), kind)
    };
    let Value::Table(item) = item else {
        return Err(bad(&item, "a table [[item]]"));
    };
    check_columns(place, &item.keys().cloned().collect::<Vec<_>>())?;
    let mut row = Row::default();
    for (column, value) in item {
        match &value {
            Value::String(text) => row.set(&column, text.clone()),
            Value::Array(list) => {
                let texts = list.iter().map(|entry| entry.as_str().map(str::to_string));
                let texts: Option<Vec<String>> = texts.collect();
                row.set_list(
                    &column,
                    texts.ok_or_else(|| bad(&value, "a list of texts"))?,
                );
            }
            Value::Integer(number) => row.set(&column, number.to_string()),
            Value::Float(number) => row.set(&column, number.to_string()),
            Value::Datetime(instant) => {
                let seconds = time::seconds(*instant);
                let seconds = seconds.ok_or_else(|| bad(&value, "a date"))?;
                row.set(&column, seconds.to_string());
            }
            other => return Err(bad(other, "a text, a number or a date")),
        }
    }
    Ok(row)
}
