//! What the files of a robot and its recordings are taken to say.

use crate::check::SignalScale;
use crate::init::channels::{Channel, Channels};
use crate::init::error::InitError;
use crate::init::measure::{self, Standing};
use crate::init::named_column::NamedColumn;
use crate::outcome::check::Mistake;
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
    /// Columns whose names do not say what they hold.
    pub columns: Vec<NamedColumn>,
    /// Samples per second of recordings without time stamps, Hz.
    pub rate: Option<f64>,
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

/// Torque constants of the joints, N·m/A at the joint side (N/A).
pub(super) struct TorqueConstants {
    pub(super) values: Vec<f64>,
    /// Whether the recordings were held against the robot file's inertials.
    is_measured: bool,
    /// Whether these speak for the constants; else all are one.
    pub(super) by_inertials: bool,
}

impl TorqueConstants {
    fn ones(count: usize) -> Self {
        Self {
            values: vec![1.0; count],
            is_measured: false,
            by_inertials: false,
        }
    }

    /// Those for which the recorded currents are the torques of the robot file's inertials, where constants of one were declared. A joint
    /// that this says nothing of is given the mean of the others.
    fn of(joints: &[String], scales: &[SignalScale]) -> Self {
        let constant = |joint: &String| {
            let own = scales.iter().find(|scale| scale.joint == *joint);
            own.map(|scale| scale.factor.recip())
                .filter(|constant| *constant > 0.0 && constant.is_finite())
        };
        let own: Vec<Option<f64>> = joints.iter().map(constant).collect();
        let known: Vec<f64> = own.iter().flatten().map(|k| k.ln()).collect();
        let mean = match known.is_empty() {
            true => 1.0,
            false => (known.iter().sum::<f64>() / known.len() as f64).exp(),
        };
        Self {
            values: own.iter().map(|k| k.unwrap_or(mean)).collect(),
            is_measured: true,
            by_inertials: !known.is_empty(),
        }
    }
}

/// What the files are taken to say.
pub(super) struct Guess<'a> {
    pub(super) tree: &'a Tree,
    pub(super) channels: Channels,
    pub(super) train: Vec<PathBuf>,
    pub(super) validation: Vec<PathBuf>,
    /// Joints that stand still; those without a column are taken to stand at zero.
    pub(super) locked: Vec<Standing>,
    /// Of currents.
    pub(super) constants: Option<TorqueConstants>,
    /// After how many seconds the motion repeats.
    pub(super) period: Option<f64>,
    /// Hz, of recordings without time stamps.
    pub(super) rate: Option<f64>,
    is_rate_given: bool,
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
        let mut channels = Channels::of(first, &present, &names, &sources.columns)?;
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
        let measured = measure::measure(first, &mut channels, &names, sources.rate)?;
        let is_current = channels.kind == SignalKind::Current;
        let constants = is_current.then(|| TorqueConstants::ones(names.len()));
        let locked = measure::standing(&used, &channels, &names)?;
        remarks.extend(measured.remarks);
        let (train, validation) = split(used);
        Ok(Self {
            tree,
            channels,
            train,
            validation,
            locked,
            constants,
            period: measured.period,
            rate: sources.rate.or(measured.rate),
            is_rate_given: sources.rate.is_some(),
            remarks,
        })
    }

    /// Names of the joints, in the order of the tree.
    fn names(&self) -> Vec<String> {
        let joints = self.tree.joints().iter();
        joints.map(|joint| joint.name.clone()).collect()
    }

    /// Names of the joints that move.
    pub(super) fn moving(&self) -> Vec<String> {
        let mut names = self.names();
        let stand = |name: &String| self.locked.iter().any(|locked| locked.joint == *name);
        names.retain(|name| !stand(name));
        names
    }

    /// Whether every body has a mass in the robot file.
    pub(super) fn has_inertials(&self) -> bool {
        let mut joints = self.tree.joints().iter();
        joints.all(|joint| joint.inertia.mass() > 0.0)
    }

    /// Whether signals are currents whose torque constants have not been measured.
    pub(super) fn asks_for_constants(&self) -> bool {
        self.constants.as_ref().is_some_and(|c| !c.is_measured)
    }

    /// Takes the constants that signals show, beside constants of one.
    pub(super) fn take_constants(&mut self, scales: &[SignalScale]) {
        self.constants = Some(TorqueConstants::of(&self.names(), scales));
    }

    /// Changes what the checks of the inputs object to and units explain; whether anything was.
    ///
    /// # Errors
    /// Those of files.
    pub(super) fn amend(&mut self, findings: &[Mistake]) -> Result<bool, InitError> {
        let has = |code: &str| findings.iter().any(|f| f.code == code);
        if has("position-in-degrees") && self.channels.position.unit.is_none() {
            self.channels.position.unit = Some("deg");
            // Velocities agreed with positions as they were.
            if let Some(velocity) = &mut self.channels.velocity {
                velocity.unit = Some("deg/s");
            }
            self.remarks.push(
                "positions are too large for radians (beyond the limits of the joints, or many turns) and are taken as degrees; should \
                 they be the motors' own turns, state recordings.position_side = \"motor\" and drive.ratio"
                    .into(),
            );
            let used = [&self.train[..], &self.validation].concat();
            self.locked = measure::standing(&used, &self.channels, &self.names())?;
            return Ok(true);
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
            return Ok(true);
        }
        Ok(false)
    }

    /// What the files do not show, one sentence each.
    pub(super) fn assumed(&self) -> Vec<String> {
        let mut all = self.remarks.clone();
        let of = |recorded: bool| {
            let joints = self.locked.iter().filter(|l| l.is_recorded == recorded);
            joints.map(|l| l.joint.clone()).collect::<Vec<String>>()
        };
        let [without, still] = [of(false), of(true)];
        if !without.is_empty() {
            let said = match without.len() {
                1 => "has no column and is",
                _ => "have no columns and are",
            };
            all.push(format!("{} {said} taken to stand at 0", without.join(", ")));
        }
        if !still.is_empty() {
            let said = match still.len() {
                1 => "stands still, and is locked where it does",
                _ => "stand still, and are locked where they do",
            };
            all.push(format!(
                "{} {said}: what does not move has no friction to fit",
                still.join(", ")
            ));
        }
        match self.channels.kind {
            SignalKind::PositionCommand if self.has_inertials() => all.push(
                "no torque channel: torques follow from commanded positions and the gains of the controllers, which are estimated with the \
                 robot file's inertials as known; with gains that are known under controller.kp and controller.kd, robot.inertials = \
                 \"estimate\" has the inertials estimated"
                    .into(),
            ),
            SignalKind::PositionCommand => all.push(
                "no torque channel: torques follow from commanded positions and the gains of the controllers; state these under \
                 controller.kp and controller.kd, or complete the robot file's inertials and say robot.inertials = \"known\" to \
                 estimate them"
                    .into(),
            ),
            SignalKind::Current => {
                let signal = &self.channels.signal;
                if signal.is_voltage() {
                    all.push(format!(
                        "`{}` is taken to ask an amplifier for a current, and stands for it: with V in the place of A, torque constants are \
                         in N·m/V (N/V)",
                        signal.written()
                    ));
                }
                all.push(self.of_torque_constants());
            }
            _ => all.push(
                "torques are taken to be those of the motors at the joint side; sensors behind the gear are signal = \
                 \"link_torque\""
                    .into(),
            ),
        }
        if let Some(rate) = self.rate.filter(|_| !self.is_rate_given) {
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

    /// Whether the factors of the torque constants are estimated. That of a single joint scales all that is unknown.
    pub(super) fn has_gains(&self) -> bool {
        self.constants.is_some() && self.moving().len() > 1
    }

    fn of_torque_constants(&self) -> String {
        let by_inertials = self.constants.as_ref().is_some_and(|c| c.by_inertials);
        let known = match (by_inertials, self.has_gains()) {
            (true, true) => {
                ": they are those that the robot file's inertials ask for, to a third, and what makes them agree with each other is estimated"
            }
            (true, false) => {
                ": they are those that the robot file's inertials ask for, to a third, as a factor of a single joint's scales all that is unknown"
            }
            (false, _) => {
                ", nor do inertials of the robot file speak for any: with 1 N·m/A (N/A), all parameters come out divided by one common factor"
            }
        };
        let remedy = match self.has_gains() {
            true => " and leave their gains out",
            false => "",
        };
        format!(
            "torque constants are not known{known}; state those of the robot under drive.torque_constant{remedy}"
        )
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
