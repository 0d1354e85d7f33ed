//! The columns of the observation matrix: the parameters that they are derivatives by, and the entries of the regressor in each.
//!
//! The signal of channel c (a motor) is `k_c (Σ_i V_ic τ_i + laws)`, so its derivative with respect to an
//! inertial parameter is a weighted sum of regressor entries, and with respect to a parameter of a law
//! what the law says. Columns are the kept parameters of the base, rows are weighted by the noise.

use nalgebra::DMatrix;

use crate::chain::model::{Model, Payload};
use crate::chain::parameter::Role;
use crate::design::information::torque_laws::of_the_state;
use crate::robot::inertia::PER_LINK;

/// No entry.
const NONE: u32 = u32::MAX;

/// Entries of the regressor that some column needs, numbered row by row.
#[derive(Debug, Clone)]
pub struct Entries {
    links: usize,
    /// `[row · links + link][quantity]`: number of the entry, or [`NONE`].
    at: Vec<[u32; PER_LINK]>,
    count: usize,
}

impl Entries {
    fn none(joints: usize) -> Self {
        Self {
            links: joints,
            at: vec![[NONE; PER_LINK]; joints * joints],
            count: 0,
        }
    }

    fn number(&mut self, row: usize, link: usize, quantity: usize) -> usize {
        let slot = &mut self.at[row * self.links + link][quantity];
        if *slot == NONE {
            *slot = self.count as u32;
            self.count += 1;
        }
        *slot as usize
    }

    /// Different entries of the regressor that the columns use.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Numbers of the entries of a link's ten columns in a row.
    #[inline(always)]
    pub fn of(&self, row: usize, link: usize) -> [Option<usize>; PER_LINK] {
        self.at[row * self.links + link].map(|n| (n != NONE).then_some(n as usize))
    }
}

/// An entry of the regressor in a column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// Number of the entry.
    pub entry: usize,
    /// Its factor in the column.
    pub weight: f64,
    /// The way to the motor of an entry of a joint that has none.
    pub carried: Option<CarriedBy>,
}

/// How loops carry a row of a joint without a motor to a motor, both by their places among their kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CarriedBy {
    /// Place among the joints without a motor.
    pub passive: usize,
    /// Place among the motors.
    pub motor: usize,
}

/// A row of the tree in that of a motor.
#[derive(Debug, Clone, Copy)]
struct Row {
    joint: usize,
    weight: f64,
    carried: Option<CarriedBy>,
}

/// The rows of the tree that a motor bears: those of joints that it turns, and those of joints without a motor that loops
/// carry to them.
fn rows_of(model: &Model, motor: usize, weight: f64, coupling: &DMatrix<f64>) -> Vec<Row> {
    let mut rows = Vec::new();
    for joint in 0..model.joints().len() {
        let weight = weight * coupling[(joint, motor)];
        if weight == 0.0 {
            continue;
        }
        rows.push(Row {
            joint,
            weight,
            carried: None,
        });
        let Some(mechanism) = model.mechanism() else {
            continue;
        };
        let Some(motor) = mechanism.actuated().iter().position(|&a| a == joint) else {
            continue;
        };
        for (passive, &joint) in mechanism.passive().iter().enumerate() {
            rows.push(Row {
                joint,
                weight,
                carried: Some(CarriedBy { passive, motor }),
            });
        }
    }
    rows
}

/// What a column is made of.
#[derive(Debug, Clone, PartialEq)]
pub enum Recipe {
    /// Σ weight · entry of the regressor.
    Bodies(Vec<Part>),
    /// A parameter of a law of the channel's motor, times the channel's weight.
    Law {
        /// Position among the effects of the motor's laws.
        effect: usize,
        /// Position among the effect's parameters.
        parameter: usize,
    },
}

/// The rows of one motor.
#[derive(Debug, Clone)]
pub struct Channel {
    /// The motor's joint in the tree.
    pub joint: usize,
    /// 1/(torque constant · standard deviation of the noise).
    pub weight: f64,
    /// Columns of the whole matrix that can be other than zero here.
    pub columns: Vec<usize>,
    /// What each of these columns is made of.
    pub recipes: Vec<Recipe>,
}

/// All columns.
#[derive(Debug, Clone)]
pub struct Columns {
    /// Parameter of the model of each column.
    pub parameters: Vec<usize>,
    /// The rows, motor by motor.
    pub channels: Vec<Channel>,
    /// The entries of the regressor that any column uses, each counted once.
    pub entries: Entries,
    /// In how many of the runs (without and with the load) a product of two columns counts.
    pub multiplicity: DMatrix<f64>,
}

impl Columns {
    /// The columns of `parameters` (linear unknowns of the model) for runs with the given `loads`; `noise`
    /// is the standard deviation of each joint's signal.
    pub fn new(model: &Model, parameters: Vec<usize>, loads: &[bool], noise: &[f64]) -> Self {
        let n = model.joints().len();
        let coupling = model.coupling(&model.values());
        let payload = model.payload().map(|(payload, _)| payload);
        let mut entries = Entries::none(n);
        let mut channels = Vec::new();
        for (c, channel) in model.channels().iter().enumerate() {
            let (Some(joint), true) = (channel.joint, channel.active) else {
                continue;
            };
            let weight = 1.0 / (model.joints()[joint].torque_constant * noise[c]);
            let mut own = Channel {
                joint,
                weight,
                columns: Vec::new(),
                recipes: Vec::new(),
            };
            let rows = rows_of(model, joint, weight, &coupling);
            for (k, &parameter) in parameters.iter().enumerate() {
                let parameter = of_joint(model, joint, parameter);
                let recipe = match model.parameters()[parameter].role {
                    Role::Effect {
                        joint: of, effect, ..
                    } if of == joint => of_law(model, joint, effect, parameter),
                    Role::Inertial { link, quantity } => {
                        let parts = [Moment {
                            link,
                            quantity,
                            weight: 1.0,
                        }];
                        of_bodies(model, &mut entries, &rows, &parts)
                    }
                    Role::Payload { quantity } => {
                        let parts = payload
                            .map(|p| moments_of(&p, quantity))
                            .unwrap_or_default();
                        of_bodies(model, &mut entries, &rows, &parts)
                    }
                    _ => None,
                };
                if let Some(recipe) = recipe {
                    own.columns.push(k);
                    own.recipes.push(recipe);
                }
            }
            channels.push(own);
        }
        Self {
            multiplicity: multiplicity(model, &parameters, loads),
            parameters,
            channels,
            entries,
        }
    }

    /// Number of columns.
    pub fn len(&self) -> usize {
        self.parameters.len()
    }

    /// Whether nothing is asked for.
    pub fn is_empty(&self) -> bool {
        self.parameters.is_empty()
    }
}

/// The joint's own of the parameters that are estimated as one, where it has one.
fn of_joint(model: &Model, joint: usize, parameter: usize) -> usize {
    let is_own = |p: &usize| matches!(model.parameters()[*p].role, Role::Effect { joint: of, .. } if of == joint);
    let own = model.sharing(parameter).into_iter().find(is_own);
    own.unwrap_or(parameter)
}

/// A multiple of an inertial parameter of a link.
struct Moment {
    link: usize,
    quantity: usize,
    weight: f64,
}

/// A parameter of a load in terms of the link that carries it.
fn moments_of(load: &Payload, quantity: usize) -> Vec<Moment> {
    let transfer = load.transfer();
    (0..PER_LINK)
        .map(|entry| Moment {
            link: load.link,
            quantity: entry,
            weight: transfer[(entry, quantity)],
        })
        .filter(|moment| moment.weight != 0.0)
        .collect()
}

fn of_bodies(
    model: &Model,
    entries: &mut Entries,
    rows: &[Row],
    parts: &[Moment],
) -> Option<Recipe> {
    let mut sum = Vec::new();
    for row in rows {
        for part in parts {
            if model.tree().moves(row.joint, part.link) {
                sum.push(Part {
                    entry: entries.number(row.joint, part.link, part.quantity),
                    weight: row.weight * part.weight,
                    carried: row.carried,
                });
            }
        }
    }
    (!sum.is_empty()).then_some(Recipe::Bodies(sum))
}

/// The position of a law's effect among the motor laws of its joint.
fn of_law(model: &Model, joint: usize, effect: usize, parameter: usize) -> Option<Recipe> {
    let effects = &model.joints()[joint].effects;
    let motor = |k: &usize| of_the_state(effects[*k].0);
    motor(&effect).then(|| Recipe::Law {
        effect: (0..effect).filter(motor).count(),
        parameter: parameter - effects[effect].1,
    })
}

fn multiplicity(model: &Model, parameters: &[usize], loads: &[bool]) -> DMatrix<f64> {
    let of_load = |p: usize| matches!(model.parameters()[p].role, Role::Payload { .. });
    let loaded = loads.iter().filter(|l| **l).count() as f64;
    let all = loads.len() as f64;
    DMatrix::from_fn(parameters.len(), parameters.len(), |i, j| {
        if of_load(parameters[i]) || of_load(parameters[j]) {
            loaded
        } else {
            all
        }
    })
}
