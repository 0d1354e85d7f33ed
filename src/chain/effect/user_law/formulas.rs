//! The formulas of a user-defined law, parsed and checked: dimensions, linearity, what they depend on.

use crate::chain::effect::Linearity;
use crate::chain::effect::expression::{Expression, StateLaw, Variable};
use crate::chain::effect::formula::derivative::derivative;
use crate::chain::effect::formula::dimension::{Clash, Dimension, Known, Quantities, same};
use crate::chain::effect::formula::syntax::{Names, Sign, read};
use crate::chain::effect::formula::words::{is_reserved, name_of};
use crate::chain::effect::presliding_hysteresis::PARTS;
use crate::chain::effect::user_law::error::{LawError, LawFault, Part};
use crate::chain::effect::user_law::state_integration::advance;
use crate::chain::effect::user_law::{ActsOn, LawText, MOST_PARAMETERS};
use crate::robot::tree::JointKind;

/// The formulas of a law.
#[derive(Debug)]
pub struct Formulas {
    pub torque: Expression,
    pub states: Vec<StateFormulas>,
    /// Joints that they name.
    pub others: Vec<String>,
}

/// The formulas of a state.
#[derive(Debug)]
pub struct StateFormulas {
    pub rate: Expression,
    pub law: StateLaw,
}

impl Formulas {
    /// Reads the formulas of a law.
    pub fn read(text: &LawText) -> Result<Self, LawError> {
        check_names(text)?;
        let parameters: Vec<String> = text.parameters.iter().map(|p| p.name.clone()).collect();
        let mut names = Names {
            parameters: &parameters,
            states: text.states.len(),
            others: Vec::new(),
            sign: Sign::Smoothed,
        };
        let mut formula = |text: &str, part: Part, sign: Sign| {
            names.sign = sign;
            read(text, &mut names).map_err(|error| LawError {
                part,
                fault: LawFault::Formula {
                    text: text.into(),
                    error,
                },
            })
        };
        let torque = formula(&text.torque, Part::Torque, Sign::Smoothed)?;
        let mut states = Vec::new();
        for (k, state) in text.states.iter().enumerate() {
            let rate = formula(&state.rate, Part::Rate(k), Sign::Plain)?;
            let start = match &state.start {
                Some(start) => formula(start, Part::Start(k), Sign::Plain)?,
                None => Expression::Number(0.0),
            };
            let law = StateLaw {
                start,
                advance: advance(&rate, k),
                parts: PARTS,
            };
            states.push(StateFormulas { rate, law });
        }
        Ok(Self {
            torque,
            states,
            others: names.others,
        })
    }

    /// Checks variables, parameters and units.
    pub fn check(&self, text: &LawText) -> Result<(), LawError> {
        self.check_variables(text.acts_on)?;
        self.check_parameters(text)?;
        self.check_units(text)
    }

    /// Whether the torque is affine in each parameter, together with those before it that are: its derivative has none of
    /// them in it. The load depends on what else is estimated, and a state on the whole motion, so that a law of either
    /// is affine in nothing.
    pub fn linear(&self, text: &LawText) -> Vec<Linearity> {
        let of_load = [Variable::Load, Variable::Current];
        let is_of_load = of_load.iter().any(|v| self.torque.depends_on(*v));
        let is_of_more = is_of_load || !self.states.is_empty();
        let mut linear: Vec<Expression> = Vec::new();
        let parameters = text.parameters.iter().enumerate();
        parameters
            .map(|(k, parameter)| {
                let own = Expression::parameter(k);
                let slope = derivative(&self.torque, &own);
                let holds = |part: &Expression| *part == own || linear.contains(part);
                // A linear unknown starts at zero, which has to be allowed.
                let may_vanish = parameter.lower <= 0.0 && parameter.upper >= 0.0;
                let is_gain = text.acts_on == ActsOn::Gain;
                if is_of_more || is_gain || !may_vanish || slope.any(&holds) {
                    return Linearity::Nonlinear;
                }
                linear.push(own);
                Linearity::Linear
            })
            .collect()
    }

    fn check_variables(&self, acts_on: ActsOn) -> Result<(), LawError> {
        let refuse = |part: Part, variable: Variable, remedy: &'static str| LawError {
            part,
            fault: LawFault::NotKnownHere {
                variable: name_of(variable),
                remedy,
            },
        };
        let not_here: &[(Variable, &str)] = match acts_on {
            ActsOn::Motor => &[(
                Variable::Current,
                "say acts_on = \"signal\" or \"gain\": the current follows from the motor's torque",
            )],
            ActsOn::Joint => &[
                (
                    Variable::Current,
                    "say acts_on = \"signal\" or \"gain\": the current follows from the motor's torque",
                ),
                (
                    Variable::Load,
                    "say acts_on = \"motor\": the transmitted torque is that of the gear",
                ),
                (
                    Variable::Acceleration,
                    "say acts_on = \"motor\": an inertia at a joint belongs to the links",
                ),
                (
                    Variable::State(0),
                    "say acts_on = \"motor\": a law at a joint has no state",
                ),
            ],
            ActsOn::Signal | ActsOn::Gain => &[
                (
                    Variable::Load,
                    "use i, the current that the torque constant gives for the motor's torque, or say acts_on = \"motor\"",
                ),
                (
                    Variable::State(0),
                    "say acts_on = \"motor\": a law of the signal has no state",
                ),
            ],
        };
        for (variable, remedy) in not_here {
            if self.torque.depends_on(*variable) {
                return Err(refuse(Part::Torque, *variable, remedy));
            }
        }
        let remembers = !self.states.is_empty();
        let no_load = "leave it out: a law with a state is one of the motor's motion";
        for variable in [Variable::Load, Variable::Time, Variable::Temperature] {
            if remembers && self.torque.depends_on(variable) {
                return Err(refuse(Part::Torque, variable, no_load));
            }
        }
        for (k, state) in self.states.iter().enumerate() {
            for (part, formula) in [
                (Part::Rate(k), &state.rate),
                (Part::Start(k), &state.law.start),
            ] {
                if let Some(other) = foreign(formula, part) {
                    let remedy = "the rate of a state is a formula in v, its own state and parameters, its start one in v and parameters";
                    return Err(refuse(part, other, remedy));
                }
            }
        }
        Ok(())
    }

    fn check_parameters(&self, text: &LawText) -> Result<(), LawError> {
        if text.parameters.is_empty() {
            return Err(LawError {
                part: Part::Torque,
                fault: LawFault::NoParameters,
            });
        }
        let found = text.parameters.len();
        if found > MOST_PARAMETERS {
            return Err(LawError {
                part: Part::Parameter(MOST_PARAMETERS),
                fault: LawFault::TooManyParameters { found },
            });
        }
        for k in 0..self.states.len() {
            if !self.torque.depends_on(Variable::State(k)) {
                return Err(LawError {
                    part: Part::Rate(k),
                    fault: LawFault::UnusedState,
                });
            }
        }
        for (k, parameter) in text.parameters.iter().enumerate() {
            let fault = |fault| LawError {
                part: Part::Parameter(k),
                fault,
            };
            let is = |part: &Expression| *part == Expression::parameter(k);
            let mut states = self.states.iter();
            if !self.torque.any(&is) && !states.any(|s| s.rate.any(&is) || s.law.start.any(&is)) {
                return Err(fault(LawFault::Unused {
                    name: parameter.name.clone(),
                }));
            }
            let (lower, typical, upper) = (parameter.lower, parameter.typical, parameter.upper);
            if !(lower <= typical && typical <= upper && lower < upper) {
                return Err(fault(LawFault::Bounds {
                    name: parameter.name.clone(),
                    lower,
                    typical,
                    upper,
                }));
            }
        }
        Ok(())
    }

    /// Units have to go together for a joint that turns, or else for one that slides.
    fn check_units(&self, text: &LawText) -> Result<(), LawError> {
        let mut known = Vec::new();
        for (k, parameter) in text.parameters.iter().enumerate() {
            known.push(match &parameter.unit {
                None => Known::Unknown,
                Some(unit) => {
                    let fault = || LawError {
                        part: Part::Parameter(k),
                        fault: LawFault::UnknownUnit {
                            found: unit.clone(),
                        },
                    };
                    Known::Dimension(Dimension::of_unit(unit).ok_or_else(fault)?)
                }
            });
        }
        let turning = self.check_units_of(JointKind::Revolute, text, &known);
        match turning.is_ok()
            || self
                .check_units_of(JointKind::Prismatic, text, &known)
                .is_ok()
        {
            true => Ok(()),
            false => turning,
        }
    }

    fn check_units_of(
        &self,
        kind: JointKind,
        text: &LawText,
        parameters: &[Known],
    ) -> Result<(), LawError> {
        let quantities = Quantities { kind, parameters };
        let fault = |part: Part, text: &str, clash: Clash| LawError {
            part,
            fault: LawFault::Dimensions {
                text: text.into(),
                what: format!("{} {} and {}", clash.what, clash.found, clash.other),
            },
        };
        let expected = match text.acts_on {
            ActsOn::Gain => Dimension::of_unit("1"),
            _ => Some(quantities.torque()),
        };
        let expected = expected.map_or(Known::Unknown, Known::Dimension);
        let what = match text.acts_on {
            ActsOn::Gain => "a factor of the torque constant, given",
            _ => "to be a torque, given",
        };
        let torque = quantities.of(&self.torque);
        torque
            .and_then(|found| same(what, found, expected))
            .map_err(|clash| fault(Part::Torque, &text.torque, clash))?;
        for (k, state) in self.states.iter().enumerate() {
            let rate = quantities.of(&state.rate);
            rate.map_err(|clash| fault(Part::Rate(k), &text.states[k].rate, clash))?;
        }
        Ok(())
    }
}

/// A variable that a rate or a start may not have in it.
fn foreign(formula: &Expression, part: Part) -> Option<Variable> {
    let found = std::cell::Cell::new(None);
    formula.any(&|part_of| {
        if let Expression::Variable(variable) = part_of {
            let own = matches!(part, Part::Rate(state) if *variable == Variable::State(state));
            if *variable != Variable::Velocity && !own {
                found.set(Some(*variable));
            }
        }
        false
    });
    found.get()
}

fn check_names(text: &LawText) -> Result<(), LawError> {
    let is_name = |name: &str| {
        let mut characters = name.chars();
        let first = characters.next();
        first.is_some_and(char::is_alphabetic)
            && characters.all(|c| c.is_alphanumeric() || c == '_')
    };
    let bad = |part: Part, found: &str| LawError {
        part,
        fault: LawFault::BadName {
            found: found.into(),
        },
    };
    if !is_name(&text.id) {
        return Err(bad(Part::Id, &text.id));
    }
    for (k, parameter) in text.parameters.iter().enumerate() {
        let name = &parameter.name;
        if !is_name(name) {
            return Err(bad(Part::Parameter(k), name));
        }
        if is_reserved(name) {
            return Err(LawError {
                part: Part::Parameter(k),
                fault: LawFault::Reserved {
                    found: name.clone(),
                },
            });
        }
    }
    Ok(())
}
