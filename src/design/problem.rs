//! Excitation as an optimisation problem: Fourier coefficients are the variables, the criterion is the smooth objective, torque,
//! workspace and loop limits are the rows `g >= 0`; limits that are linear in the coefficients stand apart (see
//! [`crate::design::constraints::joint_limits`]).

use std::sync::{Mutex, PoisonError};

use nalgebra::{DMatrix, DVector};

use crate::chain::model::Model;
use crate::design::constraints::loop_limits::LoopRows;
use crate::design::constraints::torque_limits::Torques;
use crate::design::constraints::workspace::{Rule, Workspace};
use crate::design::criterion::model_discrimination::{self, Rivals};
use crate::design::criterion::parameters_of_interest::Target;
use crate::design::information::columns::Columns;
use crate::design::information::observation_matrix::{Observation, Workspace as Memory};
use crate::design::information::torque_laws::{SMOOTHING, SpeedScale};
use crate::design::trajectory::finite_differences::{self, AlongMotion};
use crate::design::trajectory::fourier_series::Basis;
use crate::design::trajectory::motion::{Joints, Motion};
use crate::problem::form::{Constraint, Form, Objective, Set, Structure, Variable};
use crate::problem::{Linearization, OutsideDomain, Problem, Values};
use crate::setup::limits::JointLimits;

/// What all starts of a search share.
#[derive(Debug)]
pub struct Experiment<'m> {
    /// The joints that move, and the layout of the coefficients.
    pub joints: Joints,
    /// Their functions at the samples.
    pub basis: Basis,
    /// Limits of each joint.
    pub bounds: Vec<JointLimits>,
    /// W of a motion, with derivatives.
    pub observation: Observation<'m>,
    /// Torque limits as rows.
    pub torques: Torques<'m>,
    /// Cartesian limits as rows.
    pub workspace: Workspace<'m>,
    /// Where the robot closes loops.
    pub loops: Option<LoopRows>,
    /// What is judged.
    pub target: Target<'m>,
    /// Models that are to be told apart, in place of the target.
    pub rivals: Option<Rivals<'m>>,
}

/// What an experiment is made of.
#[derive(Debug)]
pub struct Plan<'m> {
    /// The model that the motion is for.
    pub model: &'m Model,
    /// The columns of its observation matrix.
    pub columns: &'m Columns,
    /// Parameter values that torques are predicted with.
    pub values: &'m DVector<f64>,
    /// Runs without and with the load.
    pub loads: &'m [bool],
    /// The joints that move, and the layout of the coefficients.
    pub joints: Joints,
    /// Per period.
    pub samples: usize,
    /// Limits of each joint.
    pub bounds: Vec<JointLimits>,
    /// Cartesian limits.
    pub rules: Vec<Rule>,
    /// What is judged.
    pub target: Target<'m>,
    /// Models that are to be told apart, in place of the target.
    pub rivals: Option<Rivals<'m>>,
}

impl<'m> Plan<'m> {
    /// Lays out the criterion, the torque rows and the Cartesian rows.
    pub fn experiment(self) -> Experiment<'m> {
        let of = |bounds: &JointLimits| SpeedScale {
            largest: bounds.velocity,
            transition: SMOOTHING * bounds.velocity,
        };
        let speeds: Vec<SpeedScale> = self.bounds.iter().map(of).collect();
        let values = self.values.as_slice();
        let observation = Observation::new(self.model, self.columns, values, &speeds);
        let torque: Vec<Option<f64>> = self.bounds.iter().map(|b| b.torque).collect();
        Experiment {
            basis: Basis::new(self.joints.series, self.samples),
            torques: Torques::new(&observation, self.values, self.loads, &torque),
            workspace: Workspace {
                tree: self.model.tree(),
                rules: self.rules,
            },
            loops: self.joints.loops.as_ref().map(LoopRows::new),
            target: self.target,
            rivals: self.rivals,
            observation,
            bounds: self.bounds,
            joints: self.joints,
        }
    }
}

impl Experiment<'_> {
    /// The word of what is optimised.
    pub fn criterion_id(&self) -> &'static str {
        match &self.rivals {
            Some(_) => model_discrimination::ID,
            None => self.target.criterion.id(),
        }
    }

    /// What the reported value is.
    pub fn criterion_meaning(&self) -> &'static str {
        match &self.rivals {
            Some(_) => model_discrimination::MEANING,
            None => self.target.criterion.meaning(),
        }
    }

    /// Exponents with which a search works through.
    pub fn exponents(&self) -> &'static [f64] {
        match &self.rivals {
            Some(_) => &[1.0],
            None => self.target.criterion.exponents(),
        }
    }

    /// The criterion's reported value; infinite where the motion determines nothing.
    pub fn value(&self, x: &DVector<f64>) -> f64 {
        if let Some(rivals) = &self.rivals {
            return rivals.value(&Motion::of(&self.joints, &self.basis, x), &self.basis);
        }
        let matrix = self.target.matrix(&self.information(x));
        matrix.map_or(f64::INFINITY, |m| self.target.criterion.value(&m))
    }

    /// Information of a motion of coefficients x; none where the loops do not close along it.
    pub fn information(&self, x: &DVector<f64>) -> DMatrix<f64> {
        let motion = Motion::of(&self.joints, &self.basis, x);
        if motion.is_open {
            let count = self.observation.columns().len();
            return DMatrix::zeros(count, count);
        }
        let mut memory = self.observation.workspace(motion.len());
        self.observation.information(&motion, &mut memory)
    }

    /// Names, units and scales of the variables; number and kind of the rows.
    fn form(&self) -> Form {
        let model = self.observation.model();
        let h = self.joints.series.harmonics;
        let mut variables = Vec::new();
        for trajectory in 0..self.joints.trajectories {
            for &j in &self.joints.moving {
                let joint = &model.tree().joints()[j];
                let unit = joint.kind.position_unit();
                let of = |name: String, unit: String, scale: f64| {
                    Variable::free(format!("{}.{name}[{trajectory}]", joint.name), unit)
                        .scale(scale)
                };
                let bounds = &self.bounds[j];
                let half = bounds.half_range();
                variables.push(of("q0".into(), unit.into(), half));
                let velocity = amplitude(bounds, half, self.joints.series.period);
                for name in ["a", "b"] {
                    variables.extend(
                        (1..=h).map(|l| of(format!("{name}{l}"), format!("{unit}/s"), velocity)),
                    );
                }
            }
        }
        let samples = self.joints.trajectories * self.basis.samples;
        let mut constraints = Vec::new();
        for limited in &self.torques.limited {
            constraints.push(Constraint {
                name: format!("torque of {}", model.tree().joints()[limited.joint].name),
                unit: "1".to_string(),
                rows: 2 * samples,
                set: Set::Nonnegative,
            });
        }
        constraints.extend(self.workspace.rules.iter().map(|rule| Constraint {
            name: rule.name(),
            unit: rule.unit().to_string(),
            rows: samples,
            set: Set::Nonnegative,
        }));
        let loops = self.loops.iter().flat_map(LoopRows::limits);
        constraints.extend(loops.map(|loops| Constraint {
            name: loops.name.clone(),
            unit: loops.unit.to_string(),
            rows: samples,
            set: Set::Nonnegative,
        }));
        Form {
            variables,
            objective: Objective::Smooth,
            constraints,
            structure: Structure::Smooth,
        }
    }
}

/// A velocity amplitude that matters: what the velocity limit and the range let the fundamental have.
fn amplitude(bounds: &JointLimits, half: f64, period: f64) -> f64 {
    let of_range = half * std::f64::consts::TAU / period;
    bounds.velocity.min(of_range)
}

/// One optimisation problem of an experiment.
#[derive(Debug)]
pub struct Excitation<'a> {
    experiment: &'a Experiment<'a>,
    form: Form,
    /// ρ of the criterion's means.
    exponent: f64,
    /// Limits of torque and workspace are tightened to this share, so that they hold between samples.
    shrink: f64,
    memory: Mutex<Memories>,
}

#[derive(Debug)]
struct Memories {
    motion: Motion,
    slopes: Motion,
    observation: Memory,
}

impl<'a> Excitation<'a> {
    /// The problem over the coefficients, with ρ = `exponent` in the means that stand for a criterion's extremes; torque and
    /// workspace keep to the share `shrink` of their limits.
    pub fn new(experiment: &'a Experiment<'a>, exponent: f64, shrink: f64) -> Self {
        let motion = Motion::new(&experiment.joints, experiment.basis.samples);
        let mut slopes = motion.clone();
        slopes.clear();
        Self {
            form: experiment.form(),
            exponent,
            shrink,
            memory: Mutex::new(Memories {
                observation: experiment.observation.workspace(motion.len()),
                motion,
                slopes,
            }),
            experiment,
        }
    }

    /// g at coefficients x, without the criterion.
    pub fn constraints(&self, x: &DVector<f64>) -> DVector<f64> {
        let joints = &self.experiment.joints;
        self.rows(&Motion::of(joints, &self.experiment.basis, x))
    }

    /// g at a motion.
    fn rows(&self, motion: &Motion) -> DVector<f64> {
        if motion.is_open {
            // Nothing holds where the loops do not close.
            return DVector::from_element(self.form.constraint_rows(), -1.0);
        }
        let torques = self.experiment.torques.values(motion);
        let mut rows = self.experiment.torques.margins(&torques, self.shrink);
        // A tightened rule keeps a distance of the same share of a metre, or of its limit.
        let room = 1.0 - self.shrink;
        for series in self.experiment.workspace.values(motion) {
            rows.extend(series.into_iter().map(|value| value - room));
        }
        if let Some(loops) = &self.experiment.loops {
            for (series, of) in loops.values(motion).into_iter().zip(loops.limits()) {
                rows.extend(series.into_iter().map(|value| value - room * of.limit));
            }
        }
        DVector::from_vec(rows)
    }

    /// ∂g/∂x at a motion.
    fn row_slopes(&self, motion: &Motion) -> DMatrix<f64> {
        let experiment = self.experiment;
        let (joints, basis) = (&experiment.joints, &experiment.basis);
        let samples = motion.len();
        let mut jacobian = DMatrix::zeros(self.form.constraint_rows(), self.form.variables.len());
        if joints.loops.is_some() {
            let mut rows = Rows { excitation: self };
            let limits = &experiment.bounds;
            finite_differences::slopes(&mut rows, motion, joints, limits, |shifted, by| {
                finite_differences::to_coefficients(&mut jacobian, joints, basis, shifted, by);
            });
            return jacobian;
        }
        let torques = &experiment.torques;
        let first = torques.rows(samples);
        torques.jacobian(
            motion,
            self.shrink,
            joints,
            basis,
            jacobian.rows_mut(0, first),
        );
        for (r, slopes) in experiment.workspace.slopes(motion).iter().enumerate() {
            for trajectory in 0..joints.trajectories {
                for (m, &i) in joints.moving.iter().enumerate() {
                    for c in 0..joints.series.width() {
                        let (position, velocity) = (basis.function(0, c), basis.function(1, c));
                        let mut column = jacobian.column_mut(joints.first(trajectory, m) + c);
                        for k in 0..basis.samples {
                            let s = trajectory * basis.samples + k;
                            column[first + r * samples + s] =
                                slopes[0][i][s] * position[k] + slopes[1][i][s] * velocity[k];
                        }
                    }
                }
            }
        }
        jacobian
    }
}

/// The rows g of an excitation along motions.
struct Rows<'a> {
    excitation: &'a Excitation<'a>,
}

impl AlongMotion for Rows<'_> {
    fn series(&mut self, motion: &Motion) -> Vec<Vec<f64>> {
        finite_differences::blocks(&self.excitation.rows(motion), motion.len())
    }
}

fn open() -> OutsideDomain {
    OutsideDomain::new("the loops of the mechanism do not close along the motion")
}

fn singular() -> OutsideDomain {
    OutsideDomain::new("the motion does not determine the parameters")
}

impl Problem for Excitation<'_> {
    fn form(&self) -> &Form {
        &self.form
    }

    fn values(&self, x: &DVector<f64>) -> Result<Values, OutsideDomain> {
        let mut memory = self.memory.lock().unwrap_or_else(PoisonError::into_inner);
        let Memories {
            motion,
            observation,
            ..
        } = &mut *memory;
        let experiment = self.experiment;
        motion.set(&experiment.joints, &experiment.basis, x);
        if motion.is_open {
            return Err(open());
        }
        let cost = match &experiment.rivals {
            Some(rivals) => rivals.minimised(motion, &experiment.basis),
            None => {
                let information = experiment.observation.information(motion, observation);
                experiment.target.minimised(&information, self.exponent)
            }
        };
        Ok(Values {
            cost: cost.ok_or_else(singular)?,
            constraints: self.rows(motion),
        })
    }

    fn linearize(&self, x: &DVector<f64>) -> Result<Linearization, OutsideDomain> {
        let mut memory = self.memory.lock().unwrap_or_else(PoisonError::into_inner);
        let Memories {
            motion,
            slopes,
            observation,
        } = &mut *memory;
        let experiment = self.experiment;
        motion.set(&experiment.joints, &experiment.basis, x);
        if motion.is_open {
            return Err(open());
        }
        let (joints, basis) = (&experiment.joints, &experiment.basis);
        let (cost, gradient) = if let Some(rivals) = &experiment.rivals {
            let graded = rivals.graded(joints, basis, x);
            let graded = graded.ok_or_else(singular)?;
            (graded.value, graded.gradient)
        } else {
            let information = experiment.observation.information(motion, observation);
            let graded = experiment.target.graded(&information, self.exponent);
            let graded = graded.ok_or_else(singular)?;
            slopes.clear();
            let of = &experiment.observation;
            if joints.loops.is_some() {
                let mut weighted = of.weighted(&graded.gradient, observation);
                let limits = &experiment.bounds;
                finite_differences::slopes(&mut weighted, motion, joints, limits, |shifted, by| {
                    let joint = joints.moving[shifted.motor];
                    slopes.values[shifted.order][joint].copy_from_slice(&by[0]);
                });
            } else {
                of.pull(motion, &graded.gradient, observation, slopes);
            }
            let mut gradient = DVector::zeros(x.len());
            slopes.pull(joints, basis, &mut gradient);
            (graded.value, gradient)
        };
        Ok(Linearization {
            cost,
            gradient,
            square_root: None,
            constraints: self.rows(motion),
            jacobian: self.row_slopes(motion),
        })
    }
}
