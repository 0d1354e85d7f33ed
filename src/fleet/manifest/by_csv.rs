//! Manifests as CSV.

use super::{Placed, Row, Rows, check_columns};
use crate::fault::Place;
use crate::fleet::error::FleetError;
use std::path::Path;

pub fn rows(path: &Path) -> Result<Rows, FleetError> {
    let place = Place::file(path);
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_path(path)
        .map_err(|e| FleetError::not_read(path, &e))?;
    let header = reader
        .headers()
        .map_err(|e| FleetError::not_parsed(place.clone().line(1), &e))?;
    // A mark of the order of bytes, as spreadsheets write it, is no part of a name.
    let names = header
        .iter()
        .map(|name| name.trim_start_matches('\u{feff}'));
    let columns: Vec<String> = names.map(str::to_string).collect();
    check_columns(&place, &columns)?;
    let rows = reader.into_records().map(move |record| {
        let record = record.map_err(|e| {
            let line = e.position().map(|p| p.line() as usize);
            let place = place.clone();
            FleetError::not_parsed(line.map_or(place.clone(), |l| place.line(l)), &e)
        })?;
        let line = record.position().map_or(0, |p| p.line() as usize);
        let mut row = Row::default();
        for (column, text) in columns.iter().zip(&record) {
            row.set(column, text.to_string());
        }
        Ok(Placed {
            row,
            place: place.clone().line(line),
        })
    });
    Ok(Box::new(rows))
}
