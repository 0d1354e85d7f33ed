//! The last model that a search selected, kept apart from the search: a defect that ends it leaves that model.

use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::selection::stepwise::Selection;
use std::sync::{Mutex, PoisonError};

/// The latest selected model, without what was tried on the way.
#[derive(Debug, Default)]
pub struct LastSelection {
    selection: Mutex<Option<Selection>>,
}

impl LastSelection {
    /// Keeps a model that has come out of `examined` hypotheses in the place of the one before.
    pub fn set(&self, fit: &ModelFit, examined: usize) {
        let selection = Selection {
            fit: fit.clone(),
            steps: Vec::new(),
            examined,
        };
        *self
            .selection
            .lock()
            .unwrap_or_else(PoisonError::into_inner) = Some(selection);
    }

    /// The last model that was kept; none where the search had come to nothing.
    pub fn get(&self) -> Option<Selection> {
        let selection = self.selection.lock();
        selection.unwrap_or_else(PoisonError::into_inner).clone()
    }
}
