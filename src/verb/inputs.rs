//! The files that the verbs read beside the problem file, in its order.

use crate::problem_file::ProblemFile;
use crate::problem_file::located::Located;
use crate::problem_file::recordings::RecordingFiles;
use crate::problem_file::robot::RobotSource;
use crate::problem_file::simulate::Trajectory;
use crate::robot::mjcf;
use std::path::PathBuf;

/// What verbs that compare a model with recordings read.
pub fn of_recordings(problem: &ProblemFile) -> Vec<PathBuf> {
    let mut files = of_model(problem);
    if let Some(table) = &problem.recordings {
        let groups = [
            &table.train,
            &table.loaded,
            &table.validation,
            &table.simulated,
        ];
        let recordings = groups.into_iter().flatten();
        let listed = recordings.flat_map(|r| &r.files).map(|file| &file.path);
        let listed = listed.chain(table.positions.iter().map(|p| &p.value.value));
        files.extend(listed.map(|path| path.resolved.clone()));
    }
    each_once(files)
}

/// The files of each recording of a robot, as messages name them.
pub fn by_recording(problem: &ProblemFile) -> Vec<Vec<String>> {
    let Some(table) = &problem.recordings else {
        return Vec::new();
    };
    let groups = [&table.train, &table.loaded, &table.validation];
    let names = |recording: &Located<RecordingFiles>| {
        let files = recording.files.iter();
        files
            .map(|file| file.path.resolved.display().to_string())
            .collect()
    };
    groups.into_iter().flatten().map(names).collect()
}

/// What a design reads.
pub fn of_design(problem: &ProblemFile) -> Vec<PathBuf> {
    let mut files = of_model(problem);
    let table = &problem.design;
    let rivals = table
        .rival
        .iter()
        .filter_map(|rival| rival.parameters.as_ref());
    let motions = table.start_from.iter().chain(&table.reference);
    files.extend(motions.chain(rivals).map(|path| path.resolved.clone()));
    each_once(files)
}

/// What a simulation reads.
pub fn of_simulation(problem: &ProblemFile) -> Vec<PathBuf> {
    let mut files = of_model(problem);
    if let Trajectory::File(path) = &problem.simulate.trajectory.value {
        files.push(path.resolved.clone());
    }
    each_once(files)
}

/// The robot's file and an earlier fit.
fn of_model(problem: &ProblemFile) -> Vec<PathBuf> {
    let mut files = match &problem.robot.source {
        RobotSource::Urdf(path) | RobotSource::Mdh(path) => vec![path.resolved.clone()],
        // With the files that it includes, as far as it reads.
        RobotSource::Mjcf(path) => mjcf::read(&path.resolved)
            .map_or_else(|_| vec![path.resolved.clone()], |robot| robot.files),
        RobotSource::Mechanism { .. } => Vec::new(),
    };
    files.extend(problem.robot.parameters.iter().map(|p| p.resolved.clone()));
    files
}

fn each_once(files: Vec<PathBuf>) -> Vec<PathBuf> {
    let mut once: Vec<PathBuf> = Vec::with_capacity(files.len());
    for file in files {
        if !once.contains(&file) {
            once.push(file);
        }
    }
    once
}
