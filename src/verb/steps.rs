//! The steps of a run in words, and within a step how many of its parts are done and how long the others take.

use crate::problem::count::Done;
use crate::verb::remaining;
use std::sync::{Mutex, PoisonError};

/// Tells of steps and of their parts.
pub struct Steps<'a> {
    say: &'a (dyn Fn(&str) + Sync),
    step: Mutex<String>,
}

impl<'a> Steps<'a> {
    /// Told to `say`.
    pub fn new(say: &'a (dyn Fn(&str) + Sync)) -> Self {
        Self {
            say,
            step: Mutex::default(),
        }
    }

    /// A step begins.
    pub fn begin(&self, words: &str) {
        let mut step = self.step.lock().unwrap_or_else(PoisonError::into_inner);
        words.clone_into(&mut step);
        (self.say)(words);
    }

    /// A part of the step is done.
    pub fn done(&self, done: &Done) {
        let step = self.step.lock().unwrap_or_else(PoisonError::into_inner);
        let left = remaining::left(done.elapsed, done.parts, done.all);
        (self.say)(&format!("{step}: {} of {}{left}", done.parts, done.all));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn a_step_with_parts_says_how_long_the_others_take() {
        let heard = Mutex::new(Vec::new());
        let say = |words: &str| heard.lock().unwrap().push(words.to_owned());
        let steps = Steps::new(&say);
        steps.begin("fitting");
        steps.done(&Done {
            parts: 2,
            all: 8,
            elapsed: Duration::from_secs(10),
        });
        assert_eq!(
            *heard.lock().unwrap(),
            ["fitting", "fitting: 2 of 8, about 30 s left"]
        );
    }
}
