//! User-defined laws: from the text of a `[[law]]` to an effect like those of the vocabulary.
//!
//! A law's torque is a formula in the motion and its parameters. Parameters in which it is affine are found by differentiating
//! it, and are linear unknowns like ours. Effects are referred to for as long as the program runs, so a compiled law stays in
//! memory until its end: one for each distinct text that was ever read, however often it is read.

mod error;
mod formulas;
mod state_integration;
mod text;
mod torque;

pub use crate::chain::effect::user_law::text::{
    ActsOn, LawText, MOST_PARAMETERS, ParameterText, SearchText, ShareOf, StateText,
};

#[cfg(test)]
mod tests;

pub use error::{LawError, LawFault, Part};

use crate::chain::effect::expression::Variable;
use crate::chain::effect::knowledge::Knowledge;
use crate::chain::effect::{
    Dependence, Effect, Law, Linearity, Memory, Needs, ParameterInfo, Search, Unit,
};
use formulas::Formulas;
use std::collections::HashMap;
use std::sync::Mutex;
use torque::UserLaw;

/// Laws by their texts.
static COMPILED: Mutex<Option<HashMap<String, &'static Effect>>> = Mutex::new(None);

/// The effect of a law; the same one for the same text.
///
/// # Errors
/// What is wrong with the law, in which part of it.
pub fn effect(text: &LawText) -> Result<&'static Effect, LawError> {
    let key = format!("{text:?}");
    let mut compiled = COMPILED
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    let compiled = compiled.get_or_insert_default();
    if let Some(known) = compiled.get(&key) {
        return Ok(known);
    }
    let effect: &'static Effect = Box::leak(Box::new(compile(text)?));
    compiled.insert(key, effect);
    Ok(effect)
}

fn lasting(text: &str) -> &'static str {
    String::leak(text.to_string())
}

fn lasting_list(texts: &[String]) -> &'static [&'static str] {
    Vec::leak(texts.iter().map(|text| lasting(text)).collect())
}

fn compile(text: &LawText) -> Result<Effect, LawError> {
    let formulas = Formulas::read(text)?;
    formulas.check(text)?;
    let linear = formulas.linear(text);
    let infos = text.parameters.iter().zip(&linear);
    let infos = infos.map(|(parameter, linearity)| info(parameter, *linearity));
    let needs = Needs {
        memory: memory(&formulas),
        refines: lasting_list(&text.refines),
        others: lasting_list(&formulas.others),
        ..Needs::NOTHING
    };
    let depends_on = depends_on(&formulas);
    let is_transmitted = formulas.torque.depends_on(Variable::Load);
    let law: &'static UserLaw = Box::leak(Box::new(UserLaw::compile(text, formulas)));
    Ok(Effect {
        id: lasting(&text.id),
        sentence: lasting(&text.sentence),
        equation: lasting(&equation(text)),
        source: match text.source.is_empty() {
            true => "stated in the problem file",
            false => lasting(&text.source),
        },
        parameters: Vec::leak(infos.collect()),
        depends_on: Vec::leak(depends_on),
        confounded_with: &[],
        law: match text.acts_on {
            ActsOn::Motor if is_transmitted => Law::Transmission(law),
            ActsOn::Motor => Law::Motor(law),
            ActsOn::Joint => Law::Joint(law),
            ActsOn::Signal | ActsOn::Gain => Law::Signal(law),
        },
        needs,
        knowledge: Knowledge::NONE,
    })
}

/// The law in one line.
fn equation(text: &LawText) -> String {
    let several = text.states.len() > 1;
    let states = text.states.iter().enumerate().map(|(k, state)| {
        let index = if several {
            format!("{}", k + 1)
        } else {
            String::new()
        };
        format!("dz{index}/dt = {}; ", state.rate)
    });
    let states: String = states.collect();
    match text.acts_on {
        ActsOn::Gain => format!("{states}torque constant times {}", text.torque),
        _ => format!("{states}{}", text.torque),
    }
}

fn info(text: &ParameterText, linearity: Linearity) -> ParameterInfo {
    let shares = |of: &[f64]| -> &'static [f64] { Vec::leak(of.to_vec()) };
    ParameterInfo {
        name: lasting(&text.name),
        unit: Unit::Stated(lasting(text.unit.as_deref().unwrap_or(""))),
        meaning: lasting(&text.meaning),
        lower: text.lower,
        upper: text.upper,
        typical: text.typical,
        linearity,
        search: match &text.search {
            SearchText::Typical => Search::Typical,
            SearchText::Cycles => Search::Cycles,
            SearchText::Values(values) => Search::Values(shares(values)),
            SearchText::Shares(of, values) => match of {
                ShareOf::Position => Search::Position(shares(values)),
                ShareOf::Range => Search::Range(shares(values)),
                ShareOf::Speed => Search::Speed(shares(values)),
                ShareOf::OverSpeed => Search::OverSpeed(shares(values)),
                ShareOf::Duration => Search::Duration(shares(values)),
            },
        },
    }
}

fn memory(formulas: &Formulas) -> Memory {
    let of_time = [Variable::Time, Variable::Temperature];
    if !formulas.states.is_empty() {
        Memory::WholeMotion
    } else if of_time.iter().any(|v| formulas.torque.depends_on(*v)) {
        Memory::Time
    } else {
        Memory::None
    }
}

fn depends_on(formulas: &Formulas) -> Vec<Dependence> {
    let has = |variable| formulas.torque.depends_on(variable);
    let remembers = !formulas.states.is_empty();
    let pairs = [
        (has(Variable::Position), Dependence::Position),
        (
            has(Variable::Velocity) || has(Variable::Sign) || remembers,
            Dependence::Speed,
        ),
        (has(Variable::Sign) || remembers, Dependence::Direction),
        (has(Variable::Acceleration), Dependence::Acceleration),
        (has(Variable::Load), Dependence::Load),
        (!formulas.others.is_empty(), Dependence::OtherJoints),
        (has(Variable::Time), Dependence::Time),
        (has(Variable::Temperature), Dependence::Temperature),
        (has(Variable::Current), Dependence::Current),
    ];
    let found: Vec<Dependence> = pairs
        .into_iter()
        .filter_map(|(depends, on)| depends.then_some(on))
        .collect();
    match found.is_empty() {
        true => vec![Dependence::Nothing],
        false => found,
    }
}
