//! Manifests as Parquet, row by row.

use super::{Placed, Row, Rows, check_columns};
use crate::fault::Place;
use crate::fleet::error::FleetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use parquet::record::reader::RowIter;
use std::fs::File;
use std::path::Path;

pub fn rows(path: &Path) -> Result<Rows, FleetError> {
    let place = Place::file(path);
    let file = File::open(path).map_err(|e| FleetError::not_read(path, &e))?;
    let reader =
        SerializedFileReader::new(file).map_err(|e| FleetError::not_parsed(place.clone(), &e))?;
    let schema = reader.metadata().file_metadata().schema();
    let names = schema.get_fields().iter().map(|f| f.name().to_string());
    let columns: Vec<String> = names.collect();
    check_columns(&place, &columns)?;
    let rows = RowIter::from_file_into(Box::new(reader));
    let rows = rows.enumerate().map(move |(number, record)| {
        // The first row is 1, as that of a table's program.
        let place = place.clone().line(number + 1);
        let record = record.map_err(|e| FleetError::not_parsed(place.clone(), &e))?;
        let mut row = Row::default();
        for (column, field) in record.get_column_iter() {
            match field {
                Field::ListInternal(list) => {
                    let texts = list.elements().iter().map(text_of);
                    row.set_list(column, texts.collect());
                }
                other => row.set(column, text_of(other)),
            }
        }
        Ok(Placed { row, place })
    });
    Ok(Box::new(rows))
}

/// A cell as text; dates as seconds since 1970.
fn text_of(field: &Field) -> String {
    match field {
        Field::Null => String::new(),
        Field::Str(text) => text.clone(),
        Field::Date(days) => (86_400.0 * f64::from(*days)).to_string(),
        Field::TimestampMillis(time) => (*time as f64 / 1e3).to_string(),
        Field::TimestampMicros(time) => (*time as f64 / 1e6).to_string(),
        other => other.to_string(),
    }
}
