//! The compiled half of the Python package: thin bindings of the library, without physics or statistics of their own.

mod arrays;
mod error;
mod exports;
mod problem;
mod robot;
mod run;
mod supervise;

use pyo3::prelude::*;

#[pymodule]
mod _core {
    use super::*;

    #[pymodule_export]
    use super::arrays::Arrays;
    #[pymodule_export]
    use super::exports::schema;
    #[pymodule_export]
    use super::problem::read_problem;
    #[pymodule_export]
    use super::robot::Robot;
    #[pymodule_export]
    use super::run::{Run, load, require_writable, rollout, run};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        // A defect becomes an exception, and says what it is there.
        std::panic::set_hook(Box::new(|_| {}));
        module.add("__version__", exid::outcome::provenance::VERSION)
    }
}
