//! The table of results as Parquet, in long form: one row for each parameter of each item.

use crate::fleet::error::FleetError;
use crate::fleet::scratch::{Scratch, TableRow};
use parquet::basic::{Compression, ZstdLevel};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use std::io::Write;
use std::sync::Arc;

const SCHEMA: &str = "message fleet {
    required binary robot (UTF8);
    required binary type (UTF8);
    required double time;
    optional binary parameter (UTF8);
    optional binary unit (UTF8);
    optional double value;
    optional double std;
    optional binary source (UTF8);
    optional double type_share;
    optional double pooled_value;
    optional double pooled_std;
    optional binary finding (UTF8);
    optional double probability;
    optional binary error (UTF8);
}";

/// Rows of a group: what is in memory at a time.
const ROWS: usize = 50_000;

/// Writes every row of the scratch database.
///
/// # Errors
/// The database or the file fails.
pub fn write<W: Write + Send>(scratch: &Scratch, out: W) -> Result<(), FleetError> {
    let schema = Arc::new(parse_message_type(SCHEMA)?);
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_created_by("exid".to_string());
    let mut writer = SerializedFileWriter::new(out, schema, Arc::new(properties.build()))?;
    let mut rows: Vec<TableRow> = Vec::with_capacity(ROWS);
    scratch.each_row(|row| {
        rows.push(row);
        if rows.len() == ROWS {
            group(&mut writer, &rows)?;
            rows.clear();
        }
        Ok(())
    })?;
    if !rows.is_empty() {
        group(&mut writer, &rows)?;
    }
    writer.close()?;
    Ok(())
}

/// A cell of one of the two types of columns.
enum Column {
    Required(fn(&TableRow) -> &str),
    RequiredNumber(fn(&TableRow) -> f64),
    Text(fn(&TableRow) -> Option<&str>),
    Number(fn(&TableRow) -> Option<f64>),
}

/// The columns in the order of the schema.
const COLUMNS: [Column; 14] = [
    Column::Required(|row| &row.robot),
    Column::Required(|row| &row.kind),
    Column::RequiredNumber(|row| row.time),
    Column::Text(|row| row.parameter.as_deref()),
    Column::Text(|row| row.unit.as_deref()),
    Column::Number(|row| row.value),
    Column::Number(|row| row.std),
    Column::Text(|row| row.source.as_deref()),
    Column::Number(|row| row.type_share),
    Column::Number(|row| row.pooled_value),
    Column::Number(|row| row.pooled_std),
    Column::Text(|row| row.finding.as_deref()),
    Column::Number(|row| row.probability),
    Column::Text(|row| row.error.as_deref()),
];

fn group<W: Write + Send>(
    writer: &mut SerializedFileWriter<W>,
    rows: &[TableRow],
) -> Result<(), FleetError> {
    let mut group = writer.next_row_group()?;
    for column in &COLUMNS {
        let Some(mut out) = group.next_column()? else {
            break;
        };
        match column {
            Column::Required(cell) => {
                let values: Vec<ByteArray> = rows.iter().map(|row| cell(row).into()).collect();
                out.typed::<ByteArrayType>()
                    .write_batch(&values, None, None)?;
            }
            Column::RequiredNumber(cell) => {
                let values: Vec<f64> = rows.iter().map(cell).collect();
                out.typed::<DoubleType>().write_batch(&values, None, None)?;
            }
            Column::Text(cell) => {
                let values: Vec<ByteArray> =
                    rows.iter().filter_map(cell).map(ByteArray::from).collect();
                let levels: Vec<i16> = rows
                    .iter()
                    .map(|row| i16::from(cell(row).is_some()))
                    .collect();
                out.typed::<ByteArrayType>()
                    .write_batch(&values, Some(&levels), None)?;
            }
            Column::Number(cell) => {
                let finite = |row: &TableRow| cell(row).filter(|number| number.is_finite());
                let values: Vec<f64> = rows.iter().filter_map(finite).collect();
                let levels: Vec<i16> = rows
                    .iter()
                    .map(|row| i16::from(finite(row).is_some()))
                    .collect();
                out.typed::<DoubleType>()
                    .write_batch(&values, Some(&levels), None)?;
            }
        }
        out.close()?;
    }
    group.close()?;
    Ok(())
}
