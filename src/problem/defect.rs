//! A panic as an error: a defect of the program, not of its input.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use thiserror::Error;

/// What a panic said.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("a defect of exid: {0}; please report it with the command that you ran")]
pub struct Defect(pub String);

/// Does the work; what it was at work on is given up where it panics.
///
/// # Errors
/// The work panics.
pub fn guarded<T>(work: impl FnOnce() -> T) -> Result<T, Defect> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| Defect(words_of(panic.as_ref())))
}

fn words_of(panic: &(dyn Any + Send)) -> String {
    let text = panic
        .downcast_ref::<&str>()
        .map(|text| text.to_string())
        .or_else(|| panic.downcast_ref::<String>().cloned());
    text.unwrap_or_else(|| "no message".to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error_with_its_words() {
        let found = guarded(|| f64::clamp(1.0, 0.0, f64::NAN));
        let words = found.unwrap_err().to_string();
        assert!(words.contains("min > max"), "{words}");
        assert_eq!(guarded(|| 1), Ok(1));
    }
}
