//! Errors of the library as exceptions with place, value, remedy, code and exit code.

use exid::export::error::ExportError;
use exid::fault::Fault;
use exid::outcome::error::OutcomeError;
use exid::problem::defect::Defect;
use exid::problem_file::ProblemFileError;
use exid::robot::error::RobotError;
use exid::setup::error::SetupError;
use exid::verb::ending::{DEFECT, INTERRUPTED, WRONG_DATA, WRONG_USE};
use exid::verb::error::{Account, VerbError, of_fault};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// An error with what Python is told of it.
pub struct Failure {
    pub text: String,
    /// In a box, so that results without an error stay small.
    pub account: Box<Account>,
    pub exit_code: u8,
}

impl Failure {
    fn of_fault(fault: &impl Fault, exit_code: u8) -> Self {
        Self {
            text: fault.to_string(),
            account: Box::new(of_fault(fault)),
            exit_code,
        }
    }

    /// The exception; one that cannot be made says why.
    pub fn raise(self, py: Python<'_>) -> PyErr {
        if self.exit_code == INTERRUPTED {
            return PyKeyboardInterrupt::new_err(self.text);
        }
        self.exception(py).unwrap_or_else(|error| error)
    }

    fn exception(self, py: Python<'_>) -> PyResult<PyErr> {
        let details = PyDict::new(py);
        let account = *self.account;
        if let Some(place) = account.place {
            let at = PyDict::new(py);
            at.set_item("file", place.file.display().to_string())?;
            at.set_item("line", place.line)?;
            at.set_item("column", place.column)?;
            at.set_item("key", place.key)?;
            details.set_item("place", at)?;
        }
        details.set_item("value", account.value)?;
        details.set_item("message", account.message)?;
        details.set_item("remedy", account.remedy)?;
        details.set_item("code", account.code)?;
        details.set_item("exit_code", self.exit_code)?;
        let make = py.import("exid.errors")?.getattr("of_failure")?;
        Ok(PyErr::from_value(make.call((self.text,), Some(&details))?))
    }
}

impl From<VerbError> for Failure {
    fn from(error: VerbError) -> Self {
        Self {
            text: error.to_string(),
            account: Box::new(error.account()),
            exit_code: error.exit_code(),
        }
    }
}

impl From<ProblemFileError> for Failure {
    fn from(error: ProblemFileError) -> Self {
        VerbError::from(error).into()
    }
}

impl From<OutcomeError> for Failure {
    fn from(error: OutcomeError) -> Self {
        VerbError::from(error).into()
    }
}

impl From<ExportError> for Failure {
    fn from(error: ExportError) -> Self {
        VerbError::from(error).into()
    }
}

impl From<RobotError> for Failure {
    fn from(error: RobotError) -> Self {
        Self::of_fault(&error, WRONG_DATA)
    }
}

impl From<SetupError> for Failure {
    fn from(error: SetupError) -> Self {
        let exit_code = match error.concerns_data() {
            true => WRONG_DATA,
            false => WRONG_USE,
        };
        Self::of_fault(&error, exit_code)
    }
}

impl From<Defect> for Failure {
    fn from(defect: Defect) -> Self {
        Self {
            text: defect.to_string(),
            account: Box::new(Account {
                code: "defect".into(),
                message: defect.to_string(),
                ..Account::default()
            }),
            exit_code: DEFECT,
        }
    }
}
