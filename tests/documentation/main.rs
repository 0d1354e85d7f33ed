//! The documentation against the program: what pages show of it, what they list, where they link, and that shipped problems run.
//!
//! `docs/remake` writes what is generated or printed into the pages; without it the tests compare.

mod generated;
mod keys;
mod links;
mod pages;
mod printed;
mod shipped;
mod sources;
