//! The signal against a model in which everything that is linear is free: `s_c = Y_c π + ε`, channel by channel.
//!
//! Only the form of the rigid body, simple friction, rotors and offsets are taken for granted, so that a
//! residual judges the columns of a recording and not the values in a file.

use crate::chain::dataset::Prepared;
use crate::chain::effect::knowledge::JointTerm;
use crate::chain::effect::{Effect, of_term};
use crate::chain::evaluate::{BLOCK, Evaluator, Segment};
use crate::chain::model::{Channel, Inertials, Model, ModelSettings, Signal};
use crate::check::extent::extent;
use crate::linalg::triangular::Triangular;
use crate::recording::noise_level::{pieces, white_deviation};
use crate::robot::batch::Trajectory;
use crate::robot::tree::{JointKind, Tree};
use nalgebra::{DMatrix, DVector};

/// Rows that a comparison uses: 20 for each of 100 columns.
const MOST_ROWS: usize = 2000;

/// Free terms of the comparison, in the order of their columns: friction last, where it is solved for alone.
const TERMS: [JointTerm; 4] = [
    JointTerm::RotorInertia,
    JointTerm::Offset,
    JointTerm::DryFriction,
    JointTerm::ViscousFriction,
];

/// Motion of all motors at the rows of a comparison.
#[derive(Debug, Clone)]
pub(super) struct Sampled {
    /// Rows of the experiment.
    pub rows: Vec<usize>,
    pub position: Vec<Vec<f64>>,
    pub velocity: Vec<Vec<f64>>,
    pub acceleration: Vec<Vec<f64>>,
    pub loaded: bool,
}

impl Sampled {
    /// Rows that count, evenly thinned, at least `margin` rows from both ends.
    pub fn new(prepared: &Prepared, margin: usize) -> Self {
        let experiment = &prepared.experiment;
        let counts = |k: &usize| experiment.mask.as_ref().is_none_or(|mask| mask[*k]);
        let inner = margin..experiment.rows().saturating_sub(margin);
        let all: Vec<usize> = inner.filter(counts).collect();
        let stride = all.len().div_ceil(MOST_ROWS).max(1);
        let rows: Vec<usize> = all.into_iter().step_by(stride).collect();
        let take = |series: &Vec<Vec<f64>>| -> Vec<Vec<f64>> {
            series
                .iter()
                .map(|s| rows.iter().map(|&k| s[k]).collect())
                .collect()
        };
        let motion = &experiment.motion;
        Self {
            position: take(&motion.position),
            velocity: take(&motion.velocity),
            acceleration: take(&motion.acceleration),
            loaded: prepared.loaded,
            rows,
        }
    }

    pub fn len(&self) -> usize {
        self.rows.len()
    }

    fn segment(&self) -> Segment<'_> {
        let motors = Trajectory {
            q: &self.position,
            dq: &self.velocity,
            ddq: &self.acceleration,
        };
        Segment::states(motors, self.loaded)
    }
}

/// Columns of one channel: parameter and series.
pub(super) type Columns = Vec<(usize, Vec<f64>)>;

/// Columns of some parameters over sampled motion, `[channel]`; columns that are zero are left out.
pub(super) fn columns(model: &Model, sampled: &Sampled, parameters: &[usize]) -> Vec<Columns> {
    let mut evaluator = Evaluator::new(model, &model.values(), parameters);
    let mut out: Vec<Columns> = vec![Vec::new(); model.channels().len()];
    for start in (0..sampled.len()).step_by(BLOCK) {
        let end = sampled.len().min(start + BLOCK);
        let block = evaluator.evaluate(sampled.segment(), start..end);
        for (c, columns) in out.iter_mut().enumerate() {
            for (index, &parameter) in parameters.iter().enumerate() {
                let Some(series) = block.derivative(c, index) else {
                    continue;
                };
                let at = columns.iter().position(|(p, _)| *p == parameter);
                let at = at.unwrap_or_else(|| {
                    columns.push((parameter, vec![0.0; start]));
                    columns.len() - 1
                });
                columns[at].1.resize(start, 0.0);
                columns[at].1.extend_from_slice(series);
            }
        }
    }
    for columns in &mut out {
        columns
            .iter_mut()
            .for_each(|(_, series)| series.resize(sampled.len(), 0.0));
        columns.retain(|(_, series)| series.iter().any(|x| *x != 0.0));
        columns.sort_by_key(|(p, _)| *p);
    }
    out
}

/// What the known parameters of a model predict over sampled motion, `[channel][row]`.
pub(super) fn known_part(model: &Model, sampled: &Sampled) -> Vec<Vec<f64>> {
    let mut evaluator = Evaluator::new(model, &model.values(), &[]);
    let mut out = vec![Vec::new(); model.channels().len()];
    for start in (0..sampled.len()).step_by(BLOCK) {
        let end = sampled.len().min(start + BLOCK);
        let block = evaluator.evaluate(sampled.segment(), start..end);
        for (c, series) in out.iter_mut().enumerate() {
            series.extend_from_slice(block.value(c));
        }
    }
    out
}

/// The triangular factor of columns and right-hand sides, in this order.
pub(super) fn factor(columns: &Columns, right: &[&[f64]]) -> Triangular {
    let mut factor = Triangular::new(columns.len() + right.len());
    let series = columns.iter().map(|(_, series)| series.as_slice());
    let all: Vec<&[f64]> = series.chain(right.iter().copied()).collect();
    factor.absorb_columns(&all);
    factor
}

/// Norm of what columns leave of the right-hand side with this index.
pub(super) fn rest(factor: &Triangular, columns: usize, index: usize) -> f64 {
    let entries = (columns..=columns + index).map(|i| factor.entry(i, columns + index));
    entries.map(|x| x * x).sum::<f64>().sqrt()
}

/// The last `count` coefficients of the least squares fit to a single right-hand side, and their covariance
/// for residuals of unit variance; `None` where they are not determined.
pub(super) fn last_coefficients(
    factor: &Triangular,
    columns: usize,
    count: usize,
) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let first = columns.checked_sub(count)?;
    let matrix = DMatrix::from_fn(count, count, |i, j| factor.entry(first + i, first + j));
    let right = DVector::from_fn(count, |i, _| factor.entry(first + i, columns));
    let inverse = matrix.try_inverse()?;
    let covariance = &inverse * inverse.transpose();
    Some((inverse * right, covariance))
}

/// Motion below which a joint stands still: 3 degrees, or 1 cm.
pub(super) fn still(kind: JointKind) -> f64 {
    match kind {
        JointKind::Revolute => 0.05,
        JointKind::Prismatic => 0.01,
    }
}

/// A recording beside a model with everything free.
pub(super) struct Comparison {
    /// Signals are torques at joint scale.
    pub model: Model,
    pub parameters: Vec<usize>,
    pub sampled: Sampled,
    /// Torque of each channel at the sampled rows.
    pub torque: Vec<Vec<f64>>,
    /// Deviation of the noise of each of them, where it is seen to be white.
    pub noise: Vec<Option<f64>>,
    pub columns: Vec<Columns>,
}

impl Comparison {
    pub fn new(declared: &Model, prepared: &Prepared) -> Self {
        let model = free_model(declared);
        let parameters: Vec<usize> = (0..model.parameters().len())
            .filter(|&p| model.parameters()[p].is_linear_unknown())
            .collect();
        let sampled = Sampled::new(prepared, 0);
        let torque = torques(declared, prepared, &sampled);
        Self {
            columns: columns(&model, &sampled, &parameters),
            noise: noise(declared, prepared),
            model,
            parameters,
            sampled,
            torque,
        }
    }

    /// Channels that are predicted and belong to a joint: (channel, joint).
    pub fn joint_channels(&self) -> Vec<(usize, usize)> {
        let channels = self.model.channels().iter().enumerate();
        let of =
            |(c, channel): (usize, &Channel)| Some((c, channel.joint.filter(|_| channel.active)?));
        channels.filter_map(of).collect()
    }

    /// Whether a joint moves enough to be judged: see [`still`].
    pub fn moves(&self, joint: usize) -> bool {
        let (low, high) = extent(self.sampled.position[joint].iter().copied());
        high - low > still(self.model.joints()[joint].kind)
    }

    /// Standard deviation of the residual of a channel.
    pub fn residual(&self, channel: usize) -> f64 {
        let columns = &self.columns[channel];
        let factor = factor(columns, &[&self.torque[channel]]);
        let freedom = self.sampled.len().saturating_sub(columns.len()).max(1);
        rest(&factor, columns.len(), 0) / (freedom as f64).sqrt()
    }

    /// Whether there are rows enough to judge anything.
    pub fn is_meaningful(&self) -> bool {
        let widest = self.columns.iter().map(Vec::len).max().unwrap_or(0);
        self.sampled.len() > 3 * widest
    }
}

/// Torques of all channels at sampled rows: currents times torque constants.
fn torques(declared: &Model, prepared: &Prepared, sampled: &Sampled) -> Vec<Vec<f64>> {
    let of = |(channel, signal): (&Channel, &Vec<f64>)| {
        let constant = torque_per_unit(declared, channel);
        sampled.rows.iter().map(|&k| constant * signal[k]).collect()
    };
    let channels = declared.channels().iter();
    channels.zip(&prepared.experiment.signal).map(of).collect()
}

/// Deviations of the white noise of one row of all torques.
fn noise(declared: &Model, prepared: &Prepared) -> Vec<Option<f64>> {
    let mask = prepared.experiment.mask.as_deref();
    let of = |(channel, signal): (&Channel, &Vec<f64>)| {
        let constant = torque_per_unit(declared, channel);
        white_deviation(&pieces(signal, mask)).map(|deviation| constant.abs() * deviation)
    };
    let channels = declared.channels().iter();
    channels.zip(&prepared.experiment.signal).map(of).collect()
}

/// Torque of a channel's joint per unit of its signal; 1 where it has none.
fn torque_per_unit(declared: &Model, channel: &Channel) -> f64 {
    let joint = channel.joint;
    joint.map_or(1.0, |joint| declared.torque_per_signal(joint))
}

/// The robot of a model with all its inertial parameters and simple drives free.
fn free_model(declared: &Model) -> Model {
    with_tree(declared, declared.tree().clone())
}

/// As the free model, for a tree with the same joints.
pub(super) fn with_tree(declared: &Model, tree: Tree) -> Model {
    let n = declared.joints().len();
    let effects: Vec<&'static Effect> = TERMS.iter().map(|term| of_term(*term)).collect();
    let settings = ModelSettings {
        tree,
        signal: match declared.signal() {
            Signal::Current | Signal::PositionCommand => Signal::Torque,
            other => other,
        },
        inertials: Inertials::Estimate,
        controllers: None,
        torque_constant: None,
        torque_constant_std: None,
        current_polynomial: None,
        rotor_inertia: None,
        coupling: Some(declared.coupling(&declared.values())),
        offset: Some(declared.offset().iter().copied().collect()),
        effects: vec![effects; n],
        crosstalk: Vec::new(),
        shared: Vec::new(),
        catalogue: declared.catalogue().clone(),
        period: declared.period(),
        payload: declared.payload().map(|(payload, _)| payload),
        locked: declared.joints().iter().map(|joint| joint.locked).collect(),
    };
    // The declared model has been built from the same tree and coupling, so this one can be built too.
    let mut free = Model::new(settings).unwrap_or_else(|_| declared.clone());
    if let Some(reference) = declared.reference() {
        free.record_joints(reference.clone());
    }
    free
}
