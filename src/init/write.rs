//! The draft as TOML with comments.

use crate::chain::effect::knowledge::JointTerm;
use crate::chain::effect::of_term;
use crate::init::channels::Channel;
use crate::init::{Form, Guess, Sources};
use crate::problem_file::choices::{Choice, Signal};
use crate::recording::column_map::ColumnsAt;
use std::path::{Path, PathBuf};

/// Friction, offsets and rotors: what drives have, all linear in their parameters but for the speed at which friction turns.
const TERMS: [JointTerm; 4] = [
    JointTerm::DryFriction,
    JointTerm::ViscousFriction,
    JointTerm::Offset,
    JointTerm::RotorInertia,
];

pub(super) fn toml(sources: &Sources, guess: &Guess<'_>) -> String {
    let target = &sources.target;
    let files = |paths: &[PathBuf]| -> String {
        let texts: Vec<String> = paths.iter().map(|p| text(&relative(p, target))).collect();
        format!("[{}]", texts.join(", "))
    };
    let mut lines = vec![
        "# Made by `exid init` from what the files show. `exid check` says what is wrong with it, `exid fit` estimates the".into(),
        "# parameters, and `exid schema --markdown` lists every key with its meaning.".into(),
        "#".into(),
    ];
    lines.extend(
        guess
            .assumed()
            .iter()
            .map(|sentence| format!("# Assumed: {sentence}.")),
    );
    let robot = Form::of(&sources.robot).key();
    lines.extend([
        format!("name = {}", text(&name(guess))),
        String::new(),
        "[robot]".into(),
        format!("{robot} = {}", text(&relative(&sources.robot, target))),
    ]);
    if !guess.locked.is_empty() {
        let stand = guess
            .locked
            .iter()
            .map(|joint| format!("{} = 0.0", text(joint)));
        let stand: Vec<String> = stand.collect();
        lines.push(format!(
            "locked = {{ {} }}    # rad (m); no columns",
            stand.join(", ")
        ));
    }
    lines.extend([
        "# payload = \"last\"           # ten unknown parameters of a load on the last link".into(),
        String::new(),
        "[drive]".into(),
    ]);
    let signal = guess.channels.kind;
    if signal == Signal::Current {
        let ones = vec!["1.0"; guess.tree.len()].join(", ");
        lines.push(format!(
            "torque_constant = [{ones}]    # N·m/A at the joint: not known, state the robot's"
        ));
    }
    lines.extend([
        format!("effects = {:?}", TERMS.map(|term| of_term(term).id)),
        String::new(),
        "[recordings]".into(),
        format!("train = {}", files(&guess.train)),
    ]);
    if !guess.validation.is_empty() {
        lines.push(format!(
            "validation = {}    # held out",
            files(&guess.validation)
        ));
    }
    lines.push(format!("signal = {}", text(signal.word())));
    if let Some(rate) = guess.rate {
        lines.push(format!("rate = {rate:?}    # Hz"));
    }
    if let Some(period) = guess.period {
        lines.push(format!("# period = {period:.6}          # s: found in the motion, and averaged over without being stated"));
    }
    lines.extend([String::new(), "[recordings.columns]".into()]);
    let named = guess.named();
    lines.extend(
        named
            .into_iter()
            .map(|(key, channel)| format!("{key} = {}", column(channel))),
    );
    if signal == Signal::PositionCommand {
        lines.extend([
            String::new(),
            "[controller]".into(),
            "kp = \"estimate\"    # N·m/rad (N/m): state those of the robot, or { value, std_dev }; masses or gains have to be known".into(),
            "kd = \"estimate\"    # N·m·s/rad (N·s/m)".into(),
        ]);
    }
    lines.join("\n") + "\n"
}

/// A channel as a value of `[recordings.columns]`.
fn column(channel: &Channel) -> String {
    let at = match &channel.at {
        ColumnsAt::Pattern(pattern) => text(pattern),
        _ => {
            let names: Vec<String> = channel.columns.iter().map(|name| text(name)).collect();
            format!("[{}]", names.join(", "))
        }
    };
    match (channel.unit, &channel.at) {
        (Some(unit), _) => format!("{{ column = {at}, unit = {} }}", text(unit)),
        (None, ColumnsAt::Pattern(_)) => at,
        (None, _) => format!("{{ column = {at} }}"),
    }
}

/// The robot's name, as far as a folder can be called so.
fn name(guess: &Guess<'_>) -> String {
    let allowed = |c: &char| c.is_alphanumeric() || "-_".contains(*c);
    let name: String = guess.tree.name().chars().filter(allowed).collect();
    match name.is_empty() {
        true => "robot".into(),
        false => name,
    }
}

/// A text of TOML.
fn text(value: &str) -> String {
    toml::Value::from(value).to_string()
}

/// A path from the folder of the problem file: as it is where it is absolute or starts there, else absolute.
fn relative(path: &Path, target: &Path) -> String {
    let folder = target.parent().unwrap_or(Path::new(""));
    let path = match path.strip_prefix(folder) {
        Ok(below) => below.to_path_buf(),
        Err(_) => std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf()),
    };
    path.display().to_string()
}
