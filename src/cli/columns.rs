//! `exid check --columns`: what files hold, before anything is said about them.

use crate::cli::args::Look;
use crate::cli::error::CliError;
use crate::cli::interrupt;
use crate::cli::messages::complain;
use crate::cli::output::print;
use crate::recording::error::RecordingErrorKind;
use crate::recording::reading::Reading;
use crate::recording::survey::{ColumnKind, ColumnSurvey, Survey, survey};
use serde_json::json;
use std::path::PathBuf;

pub fn run(look: &Look) -> Result<u8, CliError> {
    let mut reading = Reading {
        interrupt: Some(interrupt::flag()),
        ..Reading::default()
    };
    if let Some(rows) = look.run.max_rows {
        reading.most_rows = usize::try_from(rows).unwrap_or(usize::MAX);
    }
    let files: Vec<&PathBuf> = [&look.run.problem]
        .into_iter()
        .chain(&look.further)
        .collect();
    let mut found = Vec::new();
    let mut code = 0;
    for file in files {
        match survey(file, &reading) {
            Ok(survey) => found.push(survey),
            Err(fault) => {
                complain(&format!("error: {fault}"));
                code = match fault.kind {
                    RecordingErrorKind::Interrupted => return Ok(CliError::INTERRUPTED),
                    _ => CliError::WRONG_DATA,
                };
            }
        }
    }
    if look.run.printing.json {
        print(&format!("{:#}", json!(found)))?;
    } else if !look.run.printing.quiet {
        let texts: Vec<String> = found.iter().map(in_words).collect();
        print(&texts.join("\n"))?;
    }
    Ok(code)
}

fn in_words(survey: &Survey) -> String {
    let rate = match (&survey.time, survey.rate_hz) {
        (Some(time), Some(rate)) => {
            format!("{rate:.4} Hz by {time:?}, gaps in time: {}", survey.gaps)
        }
        (Some(time), None) => format!("{time:?} does not go on at a rate"),
        (None, _) => "no column of time under its usual names".to_string(),
    };
    let mut text = format!(
        "{}: {} rows, {} of them with empty cells; {rate}\n",
        survey.file.display(),
        survey.rows,
        survey.rows_with_empty_cells
    );
    let width = survey
        .columns
        .iter()
        .map(|c| c.name.chars().count())
        .max()
        .unwrap_or(0);
    let width = width.max("column".len()).min(48);
    text.push_str(&format!(
        "  {:>3}  {:width$}  {:8} {:>7} {:>13} {:>13} {:>8}\n",
        "no.", "column", "kind", "unit?", "lowest", "highest", "empty"
    ));
    for (number, column) in (1..).zip(&survey.columns) {
        text.push_str(&line(number, column, width));
    }
    text
}

fn line(number: usize, column: &ColumnSurvey, width: usize) -> String {
    let kind = match column.kind {
        ColumnKind::Number => "number",
        ColumnKind::Integer => "integer",
        ColumnKind::Flag => "flag",
        ColumnKind::Text => "text",
        ColumnKind::Empty => "empty",
    };
    let value = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x:.6}"));
    let unit = column.unit_guessed.unwrap_or_default();
    let text = format!(
        "  {number:>3}  {:width$}  {kind:8} {unit:>7} {:>13} {:>13} {:>8}",
        column.name,
        value(column.lowest),
        value(column.highest),
        column.empty_cells
    );
    format!("{}\n", text.trim_end())
}
