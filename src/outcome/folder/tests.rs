//! Results folders: replaced whole or not at all, and never at the cost of a user's files.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::fault::Fault;
use crate::outcome::folder::target::Target;
use crate::outcome::folder::{ResultFolder, leftovers, swap};
use crate::outcome::tests::fit_outcome;

/// Writes a result under the name `name` with one further file.
fn write_result(target: &Path, name: &str, further: &str) {
    let folder = ResultFolder::prepare(target).unwrap();
    let mut outcome = fit_outcome();
    outcome.name = name.to_string();
    let text = outcome.to_json().unwrap();
    folder
        .write("result.json", |out| out.write_all(text.as_bytes()))
        .unwrap();
    folder.write(further, |out| out.write_all(b"t\n")).unwrap();
    folder.commit().unwrap();
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

fn code(path: &Path) -> &'static str {
    let error = ResultFolder::prepare(path).unwrap_err();
    assert!(error.concerns_output());
    assert_eq!(
        error.place.file, path,
        "the message names the path as given"
    );
    error.describe().code
}

#[test]
fn replaces_an_earlier_result_whole() {
    let root = tempfile::tempdir().unwrap();
    let target = root.path().join("results/arm/fit");
    write_result(&target, "first", "predictions.csv");
    assert_eq!(names(&target), ["predictions.csv", "result.json"]);
    write_result(&target, "second", "trajectory.csv");
    assert_eq!(names(&target), ["result.json", "trajectory.csv"]);
    let text = fs::read_to_string(target.join("result.json")).unwrap();
    assert!(text.contains("\"name\": \"second\""));
    assert_eq!(
        names(target.parent().unwrap()),
        ["fit"],
        "nothing is left beside it"
    );
}

#[test]
fn what_users_have_added_survives_the_next_runs() {
    let root = tempfile::tempdir().unwrap();
    let target = root.path().join("fit");
    write_result(&target, "first", "next_experiment.toml");
    fs::write(target.join("notes.txt"), "mine").unwrap();
    fs::create_dir(target.join("export")).unwrap();
    fs::write(target.join("export/robot.urdf"), "<robot/>").unwrap();
    write_result(&target, "second", "predictions.csv");
    write_result(&target, "third", "notes.txt");
    let read = |name: &str| fs::read_to_string(target.join(name)).unwrap();
    assert_eq!(
        names(&target),
        ["export", "notes.txt", "notes.txt.kept", "result.json"]
    );
    assert_eq!(read("export/robot.urdf"), "<robot/>");
    assert_eq!(read("notes.txt.kept"), "mine");
    assert!(read("result.json").contains("\"third\""));
}

#[test]
fn replaces_an_empty_folder_and_the_folder_behind_a_link() {
    let root = tempfile::tempdir().unwrap();
    let real = root.path().join("real");
    fs::create_dir(&real).unwrap();
    let link = root.path().join("link");
    std::os::unix::fs::symlink(&real, &link).unwrap();
    write_result(&link, "arm", "predictions.csv");
    write_result(&link, "arm", "trajectory.csv");
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(names(&real), ["result.json", "trajectory.csv"]);
}

#[test]
fn a_run_that_ends_early_changes_nothing() {
    let root = tempfile::tempdir().unwrap();
    let target = root.path().join("results/arm/fit");
    let folder = ResultFolder::prepare(&target).unwrap();
    folder
        .write("result.json", |out| out.write_all(b"{}"))
        .unwrap();
    drop(folder);
    assert!(names(root.path()).is_empty(), "created parents go as well");

    write_result(&target, "arm", "predictions.csv");
    drop(ResultFolder::prepare(&target).unwrap());
    assert_eq!(names(&target), ["predictions.csv", "result.json"]);
}

#[test]
fn refuses_what_is_not_a_result_and_leaves_it_alone() {
    let root = tempfile::tempdir().unwrap();
    let file = root.path().join("file");
    fs::write(&file, "mine").unwrap();
    assert_eq!(code(&file), "out-is-a-file");
    assert_eq!(code(&file.join("below")), "out-not-written");

    let foreign = root.path().join("foreign");
    fs::create_dir(&foreign).unwrap();
    for content in [
        "",
        "[1, 2]",
        "{\"version\": 3}",
        "{\"name\": \"x\", \"version\": \"1\"}",
    ] {
        fs::write(foreign.join("result.json"), content).unwrap();
        assert_eq!(code(&foreign), "out-is-not-a-result", "{content}");
        assert_eq!(names(&foreign), ["result.json"]);
    }
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
    assert_eq!(code(Path::new(".")), "out-is-the-working-folder");
    assert_eq!(code(Path::new("/")), "out-not-written");
}

#[test]
fn a_user_file_that_arrives_during_the_run_is_kept() {
    let root = tempfile::tempdir().unwrap();
    let target = root.path().join("fit");
    let folder = ResultFolder::prepare(&target).unwrap();
    fs::create_dir(&target).unwrap();
    fs::write(target.join("notes.txt"), "mine").unwrap();
    assert_eq!(
        folder.commit().unwrap_err().describe().code,
        "out-is-not-a-result"
    );
    assert_eq!(names(&target), ["notes.txt"]);
}

#[test]
fn the_next_run_removes_what_a_killed_run_left_but_not_a_live_one() {
    let root = tempfile::tempdir().unwrap();
    let target = root.path().join("fit");
    let killed = root.path().join(".fit.partial-4194305-0");
    fs::create_dir(&killed).unwrap();
    fs::write(killed.join("result.json"), "{").unwrap();
    let unrelated = root.path().join(".fit.partial-notes");
    fs::create_dir(&unrelated).unwrap();
    let live = ResultFolder::prepare(&target).unwrap();
    assert!(!killed.exists());
    assert!(unrelated.exists());

    drop(ResultFolder::prepare(&target).unwrap());
    assert!(
        live.path().exists(),
        "a folder that a run holds is not a leftover"
    );
}

#[test]
fn two_runs_to_one_target_leave_the_result_of_the_later_one() {
    let root = tempfile::tempdir().unwrap();
    let target = root.path().join("fit");
    let folders = [1, 2].map(|_| ResultFolder::prepare(&target).unwrap());
    for (folder, name) in folders.into_iter().zip(["first", "second"]) {
        let text = fit_outcome()
            .to_json()
            .unwrap()
            .replace("\"arm\",\n  \"verb", &format!("\"{name}\",\n  \"verb"));
        folder
            .write("result.json", |out| out.write_all(text.as_bytes()))
            .unwrap();
        folder.commit().unwrap();
    }
    assert!(
        fs::read_to_string(target.join("result.json"))
            .unwrap()
            .contains("\"second\"")
    );
    assert_eq!(names(root.path()), ["fit"]);
}

/// A target with a result called `old`, and a finished partial folder called `new`.
fn old_and_new(root: &Path) -> (Target, PathBuf) {
    let path = root.join("fit");
    fs::create_dir(&path).unwrap();
    fs::write(path.join("old"), "").unwrap();
    let target = Target::resolve(&path).unwrap();
    let partial = target.partial(1, 0);
    fs::create_dir(&partial).unwrap();
    fs::write(partial.join("new"), "").unwrap();
    (target, partial)
}

#[test]
fn without_an_exchange_the_result_is_set_aside_and_recovered() {
    let root = tempfile::tempdir().unwrap();
    let (target, partial) = old_and_new(root.path());
    swap::set_aside(&partial, &target).unwrap();
    assert_eq!(names(&target.path), ["new"]);
    assert_eq!(names(root.path()), ["fit"]);

    // Killed between the two renames: the earlier result comes back.
    fs::rename(&target.path, target.previous()).unwrap();
    leftovers::clear(&target);
    assert_eq!(names(&target.path), ["new"]);

    // Killed before the earlier result was removed: it goes.
    fs::create_dir(target.previous()).unwrap();
    leftovers::clear(&target);
    assert_eq!(names(root.path()), ["fit"]);
}

#[test]
fn a_failed_second_rename_brings_the_earlier_result_back() {
    let root = tempfile::tempdir().unwrap();
    let (target, partial) = old_and_new(root.path());
    fs::remove_dir_all(&partial).unwrap();
    swap::set_aside(&partial, &target).unwrap_err();
    assert_eq!(names(&target.path), ["old"]);
}
