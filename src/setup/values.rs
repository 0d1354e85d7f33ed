//! Values of parameters by name where nothing becomes known by them: what a prediction is made with.

use crate::chain::model::Model;
use crate::problem_file::Named;
use crate::robot::inertia::{Inertia, PER_LINK};
use crate::setup::error::SetupError;
use crate::setup::known::resolve;
use crate::setup::names::{self, BodyQuantity, Reference};
use nalgebra::DVector;

/// Replaces values of a model's parameters; quantities of one body are taken together.
///
/// # Errors
/// A name that no parameter has.
pub fn replace(
    model: &Model,
    values: &mut DVector<f64>,
    given: &[Named<f64>],
) -> Result<(), SetupError> {
    let mut bodies: Vec<(usize, Vec<(BodyQuantity, f64)>)> = Vec::new();
    for entry in given {
        let value = entry.value.value;
        match resolve(model, &entry.name, &entry.value.place)? {
            Reference::Parameter(parameter) => values[parameter] = value,
            Reference::Body(first, quantity) => {
                match bodies.iter_mut().find(|(f, _)| *f == first) {
                    Some((_, list)) => list.push((quantity, value)),
                    None => bodies.push((first, vec![(quantity, value)])),
                }
            }
        }
    }
    for (first, quantities) in bodies {
        let current = Inertia(std::array::from_fn(|k| values[first + k]));
        let body = names::with_quantities(&current, &quantities);
        for k in 0..PER_LINK {
            values[first + k] = body.0[k];
        }
    }
    Ok(())
}
