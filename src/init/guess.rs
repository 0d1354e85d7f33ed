//! What the files of a robot and its recordings are taken to say.

use crate::init::channels::Channel;
use crate::init::channels::Channels;
use crate::init::error::InitError;
use crate::init::measure;
use crate::outcome::check::Finding;
use crate::problem::solution::Control;
use crate::recording::format::format_of;
use crate::recording::reading::Reading;
use crate::recording::samples::SignalKind;
use crate::robot::tree::Tree;
use std::ffi::OsStr;
use std::fs;
use std::path::Path;
use std::path::PathBuf;

/// What a problem file is made from.
#[derive(Debug, Clone)]
pub struct Sources {
    /// The robot's description: URDF, MJCF, or a table of modified Denavit-Hartenberg parameters (`.toml`).
    pub robot: PathBuf,
    /// At least one.
    pub recordings: Vec<PathBuf>,
    /// Where the problem file will be; paths in it start there.
    pub target: PathBuf,
}

/// How a robot is described.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Form {
    Urdf,
    /// A table of modified Denavit-Hartenberg parameters.
    Mdh,
    Mjcf,
}

impl Form {
    /// By the ending of a file, and of XML by its root.
    pub(super) fn of(robot: &Path) -> Self {
        let ending = robot.extension().map(|end| end.to_ascii_lowercase());
        let ending = ending.as_deref().and_then(OsStr::to_str);
        let is_model = || fs::read_to_string(robot).is_ok_and(|text| text.contains("<mujoco"));
        match ending {
            Some("toml") => Self::Mdh,
            Some("mjcf") => Self::Mjcf,
            Some("xml") if is_model() => Self::Mjcf,
            _ => Self::Urdf,
        }
    }

    /// The key of `[robot]` for such a file.
    pub(super) fn key(self) -> &'static str {
        match self {
            Self::Urdf => "urdf",
            Self::Mdh => "mdh",
            Self::Mjcf => "mjcf",
        }
    }
}

/// What the files are taken to say.
pub(super) struct Guess<'a> {
    pub(super) tree: &'a Tree,
    pub(super) channels: Channels,
    pub(super) train: Vec<PathBuf>,
    pub(super) validation: Vec<PathBuf>,
    /// Joints without a column, which are taken to stand at zero.
    pub(super) locked: Vec<String>,
    /// After how many seconds the motion repeats.
    pub(super) period: Option<f64>,
    /// Hz, of recordings without time stamps.
    pub(super) rate: Option<f64>,
    /// Sentences on what was left out and why.
    pub(super) remarks: Vec<String>,
}

impl<'a> Guess<'a> {
    pub(super) fn new(
        sources: &Sources,
        tree: &'a Tree,
        control: &Control<'_>,
    ) -> Result<Self, InitError> {
        let first = sources.recordings.first().ok_or(InitError::NoRecordings)?;
        let names: Vec<String> = tree.joints().iter().map(|j| j.name.clone()).collect();
        let reading = Reading {
            interrupt: control.interrupt.clone(),
            ..Reading::default()
        };
        let present = (format_of(first)?.columns)(first, &reading)?;
        let mut channels = Channels::of(first, &present, &names)?;
        let mut remarks = Vec::new();
        let mut used = Vec::new();
        for path in &sources.recordings {
            let present = (format_of(path)?.columns)(path, &reading)?;
            match channels.columns().find(|c| !present.contains(c)) {
                None => used.push(path.clone()),
                Some(lacking) => remarks.push(format!(
                    "{} is left out: it has no column `{lacking}`, which {} has",
                    path.display(),
                    first.display()
                )),
            }
        }
        let measured = measure::measure(first, &mut channels, &names)?;
        let joints = &channels.position.joints;
        let locked = (0..names.len()).filter(|j| !joints.contains(j));
        let locked = locked.map(|j| names[j].clone()).collect();
        remarks.extend(measured.remarks);
        let (train, validation) = split(used);
        Ok(Self {
            tree,
            channels,
            train,
            validation,
            locked,
            period: measured.period,
            rate: measured.rate,
            remarks,
        })
    }

    /// Changes what the checks of the inputs object to and units explain; whether anything was.
    pub(super) fn amend(&mut self, findings: &[Finding]) -> bool {
        let has = |code: &str| findings.iter().any(|f| f.code == code);
        if has("position-in-degrees") && self.channels.position.unit.is_none() {
            self.channels.position.unit = Some("deg");
            // Velocities agreed with positions as they were.
            if let Some(velocity) = &mut self.channels.velocity {
                velocity.unit = Some("deg/s");
            }
            self.remarks.push(
                "positions leave the limits of the joints as radians and keep to them as degrees; should they be the motors' own turns, \
                 state recordings.position_side = \"motor\" and drive.ratio"
                    .into(),
            );
            return true;
        }
        let doubts = [
            "velocity-factor",
            "velocity-not-derivative",
            "velocity-order",
        ];
        if let (Some(velocity), Some(code)) =
            (&self.channels.velocity, doubts.iter().find(|c| has(c)))
        {
            self.remarks.push(format!(
                "velocities ({}) are left out: they do not follow from the positions [{code}]",
                velocity.written()
            ));
            self.channels.velocity = None;
            return true;
        }
        false
    }

    /// What the files do not show, one sentence each.
    pub(super) fn assumed(&self) -> Vec<String> {
        let mut all = self.remarks.clone();
        if !self.locked.is_empty() {
            all.push(format!(
                "{} have no column and are taken to stand at 0",
                self.locked.join(", ")
            ));
        }
        match self.channels.kind {
            SignalKind::PositionCommand => all.push(
                "no torque channel: torques follow from commanded positions and the gains of the controllers; state these under \
                 controller.kp and controller.kd, or say robot.inertials = \"known\" to estimate them"
                    .into(),
            ),
            SignalKind::Current => all.push(
                "torque constants are not known: with 1 N·m/A, parameters come out divided by the true ones; state those of the \
                 robot under drive.torque_constant"
                    .into(),
            ),
            _ => all.push(
                "torques are taken to be those of the motors at the joint side; sensors behind the gear are signal = \
                 \"link_torque\""
                    .into(),
            ),
        }
        if let Some(rate) = self.rate {
            all.push(format!(
                "no time stamps: velocities against positions give a rate of {rate} Hz"
            ));
        }
        if self.validation.is_empty() {
            all.push("one recording alone: nothing is held out for `fit`".into());
        }
        all.push("positions are taken to be the joints', at the joint side of the gear".into());
        all
    }

    /// The channels that the problem file names, with the keys under which it does.
    pub(super) fn named(&self) -> Vec<(&'static str, &Channel)> {
        let signal = match self.channels.kind {
            SignalKind::PositionCommand => "command",
            SignalKind::Current => "current",
            _ => "torque",
        };
        let mut named: Vec<(&str, &Channel)> = Vec::new();
        named.extend(self.channels.time.as_ref().map(|c| ("time", c)));
        named.push(("position", &self.channels.position));
        named.extend(self.channels.velocity.as_ref().map(|c| ("velocity", c)));
        named.push((signal, &self.channels.signal));
        named
    }
}

/// Of several recordings one is held out: the one whose name says so, or the last.
pub(super) fn split(mut recordings: Vec<PathBuf>) -> (Vec<PathBuf>, Vec<PathBuf>) {
    if recordings.len() < 2 {
        return (recordings, Vec::new());
    }
    let says = |path: &PathBuf| {
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .to_lowercase();
        ["valid", "test", "held", "hold"]
            .iter()
            .any(|word| name.contains(word))
    };
    let at = recordings
        .iter()
        .position(says)
        .unwrap_or(recordings.len() - 1);
    let held_out = recordings.remove(at);
    (recordings, vec![held_out])
}
