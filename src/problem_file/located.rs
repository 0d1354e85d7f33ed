//! Values that know where they were written, so that a later layer can still point at line and key.

use std::ops::Deref;
use std::path::{Path, PathBuf};

use crate::fault::Place;
use crate::problem_file::error::{ProblemFileError, ValueFault};

/// A value and the place where it was written. A default has the key, but no line.
#[derive(Debug, Clone, PartialEq)]
pub struct Located<T> {
    /// The value itself.
    pub value: T,
    /// File, line, column and key, as far as there are.
    pub place: Place,
}

impl<T> Deref for Located<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

/// An entry of a table whose keys are names of joints or parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Named<T> {
    /// The name, without quotes.
    pub name: String,
    /// What it is given.
    pub value: Located<T>,
}

/// The path of a file, as written and as it is opened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FilePath {
    /// As the problem file has it.
    pub written: String,
    /// Relative paths start from the folder of the problem file.
    pub resolved: PathBuf,
}

impl FilePath {
    /// A path as written in a problem file of this folder.
    pub fn new(folder: &Path, written: &str) -> Self {
        Self {
            written: written.to_owned(),
            resolved: folder.join(written),
        }
    }
}

/// Numbers per joint: one number for all joints, or one for each in the order of the joints.
#[derive(Debug, Clone, PartialEq)]
pub enum PerJoint {
    /// The same for every joint.
    All(f64),
    /// One per joint.
    Each(Vec<f64>),
}

impl PerJoint {
    /// The value of the joint with this index, if there is one.
    pub fn get(&self, joint: usize) -> Option<f64> {
        match self {
            Self::All(value) => Some(*value),
            Self::Each(values) => values.get(joint).copied(),
        }
    }
}

impl Located<PerJoint> {
    /// One value per joint.
    ///
    /// # Errors
    /// `wrong-length`, where a list has not as many values as there are joints.
    pub fn expand(&self, joints: &[String]) -> Result<Vec<f64>, ProblemFileError> {
        match &self.value {
            PerJoint::All(value) => Ok(vec![*value; joints.len()]),
            PerJoint::Each(values) => {
                let remark = "; one number for all joints may stand alone, without brackets";
                check_length(values.len(), joints, remark, &self.place)?;
                Ok(values.clone())
            }
        }
    }
}

impl<T> Located<Vec<T>> {
    /// Checks that there is one entry per joint.
    ///
    /// # Errors
    /// `wrong-length`, where there is not.
    pub fn check_one_per_joint(&self, joints: &[String]) -> Result<(), ProblemFileError> {
        check_length(self.value.len(), joints, "", &self.place)
    }
}

pub(super) fn check_length(
    found: usize,
    joints: &[String],
    remark: &str,
    place: &Place,
) -> Result<(), ProblemFileError> {
    if found == joints.len() {
        return Ok(());
    }
    let expected = format!(
        "one per joint, {}: {}{remark}",
        joints.len(),
        joints.join(", ")
    );
    Err(ProblemFileError::new(
        place,
        ValueFault::WrongLength { expected, found },
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joints(count: usize) -> Vec<String> {
        (1..=count).map(|n| format!("a{n}")).collect()
    }

    fn located(value: PerJoint) -> Located<PerJoint> {
        let place = Place::file("p.toml").line(4).key("drive.ratio");
        Located { value, place }
    }

    #[test]
    fn one_number_holds_for_every_joint() {
        let ratio = located(PerJoint::All(32.0));
        assert_eq!(ratio.expand(&joints(3)).unwrap(), vec![32.0; 3]);
        assert_eq!(ratio.get(7), Some(32.0));
    }

    #[test]
    fn a_list_of_another_length_names_the_joints_and_the_line() {
        let ratio = located(PerJoint::Each(vec![32.0, 40.0]));
        assert_eq!(ratio.expand(&joints(2)).unwrap(), vec![32.0, 40.0]);
        let error = ratio.expand(&joints(3)).unwrap_err();
        let text = error.to_string();
        assert!(
            text.starts_with("p.toml:4: drive.ratio: the number of values is 2"),
            "{text}"
        );
        assert!(
            text.contains("one per joint, 3: a1, a2, a3; one number"),
            "{text}"
        );
    }
}
