//! A part of the page with a heading of its own, and what it is made from.

use crate::outcome::diagnose::Diagnosis;
use crate::outcome::fit::Fit;
use crate::outcome::{Outcome, Part};
use crate::report::explore::Exploration;
use crate::report::series::Series;

/// A part of the page with a heading of its own.
pub(in crate::report) struct Section {
    /// Anchor in the page.
    pub id: &'static str,
    pub title: &'static str,
    /// HTML.
    pub body: String,
}

impl Section {
    pub fn new(id: &'static str, title: &'static str, body: String) -> Self {
        Self { id, title, body }
    }
}

/// What a section is made from.
pub(in crate::report) struct Source<'a> {
    pub outcome: &'a Outcome,
    pub series: &'a Series,
    pub exploration: &'a Exploration,
}

impl<'a> Source<'a> {
    /// The part of `fit`, if that is the verb.
    pub fn fit(&self) -> Option<&'a Fit> {
        match &self.outcome.part {
            Part::Fit(fit) => Some(fit),
            _ => None,
        }
    }

    /// The part of `diagnose`, if that is the verb.
    pub fn diagnosis(&self) -> Option<&'a Diagnosis> {
        match &self.outcome.part {
            Part::Diagnose(diagnosis) => Some(diagnosis),
            _ => None,
        }
    }
}
