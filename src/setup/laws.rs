//! The effects of a problem: the vocabulary, registered ones, and the laws of its file.

use crate::chain::effect::Catalogue;
use crate::chain::effect::user_law::{
    self, ActsOn, LawError, LawText, ParameterText, Part, SearchText, ShareOf, StateText,
};
use crate::fault::{Description, Place};
use crate::problem_file::ProblemFile;
use crate::problem_file::law::{self, LawSearch, LawTable};
use crate::setup::error::{Mismatch, SetupError};
use std::path::Path;

/// The effects that a problem may name.
///
/// # Errors
/// A law that is none, at its place in the file.
pub fn catalogue(problem: &ProblemFile) -> Result<Catalogue, SetupError> {
    with_laws(&problem.laws)
}

/// The vocabulary, registered effects, and laws.
///
/// # Errors
/// As of [`catalogue`].
pub fn with_laws(laws: &[LawTable]) -> Result<Catalogue, SetupError> {
    let mut catalogue = Catalogue::known();
    for law in laws {
        check_starts(law)?;
        let effect = user_law::effect(&text(law)).map_err(|e| fault(law, &e))?;
        // Its reader has refused an identifier that is taken, but for one that a program has registered since.
        catalogue = catalogue.with(effect).map_err(|taken| {
            let remedy = "give the law another id";
            let description = Description::new("law-name", taken.to_string(), remedy);
            SetupError::mismatch(&law.id.place, Mismatch::Law(description))
        })?;
    }
    Ok(catalogue)
}

/// The effects of a problem that a result keeps.
///
/// # Errors
/// A law that is none, as in results of other versions.
pub fn kept(problem: &serde_json::Value) -> Result<Catalogue, SetupError> {
    let laws = law::kept(problem, &Catalogue::known().ids()).map_err(SetupError::ProblemFile)?;
    with_laws(&laws)
}

/// The vocabulary, registered effects, and the laws of a file or of the files of a folder.
///
/// # Errors
/// A fault of a file, or a law that is none.
pub fn of_files(path: &Path) -> Result<Catalogue, SetupError> {
    let laws = law::read(path, &Catalogue::known().ids()).map_err(SetupError::ProblemFile)?;
    with_laws(&laws)
}

/// First values are those of all states, or none.
fn check_starts(law: &LawTable) -> Result<(), SetupError> {
    let (found, states) = (law.start.len(), law.dz.len());
    match law.start.first() {
        Some(first) if found != states => {
            let message = format!("there are {found} first values of {states} states");
            let remedy = "give each state of dz its first value, or none";
            let description = Description::new("law-parameters", message, remedy);
            Err(SetupError::mismatch(
                &first.place,
                Mismatch::Law(description),
            ))
        }
        _ => Ok(()),
    }
}

fn text(table: &LawTable) -> LawText {
    let states = table.dz.iter().enumerate();
    let states = states.map(|(k, rate)| StateText {
        rate: rate.value.clone(),
        start: table.start.get(k).map(|start| start.value.clone()),
    });
    let parameters = table.parameters.iter().map(|named| ParameterText {
        name: named.name.clone(),
        unit: named.value.unit.clone(),
        meaning: named.value.meaning.clone(),
        lower: named.value.lower,
        upper: named.value.upper,
        typical: named.value.typical,
        search: search(&named.value.search),
    });
    LawText {
        id: table.id.value.clone(),
        sentence: table.sentence.value.clone(),
        source: table
            .source
            .as_ref()
            .map_or_else(String::new, |s| s.value.clone()),
        acts_on: match table.acts_on.value {
            law::ActsOn::Motor => ActsOn::Motor,
            law::ActsOn::Joint => ActsOn::Joint,
            law::ActsOn::Signal => ActsOn::Signal,
            law::ActsOn::Gain => ActsOn::Gain,
        },
        torque: table.torque.value.clone(),
        states: states.collect(),
        parameters: parameters.collect(),
        refines: table.refines.iter().map(|id| id.value.clone()).collect(),
    }
}

fn search(of: &LawSearch) -> SearchText {
    match of {
        LawSearch::Typical => SearchText::Typical,
        LawSearch::Cycles => SearchText::Cycles,
        LawSearch::Values(values) => SearchText::Values(values.clone()),
        LawSearch::Shares(share, values) => {
            let share = match share {
                law::ShareOf::Position => ShareOf::Position,
                law::ShareOf::Range => ShareOf::Range,
                law::ShareOf::Speed => ShareOf::Speed,
                law::ShareOf::OverSpeed => ShareOf::OverSpeed,
                law::ShareOf::Duration => ShareOf::Duration,
            };
            SearchText::Shares(share, values.clone())
        }
    }
}

fn fault(table: &LawTable, error: &LawError) -> SetupError {
    let place: &Place = match error.part {
        Part::Id => &table.id.place,
        Part::Torque => &table.torque.place,
        Part::Rate(k) => table.dz.get(k).map_or(&table.id.place, |r| &r.place),
        Part::Start(k) => table.start.get(k).map_or(&table.id.place, |s| &s.place),
        Part::Parameter(k) => {
            let parameter = table.parameters.get(k);
            parameter.map_or(&table.id.place, |p| &p.value.place)
        }
    };
    let description = Description::new(error.code(), error.message(), error.remedy());
    SetupError::mismatch(place, Mismatch::Law(description))
}
