//! Drives with the formulas of their laws, values in the places of parameters.

use crate::chain::effect::current_polynomial::{Branch, COEFFICIENTS, branch, branch_up_to};
use crate::chain::effect::expression::{Expression, StateLaw, Variable};
use crate::chain::effect::{
    COUPLING, CROSSTALK, Catalogue, Effect, Law, Linearity, NEXT, PREVIOUS, flank,
};
use crate::export::error::ExportError;
use crate::export::values::{Setting, Values, product};
use crate::outcome::machine::{Machine, MachineController, MachineJoint};
use nalgebra::DMatrix;

/// The drives of a robot, one per joint, and what mixes their motions.
#[derive(Debug)]
pub struct Drives {
    pub drives: Vec<Drive>,
    /// V of `q = V m + offset`.
    pub coupling: Mixing,
    /// 1 + X of recorded signals by those of the motors.
    pub crosstalk: Mixing,
    pub offset: Vec<Expression>,
    /// Of position controllers, of the joints that have them.
    pub gains: Vec<Option<Gains>>,
    /// What stands for the numbers.
    pub values: Values,
}

/// Gains of a position controller.
#[derive(Debug)]
pub struct Gains {
    pub kp: Expression,
    pub kd: Expression,
}

/// A matrix that mixes what joints have, and its inverse.
#[derive(Debug)]
pub struct Mixing {
    pub matrix: DMatrix<Expression>,
    pub inverse: DMatrix<Expression>,
}

/// The drive of a joint.
#[derive(Debug)]
pub struct Drive {
    /// Transition speed w of the regularised sign.
    pub width: Expression,
    pub motor: Vec<MotorLaw>,
    /// Torques at the joint.
    pub joint: Vec<Expression>,
    /// What the gear loses.
    pub losses: Vec<Expression>,
    /// What the signal shows beyond the torque of the motor.
    pub signal: Vec<Expression>,
    /// Torque at the motor over the reading of the signal, where it is proportional.
    pub factor: Expression,
    pub current: Option<Current>,
    /// What resists the lag of the link.
    pub contact: Option<Expression>,
    /// s by which the signal is late.
    pub delay: f64,
}

/// The polynomial from current to torque.
#[derive(Debug)]
pub struct Current {
    pub coefficients: [Expression; COEFFICIENTS],
    /// Current at which the polynomial is left.
    pub end: Expression,
    pub branch: Branch,
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
    pub fn of(
        machine: &Machine,
        catalogue: &Catalogue,
        values: Values,
    ) -> Result<Self, ExportError> {
        let joints = &machine.joints;
        let n = joints.len();
        let drives = (0..n).map(|j| drive(machine, j, catalogue, &values));
        let drives = drives.collect::<Result<_, _>>()?;
        let motors = match &machine.coupling {
            Some(rows) => DMatrix::from_fn(n, n, |r, c| rows[r][c]),
            None => DMatrix::identity(n, n),
        };
        let channels = channels(machine)?;
        let offset = joints.iter().map(|joint| match joint.offset {
            0.0 => Expression::Number(0.0),
            offset => values.stand_for(Setting::of(&joint.name, "offset", offset)),
        });
        let offset = offset.collect();
        let gains = joints.iter().map(|joint| {
            let MachineController { kp, kd } = joint.controller?;
            let of = |name, value| values.stand_for(Setting::of(&joint.name, name, value));
            Some(Gains {
                kp: of("controller.kp", kp),
                kd: of("controller.kd", kd),
            })
        });
        let gains = gains.collect();
        Ok(Self {
            drives,
            coupling: Mixing::of(joints, &motors, COUPLING.id, &values),
            crosstalk: Mixing::of(joints, &channels, CROSSTALK.id, &values),
            offset,
            gains,
            values,
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

fn identity(n: usize) -> DMatrix<Expression> {
    DMatrix::from_fn(n, n, |r, c| Expression::Number(f64::from(u8::from(r == c))))
}

impl Mixing {
    /// A matrix with an inverse, whose entries belong to an effect: `ROW.effect.COLUMN`, by names of joints.
    fn of(joints: &[MachineJoint], numbers: &DMatrix<f64>, id: &str, values: &Values) -> Self {
        let n = joints.len();
        if *numbers == DMatrix::identity(n, n) {
            return Self {
                matrix: identity(n),
                inverse: identity(n),
            };
        }
        let matrix =
            numbers.map_with_location(|r, c, entry| match entry == f64::from(u8::from(r == c)) {
                true => Expression::Number(entry),
                false => {
                    let name = format!("{id}.{}", joints[c].name);
                    values.stand_for(Setting::of(&joints[r].name, &name, entry))
                }
            });
        let inverse = match values {
            Values::Array(array) => {
                DMatrix::from_row_iterator(n, n, (0..n * n).map(|_| array.derived()))
            }
            Values::Numbers => match numbers.clone().try_inverse() {
                Some(inverse) => inverse.map(Expression::Number),
                None => matrix.clone(),
            },
        };
        Self { matrix, inverse }
    }

    /// Whether nothing is mixed.
    pub fn is_identity(&self) -> bool {
        self.matrix == identity(self.matrix.nrows())
    }
}

/// What stands for the parameters of an effect of a joint.
struct Parameters<'a> {
    joint: &'a MachineJoint,
    effect: &'a Effect,
    catalogue: &'a Catalogue,
    numbers: Vec<f64>,
    values: &'a Values,
}

impl Parameters<'_> {
    /// The effect's own, and behind them those that it borrows.
    fn at(&self, position: usize) -> Expression {
        let own = self.effect.parameters;
        let (id, info) = match own.get(position) {
            Some(info) => (self.effect.id, Some(info)),
            None => {
                let (id, name) = self.effect.needs.borrows[position - own.len()];
                let lender = self.catalogue.find(id);
                (
                    id,
                    lender.and_then(|of| of.parameters.iter().find(|info| info.name == name)),
                )
            }
        };
        let value = self.numbers[position];
        let Some(info) = info else {
            return Expression::Number(value);
        };
        let name = format!("{id}.{}", info.name);
        let mut setting = Setting::of(&self.joint.name, &name, value);
        // Estimates may take linear parameters out of their limits, and the formulas hold there too.
        if info.linearity == Linearity::Nonlinear {
            (setting.lower, setting.upper) = (info.lower, info.upper);
        }
        self.values.stand_for(setting)
    }
}

fn drive(
    machine: &Machine,
    j: usize,
    catalogue: &Catalogue,
    values: &Values,
) -> Result<Drive, ExportError> {
    let joint = &machine.joints[j];
    let mut drive = Drive {
        width: Expression::Number(0.0),
        motor: Vec::new(),
        joint: Vec::new(),
        losses: Vec::new(),
        signal: Vec::new(),
        factor: Expression::Number(1.0),
        current: None,
        contact: None,
        delay: 0.0,
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
        // It lies between the drives.
        if matches!(effect.law, Law::Crosstalk) {
            continue;
        }
        let parameters = Parameters {
            joint,
            effect,
            catalogue,
            numbers: numbers(joint, effect)?,
            values,
        };
        let others = others(machine, j, effect)?;
        writable(joint, effect)?;
        let with_values = |law: &Expression| {
            law.replaced(&|e| match e {
                Expression::Parameter(at) => Some(parameters.at(*at)),
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
            drive.width = parameters.at(transition.speed);
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
            Law::Gain => drive.factor = parameters.at(0),
            Law::Current => drive.current = Some(current(&parameters)),
            Law::Spring => elastic = Some([0, 1].map(|at| parameters.at(at))),
            Law::Play => play = Some(parameters.at(0)),
            // A command that acts late is held back by what gives it.
            Law::Delay if joint.controller.is_some() => {}
            Law::Delay => drive.delay = parameters.numbers[0],
            // They stand in V, between the channels, in the offsets, in the load and in gravity.
            Law::Coupling | Law::Crosstalk | Law::Encoder | Law::Body | Law::Tilt => {}
        }
    }
    if let (Some(constant), None) = (joint.torque_constant, &drive.current) {
        let constant = values.stand_for(Setting::of(&joint.name, "torque_constant", constant));
        drive.factor = product(constant, drive.factor);
    }
    if joint.locked.is_none() && (play.is_some() || elastic.is_some()) {
        let of_teeth = || [flank::STIFFNESS, flank::DAMPING].map(Expression::Number);
        let [stiffness, damping] = elastic.unwrap_or_else(of_teeth);
        let gap = play.unwrap_or(Expression::Number(0.0));
        let of = [stiffness, damping, product(gap, Expression::Number(0.5))];
        drive.contact = Some(flank::torque().replaced(&|e| match e {
            Expression::Parameter(at) => Some(of[*at].clone()),
            _ => None,
        }));
    }
    Ok(drive)
}

fn current(parameters: &Parameters<'_>) -> Current {
    let coefficients: [Expression; COEFFICIENTS] = std::array::from_fn(|k| parameters.at(k));
    match parameters.values {
        Values::Numbers => {
            let (branch, end) = branch(std::array::from_fn(|k| parameters.numbers[k]));
            let end = Expression::Number(end);
            Current {
                coefficients,
                end,
                branch,
            }
        }
        Values::Array(array) => {
            let end = array.derived();
            let branch = branch_up_to(&coefficients, end.clone());
            Current {
                coefficients,
                end,
                branch,
            }
        }
    }
}

/// Channels whose signals are the same mixture.
fn alike(machine: &Machine) -> ExportError {
    let hears = |joint: &&MachineJoint| joint.effects.iter().any(|e| e.id == CROSSTALK.id);
    let joint = machine.joints.iter().find(hears);
    ExportError::NotWritable {
        joint: joint.map_or_else(String::new, |joint| joint.name.clone()),
        effect: CROSSTALK.id.to_string(),
        why: "signals of the motors do not follow from recorded ones that are one mixture",
    }
}

/// 1 + X of the shares that the channels have of one another's signals.
///
/// # Errors
/// Of channels whose signals are the same mixture.
fn channels(machine: &Machine) -> Result<DMatrix<f64>, ExportError> {
    let joints = &machine.joints;
    let mut mixing = DMatrix::identity(joints.len(), joints.len());
    for (channel, joint) in joints.iter().enumerate() {
        let heard = joint
            .effects
            .iter()
            .filter(|effect| effect.id == CROSSTALK.id);
        for share in heard.flat_map(|effect| &effect.parameters) {
            let source = joints.iter().position(|other| other.name == share.name);
            let source = source.ok_or_else(|| ExportError::Incomplete {
                joint: joint.name.clone(),
                parameter: format!("{}: joint {}", CROSSTALK.id, share.name),
            })?;
            mixing[(channel, source)] = share.value;
        }
    }
    match mixing.clone().try_inverse().is_some() {
        true => Ok(mixing),
        false => Err(alike(machine)),
    }
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
fn numbers(joint: &MachineJoint, effect: &Effect) -> Result<Vec<f64>, ExportError> {
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
