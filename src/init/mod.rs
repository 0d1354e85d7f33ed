//! A problem file from what a robot's description and its recordings show: which column is what, in which unit, at which
//! rate, and what cannot be seen and is assumed.
//!
//! Names of columns say what they hold; the numbers say in which unit: stamps give a rate that a controller can have,
//! velocities have to be the derivative of positions, and positions keep to the limits of their joints.

mod channels;
pub mod error;
mod guess;
mod measure;
mod named_column;
mod write;

#[cfg(test)]
mod tests;

use crate::chain::effect;
use crate::check::{self, Extent};
use crate::init::error::InitError;
pub(crate) use crate::init::guess::Form;
use crate::init::guess::Guess;
pub use crate::init::guess::Sources;
pub use crate::init::named_column::{ColumnKey, NamedColumn};
use crate::outcome::check::Mistake;
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::robot::{mdh, mjcf, urdf};

/// A problem file that was not written by hand.
#[derive(Debug, Clone)]
pub struct Draft {
    /// TOML with comments.
    pub text: String,
    /// What the files do not show, one sentence each.
    pub assumed: Vec<String>,
    /// What the checks of the inputs say of it.
    pub findings: Vec<Mistake>,
}

/// Drafts a problem file.
///
/// # Errors
/// A file that cannot be read; recordings in which no positions, or neither currents nor torques, are known by their names.
pub fn draft(sources: &Sources, control: &Control<'_>) -> Result<Draft, InitError> {
    let tree = match Form::of(&sources.robot) {
        Form::Mdh => mdh::read(&sources.robot)?,
        Form::Mjcf => mjcf::read(&sources.robot)?.tree,
        Form::Urdf => urdf::read(&sources.robot)?,
    };
    let mut guess = Guess::new(sources, &tree, control)?;
    // A unit that the checks object to is changed, torque constants are measured, and what follows from it is looked at again.
    loop {
        let text = write::toml(sources, &guess);
        let problem = ProblemFile::parse(&sources.target, &text, &[], &effect::ids())?;
        let findings = check::mistakes(&problem, control, Extent::Recordings);
        if guess.amend(&findings)? {
            continue;
        }
        if guess.asks_for_constants() {
            guess.take_constants(&check::signal_scales(&problem));
            continue;
        }
        return Ok(Draft {
            text,
            assumed: guess.assumed(),
            findings,
        });
    }
}
