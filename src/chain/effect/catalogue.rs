//! The effects that a model may have: the vocabulary, effects of programs that use the library, laws of a problem file.

use crate::chain::effect::{EFFECTS, Effect};
use std::sync::RwLock;

/// Effects of programs that use the library.
static REGISTERED: RwLock<Vec<&'static Effect>> = RwLock::new(Vec::new());

/// An identifier that is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct IdTaken(pub &'static str);

impl std::fmt::Display for IdTaken {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self(id) = self;
        write!(
            f,
            "there is an effect \"{id}\" already; give this one another identifier"
        )
    }
}

impl std::error::Error for IdTaken {}

/// Makes an effect of a program known to everything that looks effects up by their identifiers, from here on.
///
/// # Errors
/// Another effect has the identifier.
pub fn register(effect: &'static Effect) -> Result<(), IdTaken> {
    let mut registered = REGISTERED
        .write()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    let mut all = EFFECTS.iter().chain(registered.iter());
    match all.find(|other| other.id == effect.id) {
        Some(other) if std::ptr::eq(*other, effect) => Ok(()),
        Some(_) => Err(IdTaken(effect.id)),
        None => {
            registered.push(effect);
            Ok(())
        }
    }
}

/// Effects in the order in which they are listed, no identifier twice.
#[derive(Debug, Clone)]
pub struct Catalogue {
    effects: Vec<&'static Effect>,
}

/// The same effects.
impl PartialEq for Catalogue {
    fn eq(&self, other: &Self) -> bool {
        let same = |(a, b): (&&'static Effect, &&'static Effect)| std::ptr::eq(*a, *b);
        self.effects.len() == other.effects.len()
            && self.effects.iter().zip(&other.effects).all(same)
    }
}

impl Eq for Catalogue {}

impl Default for Catalogue {
    fn default() -> Self {
        Self::known()
    }
}

impl Catalogue {
    /// The vocabulary, then registered effects.
    pub fn known() -> Self {
        let registered = REGISTERED
            .read()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        Self {
            effects: EFFECTS.iter().chain(registered.iter()).copied().collect(),
        }
    }

    /// The same with one effect more.
    ///
    /// # Errors
    /// Another effect has the identifier.
    pub fn with(mut self, effect: &'static Effect) -> Result<Self, IdTaken> {
        match self.find(effect.id) {
            Some(_) => Err(IdTaken(effect.id)),
            None => {
                self.effects.push(effect);
                Ok(self)
            }
        }
    }

    /// In the order in which they are listed and searched.
    pub fn effects(&self) -> &[&'static Effect] {
        &self.effects
    }

    /// An effect by its identifier.
    pub fn find(&self, id: &str) -> Option<&'static Effect> {
        self.effects.iter().find(|effect| effect.id == id).copied()
    }

    /// The identifiers.
    pub fn ids(&self) -> Vec<&'static str> {
        self.effects.iter().map(|effect| effect.id).collect()
    }
}

/// An effect of the vocabulary, or one that was [registered](register), by its identifier.
pub fn find(id: &str) -> Option<&'static Effect> {
    Catalogue::known().find(id)
}

/// The identifiers of the vocabulary and of registered effects.
pub fn ids() -> Vec<&'static str> {
    Catalogue::known().ids()
}
