//! Drives with the formulas of their laws, numbers in the places of parameters.

use crate::chain::effect::current_polynomial::{Branch, COEFFICIENTS, branch};
use crate::chain::effect::expression::{Expression, StateLaw, Variable};
use crate::chain::effect::{Catalogue, Effect, Law, NEXT, PREVIOUS, flank};
use crate::export::error::ExportError;
use crate::outcome::machine::{Machine, MachineJoint};
use nalgebra::DMatrix;

/// The drives of a robot, one per joint, and what mixes their motions.
#[derive(Debug)]
pub struct Drives {
    pub drives: Vec<Drive>,
    /// V of `q = V m + offset`.
    pub coupling: DMatrix<f64>,
    pub inverse: DMatrix<f64>,
    pub offset: Vec<f64>,
}

/// The drive of a joint.
#[derive(Debug, Default)]
pub struct Drive {
    /// Transition speed w of the regularised sign.
    pub width: f64,
    pub motor: Vec<MotorLaw>,
    /// Torques at the joint.
    pub joint: Vec<Expression>,
    /// What the gear loses.
    pub losses: Vec<Expression>,
    /// What the signal shows beyond the torque of the motor.
    pub signal: Vec<Expression>,
    /// Torque at the motor over the reading of the signal, where it is proportional.
    pub factor: f64,
    pub current: Option<Branch>,
    /// Torque at which the current begins to flow.
    pub threshold: f64,
    /// What resists the lag of the link.
    pub contact: Option<Expression>,
    /// s by which the signal is late.
    pub delay: f64,
}

/// A torque at the motor.
#[derive(Debug)]
pub struct MotorLaw {
    pub torque: Expression,
    pub states: Vec<StateLaw>,
}

impl Drives {
    /// The drives of a machine.
    ///
    /// # Errors
    /// An effect or a parameter that the machine does not hold, as in results of other versions.
    pub fn of(machine: &Machine, catalogue: &Catalogue) -> Result<Self, ExportError> {
        let n = machine.joints.len();
        let coupling = match &machine.coupling {
            Some(rows) => DMatrix::from_fn(n, n, |r, c| rows[r][c]),
            None => DMatrix::identity(n, n),
        };
        let inverse = coupling.clone().try_inverse();
        Ok(Self {
            drives: (0..n)
                .map(|j| drive(machine, j, catalogue))
                .collect::<Result<_, _>>()?,
            // The model of the fit has refused couplings without inverse.
            inverse: inverse.unwrap_or_else(|| coupling.clone()),
            coupling,
            offset: machine.joints.iter().map(|j| j.offset).collect(),
        })
    }

    /// Whether a law at a motor has a state of its own.
    pub fn remember(&self) -> bool {
        let mut laws = self.drives.iter().flat_map(|drive| &drive.motor);
        laws.any(|law| !law.states.is_empty())
    }

    /// Joints whose links lag their motors.
    pub fn lagging(&self) -> Vec<usize> {
        let drives = self.drives.iter().enumerate();
        let lagging = drives.filter(|(_, drive)| drive.contact.is_some());
        lagging.map(|(j, _)| j).collect()
    }

    /// Whether one state of motion says what the signal is.
    pub fn is_memoryless(&self) -> bool {
        let remembers = |law: &MotorLaw| !law.states.is_empty();
        let free = |drive: &Drive| {
            drive.contact.is_none() && !drive.motor.iter().any(remembers) && !drive.knows_time()
        };
        self.drives.iter().all(free)
    }
}

impl Drive {
    fn knows_time(&self) -> bool {
        let laws = self.motor.iter().map(|law| &law.torque);
        let laws = laws.chain(&self.joint).chain(&self.losses);
        let mut laws = laws.chain(&self.signal);
        laws.any(|law| law.depends_on(Variable::Time))
    }
}

fn drive(machine: &Machine, j: usize, catalogue: &Catalogue) -> Result<Drive, ExportError> {
    let joint = &machine.joints[j];
    let mut drive = Drive {
        factor: joint.torque_constant.unwrap_or(1.0),
        ..Drive::default()
    };
    let effects = joint.effects.iter().map(|found| {
        catalogue
            .find(&found.id)
            .ok_or_else(|| ExportError::UnknownEffect {
                joint: joint.name.clone(),
                effect: found.id.clone(),
            })
    });
    let effects = effects.collect::<Result<Vec<_>, _>>()?;
    let is_replaced = |id: &str| effects.iter().any(|e| e.needs.replaces == Some(id));
    let mut play = None;
    let mut elastic = None;
    for effect in &effects {
        let values = values(joint, effect)?;
        let others = others(machine, j, effect)?;
        writable(joint, effect)?;
        let with_values = |law: &Expression| {
            law.replaced(&|e| match e {
                Expression::Parameter(at) => Some(Expression::Number(values[*at])),
                Expression::Variable(Variable::OtherPosition(k)) => {
                    Some(Expression::name(format!("m{}", others[*k])))
                }
                Expression::Variable(Variable::OtherVelocity(k)) => {
                    Some(Expression::name(format!("v{}", others[*k])))
                }
                _ => None,
            })
        };
        if let Some(transition) = effect.knowledge.transition {
            drive.width = values[transition.speed];
        }
        match effect.law {
            Law::Motor(_) if is_replaced(effect.id) => {}
            Law::Motor(law) => drive.motor.push(MotorLaw {
                torque: with_values(&law.torque()),
                states: law
                    .states()
                    .iter()
                    .map(|state| StateLaw {
                        start: with_values(&state.start),
                        advance: with_values(&state.advance),
                        parts: state.parts,
                    })
                    .collect(),
            }),
            Law::Joint(law) if joint.locked.is_none() => {
                drive.joint.push(with_values(&law.torque()));
            }
            Law::Joint(_) => {}
            Law::Transmission(law) => drive.losses.push(with_values(&law.added())),
            Law::Signal(law) => drive.signal.push(with_values(&law.added())),
            Law::Gain => drive.factor *= values[0],
            Law::Current => {
                let c: [f64; COEFFICIENTS] = std::array::from_fn(|k| values[k]);
                drive.current = Some(branch(c));
                drive.threshold = c[0];
            }
            Law::Spring => elastic = Some([values[0], values[1]]),
            Law::Play => play = Some(values[0]),
            // A command that acts late is held back by what gives it.
            Law::Delay if joint.controller.is_some() => {}
            Law::Delay => drive.delay = values[0],
            // They stand in V, in the offsets, in the load and in gravity.
            Law::Coupling | Law::Encoder | Law::Body | Law::Tilt => {}
        }
    }
    if drive.current.is_some() {
        drive.factor /= joint.torque_constant.unwrap_or(1.0);
    }
    if joint.locked.is_none() && (play.is_some() || elastic.is_some()) {
        let [stiffness, damping] = elastic.unwrap_or([flank::STIFFNESS, flank::DAMPING]);
        let of = [stiffness, damping, 0.5 * play.unwrap_or(0.0)];
        drive.contact = Some(flank::torque().replaced(&|e| match e {
            Expression::Parameter(at) => Some(Expression::Number(of[*at])),
            _ => None,
        }));
    }
    Ok(drive)
}

/// Places of the joints whose motion an effect of a joint knows.
fn others(machine: &Machine, j: usize, effect: &Effect) -> Result<Vec<usize>, ExportError> {
    let of = |name: &&'static str| {
        let found = match *name {
            NEXT => (j + 1 < machine.joints.len()).then_some(j + 1),
            PREVIOUS => j.checked_sub(1),
            name => machine.joints.iter().position(|joint| joint.name == name),
        };
        found.ok_or_else(|| ExportError::Incomplete {
            joint: machine.joints[j].name.clone(),
            parameter: format!("{}: joint {name}", effect.id),
        })
    };
    effect.needs.others.iter().map(of).collect()
}

/// A program knows the motion and the signal of the motors alone, and has to find the load from the torque.
fn writable(joint: &MachineJoint, effect: &Effect) -> Result<(), ExportError> {
    let formula = match effect.law {
        Law::Motor(law) | Law::Joint(law) => law.torque(),
        Law::Transmission(law) | Law::Signal(law) => law.added(),
        _ => return Ok(()),
    };
    let refused = |why: &'static str| {
        Err(ExportError::NotWritable {
            joint: joint.name.clone(),
            effect: effect.id.to_string(),
            why,
        })
    };
    match effect.law {
        _ if formula.depends_on(Variable::Temperature) => refused("it depends on the temperature"),
        _ if formula.depends_on(Variable::Period) => {
            refused("it depends on the period of a motion")
        }
        Law::Joint(_) if !effect.needs.others.is_empty() => {
            refused("a law at a joint depends on other joints")
        }
        Law::Transmission(law) if !law.is_proportional() => {
            refused("the load does not follow from the torque in closed form")
        }
        Law::Signal(_)
            if formula.depends_on(Variable::Current) || formula.depends_on(Variable::Load) =>
        {
            refused("the torque does not follow from the signal in closed form")
        }
        _ => Ok(()),
    }
}

/// Parameters of an effect of a joint, borrowed ones behind its own.
pub fn values(joint: &MachineJoint, effect: &Effect) -> Result<Vec<f64>, ExportError> {
    let own = effect.parameters.iter().map(|info| (effect.id, info.name));
    let all = own.chain(effect.needs.borrows.iter().copied());
    all.map(|(id, name)| {
        joint
            .value(id, name)
            .ok_or_else(|| ExportError::Incomplete {
                joint: joint.name.clone(),
                parameter: format!("{id}.{name}"),
            })
    })
    .collect()
}
