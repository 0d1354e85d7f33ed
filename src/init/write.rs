//! The draft as TOML with comments.

use crate::chain::effect::knowledge::JointTerm;
use crate::chain::effect::{of_term, term_name};
use crate::init::channels::Channel;
use crate::init::{Form, Guess, Sources};
use crate::problem_file::choices::{Choice, Signal};
use crate::recording::column_map::ColumnsAt;
use std::path::{Component, Path, PathBuf};

/// Relative standard deviation of torque constants that follow from the robot file's inertials, which are right to a factor of two: half of
/// ln 2.
const OF_CONSTANTS: f64 = 0.35;

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
    if guess.channels.kind == Signal::PositionCommand && guess.has_inertials() {
        lines.push("inertials = \"known\"         # those of the robot file".into());
    }
    if !guess.locked.is_empty() {
        let stand = guess.locked.iter().map(|locked| {
            format!(
                "{} = {:?}",
                text(&locked.joint),
                (1e4 * locked.at).round() / 1e4
            )
        });
        let stand: Vec<String> = stand.collect();
        lines.push(format!(
            "locked = {{ {} }}    # rad (m); joints that do not move",
            stand.join(", ")
        ));
    }
    lines.extend([
        "# payload = \"last\"           # ten unknown parameters of a load on the last link".into(),
        String::new(),
        "[drive]".into(),
    ]);
    let signal = guess.channels.kind;
    let gains = gains(guess);
    if let Some(constants) = &guess.constants {
        let values: Vec<String> = constants.values.iter().map(|k| rounded(*k)).collect();
        let why = match constants.by_inertials {
            true => "as the robot file's inertials ask for; state the robot's",
            false => "not known, state the robot's",
        };
        lines.push(format!(
            "torque_constant = [{}]    # N·m/A (N/A) at the joint: {why}",
            values.join(", ")
        ));
    }
    let mut effects = TERMS.map(|term| of_term(term).id).to_vec();
    if !gains.is_empty() {
        effects.push(of_term(JointTerm::Gain).id);
    }
    lines.extend([
        format!("effects = {effects:?}"),
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
    if !gains.is_empty() {
        lines.extend([
            String::new(),
            "[fit.prior.values]            # factors of the torque constants above".into(),
        ]);
        lines.extend(gains);
    }
    lines.join("\n") + "\n"
}

/// Prior knowledge of the factors of torque constants, a line for each joint that moves; none of a single one, whose factor scales all
/// that is unknown.
fn gains(guess: &Guess<'_>) -> Vec<String> {
    if !guess.has_gains() {
        return Vec::new();
    }
    let gain = term_name(JointTerm::Gain);
    let line = |joint: &String| {
        let name = text(&format!("{joint}.{gain}"));
        format!("{name} = {{ value = 1.0, std_dev = {OF_CONSTANTS} }}")
    };
    guess.moving().iter().map(line).collect()
}

/// Three digits of a number.
fn rounded(value: f64) -> String {
    let three = format!("{value:.2e}");
    three
        .parse()
        .map_or(three, |number: f64| format!("{number:?}"))
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

/// A path from the folder of the problem file: as it is where it is absolute, and where links on the way make it unsure how to go up.
fn relative(path: &Path, target: &Path) -> String {
    let folder = target.parent().unwrap_or(Path::new(""));
    let whole = || std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let path = match path.strip_prefix(folder) {
        Ok(below) => below.to_path_buf(),
        Err(_) if path.is_absolute() => path.to_path_buf(),
        Err(_) => climbed(path, folder).unwrap_or_else(whole),
    };
    path.display().to_string()
}

/// A path from a folder that it is not below: up to what both have in common, and down again. `None` where a link stands in the
/// folder, whose upper folder is another one than it seems.
fn climbed(path: &Path, folder: &Path) -> Option<PathBuf> {
    let [path, folder] = [path, folder].map(|p| std::path::absolute(p).ok());
    let (path, folder) = (path?, folder?);
    let there = folder.ancestors().find(|above| above.exists())?;
    if there.canonicalize().ok()? != there {
        return None;
    }
    let plain = |c: &Component<'_>| !matches!(c, Component::ParentDir);
    if !path
        .components()
        .chain(folder.components())
        .all(|c| plain(&c))
    {
        return None;
    }
    let pairs = path.components().zip(folder.components());
    let common = pairs.take_while(|(a, b)| a == b).count();
    let up = folder
        .components()
        .skip(common)
        .map(|_| Component::ParentDir);
    Some(up.chain(path.components().skip(common)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_lead_from_the_problem_file_to_the_files() {
        let relative = |path: &str, target: &str| relative(Path::new(path), Path::new(target));
        assert_eq!(relative("a.csv", "problem.toml"), "a.csv");
        assert_eq!(relative("arm/a.csv", "arm/problem.toml"), "a.csv");
        assert_eq!(relative("runs/a.csv", "arm/problem.toml"), "../runs/a.csv");
        assert_eq!(relative("a.csv", "arm/new/problem.toml"), "../../a.csv");
        assert_eq!(relative("/data/a.csv", "arm/problem.toml"), "/data/a.csv");
    }
}
