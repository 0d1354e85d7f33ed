//! The words of formulas: variables of the motion, functions, and the one that a misspelt word may have meant.

use crate::chain::effect::expression::Variable;

/// Variables of the motion by their names.
pub(super) const VARIABLES: &[(&str, Variable)] = &[
    ("q", Variable::Position),
    ("v", Variable::Velocity),
    ("acc", Variable::Acceleration),
    ("tau", Variable::Load),
    ("i", Variable::Current),
    ("t", Variable::Time),
    ("T", Variable::Temperature),
    ("period", Variable::Period),
];

pub(super) const PI: &str = "pi";
pub(super) const STATE: &str = "z";

/// Names that parameters cannot have.
pub fn is_reserved(name: &str) -> bool {
    let is_state = name.strip_prefix(STATE);
    name == PI
        || VARIABLES.iter().any(|(word, _)| *word == name)
        || is_state.is_some_and(|rest| rest.chars().all(|c| c.is_ascii_digit()))
}

/// The name of a variable in formulas.
pub fn name_of(variable: Variable) -> &'static str {
    let found = VARIABLES.iter().find(|(_, other)| *other == variable);
    match (found, variable) {
        (Some((name, _)), _) => name,
        (None, Variable::Sign) => "sign(v)",
        (None, Variable::OtherPosition(_)) => "q[...]",
        (None, Variable::OtherVelocity(_)) => "v[...]",
        (None, _) => STATE,
    }
}

/// Functions by their names, with the number of their arguments.
pub(super) const FUNCTIONS: &[(&str, usize)] = &[
    ("exp", 1),
    ("log", 1),
    ("tanh", 1),
    ("sin", 1),
    ("cos", 1),
    ("sqrt", 1),
    ("abs", 1),
    ("sign", 1),
    ("step", 1),
    ("min", 2),
    ("max", 2),
    ("if", 3),
];

pub(super) fn names_of_functions() -> String {
    let names: Vec<&str> = FUNCTIONS.iter().map(|(name, _)| *name).collect();
    names.join(", ")
}
