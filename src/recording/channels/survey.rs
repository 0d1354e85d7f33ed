//! Summary of a file: its columns with ranges, missing values, rate, and units as their numbers suggest.

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::recording::channels::column_names::TIME;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::formats::format::format_of;
use crate::recording::formats::reading::Reading;
use crate::recording::formats::table::Table;
use crate::recording::series::differences::steps;
use crate::recording::units::{self, FASTEST_HZ, Quantity, SLOWEST_HZ};
use crate::stats::robust::median;

/// A step longer than this many median steps is a gap.
const GAP_STEPS: f64 = 1.5;

/// A range of more than so many radians is one of degrees: eight turns, which cables do not allow.
const DEGREES_FROM: f64 = 50.0;

/// Whole numbers beyond this are counts of an encoder.
const COUNTS_FROM: f64 = 5_000.0;

/// Currents beyond this are milliamperes.
const MILLIAMPERES_FROM: f64 = 500.0;

/// What a file holds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Survey {
    /// The file that was looked at.
    pub file: PathBuf,
    /// Rows of its table.
    pub rows: usize,
    /// Rows that lack a value in some column.
    pub rows_with_empty_cells: usize,
    /// The column of time stamps, by its usual names.
    pub time: Option<String>,
    /// Hz, by the median step of the time stamps in the unit that is guessed.
    pub rate_hz: Option<f64>,
    /// Steps of time in which samples are missing.
    pub gaps: usize,
    /// In the order of the file.
    pub columns: Vec<ColumnSurvey>,
}

/// What a column holds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ColumnSurvey {
    /// Name in the header.
    pub name: String,
    /// What its cells are.
    pub kind: ColumnKind,
    /// As names and numbers suggest; nothing is done by it.
    pub unit_guessed: Option<&'static str>,
    /// Least number, as written; none of a column without numbers.
    pub lowest: Option<f64>,
    /// Greatest number, as written.
    pub highest: Option<f64>,
    /// Cells without a number.
    pub empty_cells: usize,
}

/// What the cells of a column are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ColumnKind {
    /// Numbers, not all of them whole.
    Number,
    /// Whole numbers alone.
    Integer,
    /// Zeros and ones alone.
    Flag,
    /// No numbers, or not in every row.
    Text,
    /// No cell holds a number.
    Empty,
}

/// Looks at all columns of a file.
///
/// Errors: those of the file.
pub fn survey(path: &Path, reading: &Reading) -> Result<Survey, RecordingError> {
    let format = format_of(path)?;
    let names = (format.columns)(path, reading)?;
    let mut numeric: Vec<String> = names.iter().filter(|n| !n.is_empty()).cloned().collect();
    let mut tables = Vec::new();
    while !numeric.is_empty() {
        match (format.read)(path, &numeric, reading) {
            Ok(table) => {
                tables.push(table);
                break;
            }
            Err(fault) => match unreadable(&fault, &numeric) {
                Unreadable::Column(name) => numeric.retain(|other| *other != name),
                // Arrays of several lengths, or several topics: each column for itself.
                Unreadable::Together => {
                    let alone =
                        |name: &String| (format.read)(path, std::slice::from_ref(name), reading);
                    tables.extend(numeric.iter().filter_map(|name| alone(name).ok()));
                    break;
                }
                Unreadable::File => return Err(fault),
            },
        }
    }
    Ok(of_tables(path, &names, &tables))
}

/// Why some columns cannot be read.
enum Unreadable {
    Column(String),
    Together,
    File,
}

fn unreadable(fault: &RecordingError, asked: &[String]) -> Unreadable {
    let column = fault.place.key.as_ref().filter(|key| asked.contains(key));
    match (&fault.kind, column) {
        (RecordingErrorKind::UnequalLengths { .. } | RecordingErrorKind::TwoTopics { .. }, _) => {
            Unreadable::Together
        }
        (
            RecordingErrorKind::NotANumber { .. }
            | RecordingErrorKind::NotFinite { .. }
            | RecordingErrorKind::Unsupported { .. }
            | RecordingErrorKind::DuplicateColumn { .. },
            Some(column),
        ) => Unreadable::Column(column.clone()),
        // A bag with joints in messages of their own.
        (RecordingErrorKind::BadMessage { .. }, _) if asked.len() > 1 => Unreadable::Together,
        _ => Unreadable::File,
    }
}

fn of_tables(path: &Path, names: &[String], tables: &[Table]) -> Survey {
    let series = |name: &str| {
        tables.iter().find_map(|table| {
            let at = table.columns.iter().position(|column| column == name)?;
            table.data.get(at)
        })
    };
    let time = TIME.iter().find(|name| series(name).is_some());
    let stamps = time.and_then(|name| series(name));
    let clock = stamps.and_then(|stamps| Clock::of(stamps));
    let columns = names.iter().filter(|name| !name.is_empty()).map(|name| {
        let mut column = of_column(name, series(name));
        if time.is_some_and(|time| time == name) {
            column.unit_guessed = clock.as_ref().map(|clock| clock.unit);
        }
        column
    });
    let rows = tables.iter().map(Table::rows).max().unwrap_or(0);
    let lacks = |table: &Table, row: usize| {
        table
            .data
            .iter()
            .any(|x| x.get(row).is_some_and(|x| x.is_nan()))
    };
    let with_empty = (0..rows).filter(|&row| tables.iter().any(|table| lacks(table, row)));
    Survey {
        file: path.to_path_buf(),
        rows,
        rows_with_empty_cells: with_empty.count(),
        time: time.map(|name| name.to_string()),
        rate_hz: clock.as_ref().map(|clock| clock.rate_hz),
        gaps: clock.as_ref().map_or(0, |clock| clock.gaps),
        columns: columns.collect(),
    }
}

/// What time stamps say.
struct Clock {
    unit: &'static str,
    rate_hz: f64,
    gaps: usize,
}

impl Clock {
    /// None of stamps that do not go on.
    fn of(stamps: &[f64]) -> Option<Self> {
        let known: Vec<f64> = stamps.iter().copied().filter(|t| t.is_finite()).collect();
        let steps = steps(&known);
        let step = median(&steps).filter(|step| *step > 0.0)?;
        let units = [("s", 1.0), ("ms", 1e3), ("us", 1e6), ("ns", 1e9)];
        let fits = |(_, parts): &(&str, f64)| (SLOWEST_HZ..=FASTEST_HZ).contains(&(parts / step));
        let (unit, parts) = units.into_iter().find(fits)?;
        Some(Self {
            unit,
            rate_hz: parts / step,
            gaps: steps.iter().filter(|s| **s > GAP_STEPS * step).count(),
        })
    }
}

fn of_column(name: &str, series: Option<&Vec<f64>>) -> ColumnSurvey {
    let mut column = ColumnSurvey {
        name: name.to_string(),
        kind: ColumnKind::Text,
        unit_guessed: None,
        lowest: None,
        highest: None,
        empty_cells: 0,
    };
    let Some(series) = series else {
        return column;
    };
    let known = || series.iter().copied().filter(|x| !x.is_nan());
    column.empty_cells = series.len() - known().count();
    column.lowest = known().min_by(f64::total_cmp);
    column.highest = known().max_by(f64::total_cmp);
    column.kind = match (column.lowest, column.highest) {
        (Some(low), Some(high)) if known().all(|x| x.fract() == 0.0) => {
            match low >= 0.0 && high <= 1.0 {
                true => ColumnKind::Flag,
                false => ColumnKind::Integer,
            }
        }
        (Some(_), _) => ColumnKind::Number,
        _ => ColumnKind::Empty,
    };
    column.unit_guessed = unit(&column);
    column
}

/// How names of positions and currents begin, in lower case.
const POSITIONS: &[&str] = &["q", "pos", "angle", "winkel", "theta"];
const CURRENTS: &[&str] = &["i", "cur", "strom"];

/// What stands in brackets at the end of a name.
fn in_brackets(name: &str) -> Option<&str> {
    let inner = name.trim_end().strip_suffix([']', ')'])?;
    Some(&inner[inner.rfind(['[', '('])? + 1..])
}

/// As the name states it in brackets, or as its beginning and the numbers suggest.
fn unit(column: &ColumnSurvey) -> Option<&'static str> {
    let most = column.lowest?.abs().max(column.highest?.abs());
    let quantities = [
        Quantity::Position,
        Quantity::Velocity,
        Quantity::Current,
        Quantity::Torque,
    ];
    let mut stated = quantities.into_iter();
    if let Some(unit) =
        in_brackets(&column.name).and_then(|name| stated.find_map(|of| units::stated(of, name)))
    {
        return Some(unit);
    }
    let name = column.name.rsplit(['.', '/', ':']).next()?.to_lowercase();
    let begins = |words: &[&str]| {
        words.iter().any(|word| {
            let rest = name.strip_prefix(word);
            // A letter alone is a name where a number or a joint follows it.
            rest.is_some_and(|rest| {
                word.len() > 1 || rest.starts_with(|c: char| c == '_' || c.is_ascii_digit())
            })
        })
    };
    if begins(POSITIONS) {
        return Some(match column.kind {
            ColumnKind::Integer if most > COUNTS_FROM => "count",
            _ if most > DEGREES_FROM => "deg",
            _ => "rad",
        });
    }
    begins(CURRENTS).then_some(if most > MILLIAMPERES_FROM { "mA" } else { "A" })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn look(text: &str) -> Survey {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        std::fs::write(&path, text).unwrap();
        survey(&path, &Reading::default()).unwrap()
    }

    #[test]
    fn units_in_brackets_are_taken_as_they_are_stated() {
        let rows = (0..60).map(|k| format!("{k},0.0{k},1.{k},0.2{k}"));
        let rows: Vec<String> = rows.collect();
        let found = look(&format!("t,q1 [°],x (mm),q3\n{}\n", rows.join("\n")));
        let units: Vec<Option<&str>> = found.columns.iter().map(|c| c.unit_guessed).collect();
        assert_eq!(units[1..], [Some("deg"), Some("mm"), Some("rad")]);
    }

    #[test]
    fn tells_kinds_ranges_holes_and_rate() {
        let mut text = "time,q1,pos_2,i1,note,ok,none\n".to_string();
        for k in (0..60).filter(|k| *k != 30) {
            let current = if k == 7 {
                String::new()
            } else {
                format!("{}", 10 * k)
            };
            text += &format!(
                "{},{},{},{current},run,1,\n",
                2 * k,
                0.01 * k as f64,
                1000 * k
            );
        }
        let found = look(&text);
        assert_eq!((found.rows, found.gaps), (59, 1));
        assert_eq!(found.time.as_deref(), Some("time"));
        assert_eq!(found.rate_hz, Some(500.0));
        let kinds: Vec<ColumnKind> = found.columns.iter().map(|c| c.kind).collect();
        use ColumnKind::{Empty, Flag, Integer, Number, Text};
        assert_eq!(
            kinds,
            [Integer, Number, Integer, Integer, Text, Flag, Empty]
        );
        let units: Vec<Option<&str>> = found.columns.iter().map(|c| c.unit_guessed).collect();
        assert_eq!(
            units,
            [
                Some("ms"),
                Some("rad"),
                Some("count"),
                Some("mA"),
                None,
                None,
                None
            ]
        );
        assert_eq!(found.columns[3].empty_cells, 1);
        assert_eq!(
            (found.columns[1].lowest, found.columns[1].highest),
            (Some(0.0), Some(0.59))
        );
    }
}
