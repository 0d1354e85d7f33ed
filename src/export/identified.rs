//! The identified robot of a result, as all formats that have its laws take it.

use crate::chain::effect::Catalogue;
use crate::outcome::machine::Machine;

/// A robot under its name, and the catalogue that has its laws.
#[derive(Debug, Clone, Copy)]
pub struct Identified<'a> {
    pub name: &'a str,
    pub machine: &'a Machine,
    pub catalogue: &'a Catalogue,
}
