//! What is wrong with a problem before anything is run: robot file, recordings, and what they determine.
//!
//! Every kind of check is one file and one line of a table. Checks of a file as it was read come first;
//! what they call an error (positions in degrees, a wrong unit of time) makes every later number of that
//! file meaningless, so the file goes no further. A file that cannot be read is a finding, and the others
//! are still checked.

mod channels;
mod context;
mod delay;
mod drift;
mod extent;
mod filtered;
mod identifiability;
mod jumps;
mod known_values;
mod limits;
mod locked;
mod magnitude;
mod missing;
mod motion;
mod order;
mod period;
mod regression;
mod report;
mod robot_file;
mod scale;
mod shared;
mod signs;
mod spikes;
mod timing;
mod units;
mod velocity;

#[cfg(test)]
mod tests;

use crate::chain::dataset::Dataset;
use crate::chain::model::Model;
use crate::check::context::{CheckContext, PreparedRecording, RawRecording};
pub use crate::check::jumps::is_no_physics;
pub(crate) use crate::check::locked::STILL;
pub use crate::check::scale::SignalScale;
use crate::fault::Fault;
use crate::outcome::check::{Mistake, Severity};
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::recording::format::columns_at;
use crate::recording::samples::Recording;
use crate::recording::split::Split;
use crate::setup::error::SetupError;
use crate::setup::model_spec::ModelSpec;
use crate::setup::recording_file::{NamedRecording, ReadRecording, RecordedRobot};
use crate::setup::recordings::{list, prepare_one, read_one};
use crate::setup::robot;
use crate::setup::shared_rows::shared_rows;

/// Checks of a recording as it was read.
const OF_READ: &[fn(&RawRecording<'_>) -> Vec<Mistake>] = &[
    timing::check,
    missing::check,
    units::check,
    velocity::check,
    channels::check,
    magnitude::check,
    spikes::check,
    jumps::check,
    period::check,
];

/// Checks of a recording made ready, against the model.
const OF_READY: &[fn(&PreparedRecording<'_>) -> Vec<Mistake>] = &[
    limits::check,
    timing::check_bandwidth,
    drift::check,
    order::check,
    signs::check,
    scale::check,
    delay::check,
    filtered::check,
];

/// A check of the training recordings together.
type OfTraining = fn(&CheckContext<'_>, &Model, &Dataset) -> Vec<Mistake>;

const OF_TRAINING: &[OfTraining] = &[motion::check, identifiability::check];

/// How much of a problem is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// The robot, the recordings, and what they determine.
    Everything,
    /// What costs next to nothing beside a fit, which says itself what the recordings determine.
    Recordings,
    /// The robot alone, where no recordings are read.
    Robot,
}

/// What was found.
#[derive(Default)]
struct Found {
    /// Of files that cannot be read or do not fit together; whoever reads them meets these.
    faults: Vec<Mistake>,
    /// Of what the files say.
    mistakes: Vec<Mistake>,
}

/// Checks everything that a problem file names, and estimates nothing.
///
/// The worst findings come first; faults of files are findings with the code of the fault. An interrupt
/// returns what was found so far.
pub fn run(problem: &ProblemFile, control: &Control<'_>) -> Vec<Mistake> {
    let Found { faults, mistakes } = look(problem, control, Extent::Everything);
    worst_first(faults.into_iter().chain(mistakes))
}

/// Mistakes in what the files of a problem say, the worst first. None where files cannot be read or do not fit together:
/// that has to be mended first, and whoever reads them says so.
pub fn mistakes(problem: &ProblemFile, control: &Control<'_>, extent: Extent) -> Vec<Mistake> {
    let Found { faults, mistakes } = look(problem, control, extent);
    match faults.is_empty() {
        true => worst_first(mistakes),
        false => Vec::new(),
    }
}

/// How the signals of the first recording compare to the torques that the robot file's inertials give; none where files cannot be
/// read or nothing is determined.
pub fn signal_scales(problem: &ProblemFile) -> Vec<SignalScale> {
    let scales = || -> Option<Vec<SignalScale>> {
        let robot = robot::open(problem).ok()?;
        let model = build_model(problem, &robot).ok()?;
        let table = problem.recordings.as_ref()?;
        let named = list(table).into_iter().next()?;
        let recording = read_one(table, &robot, named.path).ok()?;
        let recorded = RecordedRobot {
            table,
            robot: &robot,
            model: &model,
        };
        let prepared = prepare_one(recording, &named, recorded).ok()?;
        let context = CheckContext::new(problem, table, &robot);
        // The regressions know trees alone.
        let is_tree = robot.mechanism.is_none();
        is_tree.then(|| SignalScale::of(&PreparedRecording::new(&context, &model, &prepared)))
    };
    scales().unwrap_or_default()
}

fn look(problem: &ProblemFile, control: &Control<'_>, extent: Extent) -> Found {
    let mut found = Found::default();
    match robot::open(problem) {
        Ok(robot) => with_robot(problem, &robot, extent, control, &mut found),
        Err(fault) => {
            found.faults.push(from_fault(&fault));
            found.faults.extend(unreadable_files(problem));
        }
    }
    found
}

fn worst_first(findings: impl IntoIterator<Item = Mistake>) -> Vec<Mistake> {
    let mut findings: Vec<Mistake> = findings.into_iter().collect();
    // A stable sort: equal findings keep the order of the files and of the tables.
    findings.sort_by_key(|finding| finding.severity);
    let mut distinct: Vec<Mistake> = Vec::with_capacity(findings.len());
    for finding in findings {
        if !distinct.contains(&finding) {
            distinct.push(finding);
        }
    }
    distinct
}

/// What the errors among findings are of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AtFault {
    /// No finding is an error.
    Nothing,
    /// The problem file, and nothing that it names.
    ProblemFile,
    /// A recording or robot file, whatever else is wrong.
    Data,
}

/// Which file has to be mended first.
pub fn at_fault(problem: &ProblemFile, findings: &[Mistake]) -> AtFault {
    let own = problem.path.display().to_string();
    let is_own = |f: &Mistake| f.file.as_deref().is_none_or(|file| file == own);
    let mut errors = findings.iter().filter(|f| f.severity == Severity::Error);
    match (has_error(findings), errors.all(is_own)) {
        (false, _) => AtFault::Nothing,
        (true, true) => AtFault::ProblemFile,
        (true, false) => AtFault::Data,
    }
}

/// Whether something makes figures meaningless.
pub fn has_error(findings: &[Mistake]) -> bool {
    findings.iter().any(|f| f.severity == Severity::Error)
}

fn from_fault(fault: &impl Fault) -> Mistake {
    Mistake::from_fault(fault, Severity::Error)
}

fn with_robot(
    problem: &ProblemFile,
    robot: &robot::Robot,
    extent: Extent,
    control: &Control<'_>,
    found: &mut Found,
) {
    found.mistakes.extend(robot_file::check(problem, robot));
    let model = match problem.fit.is_of_motors() {
        true => None,
        false => declared_model(problem, robot, found),
    };
    if let Some(model) = &model {
        found.mistakes.extend(known_values::check(problem, model));
    }
    let Some(table) = &problem.recordings else {
        return;
    };
    if extent == Extent::Robot {
        return;
    }
    let context = CheckContext::new(problem, table, robot);
    let mut dataset = Dataset::default();
    let mut complete = true;
    let mut read = Vec::new();
    let recordings = list(table);
    let count = control.counting(recordings.len());
    for named in recordings {
        if control.is_interrupted() {
            return;
        }
        found.mistakes.extend(locked::check(&context, &named));
        match read_and_check(&context, &named, found) {
            Some(recording) => read.push(ReadRecording { named, recording }),
            None => complete &= named.split != Split::Train,
        }
        count.one();
    }
    let shared = shared_rows(table, &read);
    found.faults.extend(shared.iter().map(from_fault));
    for ReadRecording { named, recording } in read {
        if control.is_interrupted() {
            return;
        }
        let Some(model) = &model else {
            continue;
        };
        let recorded = RecordedRobot {
            table,
            robot,
            model,
        };
        match prepare_one(recording, &named, recorded) {
            // The regressions that look for mixed-up columns know trees alone.
            Ok(_) if robot.mechanism.is_some() => complete = false,
            Ok(prepared) => {
                let mut ready = PreparedRecording::new(&context, model, &prepared);
                ready.other_reading = order::find(&ready);
                let of_ready = OF_READY.iter().flat_map(|check| check(&ready));
                let of_ready: Vec<Mistake> = of_ready.collect();
                // What recordings determine cannot be said of columns that are mixed up.
                complete &= !has_error(&of_ready) || named.split != Split::Train;
                found.mistakes.extend(of_ready);
                dataset.recordings.push(prepared);
            }
            Err(fault) => {
                complete &= named.split != Split::Train;
                found.faults.push(from_fault(&fault));
            }
        }
    }
    if let (Some(model), true, Extent::Everything) = (&model, complete, extent) {
        for check in OF_TRAINING {
            found.mistakes.extend(check(&context, model, &dataset));
        }
    }
}

/// The declared model; `None` with a finding where there cannot be one.
fn declared_model(problem: &ProblemFile, robot: &robot::Robot, found: &mut Found) -> Option<Model> {
    match build_model(problem, robot) {
        Ok(model) => Some(model),
        Err(fault) => {
            let of_fault = from_fault(&*fault);
            // The check of the robot file has already named bodies that cannot be.
            let known = found
                .mistakes
                .iter()
                .any(|f| f.code == of_fault.code && f.channel == of_fault.channel);
            found.faults.extend((!known).then_some(of_fault));
            None
        }
    }
}

fn build_model(problem: &ProblemFile, robot: &robot::Robot) -> Result<Model, Box<SetupError>> {
    let declared = ModelSpec::of(problem, robot)?;
    let built = declared.build()?;
    for compared in &problem.fit.compare {
        declared.compared(&compared.effects.value).build()?;
    }
    Ok(built.model)
}

/// Reads a recording and looks at it as it is; `None` where it goes no further.
fn read_and_check(
    context: &CheckContext<'_>,
    named: &NamedRecording<'_>,
    found: &mut Found,
) -> Option<Recording> {
    let recording = match read_one(context.table, context.robot, named.path) {
        Ok(recording) => recording,
        Err(_) if context.table.reading.is_interrupted() => return None,
        Err(fault) => {
            found.faults.push(from_fault(&fault));
            return None;
        }
    };
    let read = match RawRecording::new(context, &recording) {
        Ok(read) => read,
        Err(fault) => {
            // A wrong unit of time explains what the time base itself can only refuse.
            match timing::wrong_unit(&recording) {
                Some(unit) => found.mistakes.push(unit),
                None => found.faults.push(from_fault(&fault)),
            }
            return None;
        }
    };
    let of_read: Vec<Mistake> = OF_READ.iter().flat_map(|check| check(&read)).collect();
    let usable = !has_error(&of_read);
    found.mistakes.extend(of_read);
    usable.then_some(recording)
}

/// Without a robot the channels of recordings are unknown; whether the files are there is not.
fn unreadable_files(problem: &ProblemFile) -> Vec<Mistake> {
    let Some(table) = &problem.recordings else {
        return Vec::new();
    };
    let named = list(table);
    let fault = |named: &NamedRecording<'_>| columns_at(&named.path.resolved, &table.reading).err();
    named
        .iter()
        .filter_map(fault)
        .map(|fault| from_fault(&fault))
        .collect()
}
