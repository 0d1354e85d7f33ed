//! File formats: a file of numbers becomes a table of named columns, read within limits; one file per format, one table of
//! them all, in `format`.

pub mod arrays;
#[cfg(feature = "parquet")]
mod arrow_schema;
#[cfg(feature = "bags")]
mod bag;
#[cfg(feature = "compression")]
mod compressed;
mod csv;
mod date;
mod encoding;
pub mod format;
#[cfg(feature = "hdf5")]
mod hdf5;
#[cfg(feature = "hdf5")]
mod mat;
#[cfg(feature = "hdf5")]
mod mat4;
pub mod memory;
#[cfg(feature = "npz")]
mod npz;
// What some formats alone need is of no use without them.
#[cfg_attr(
    not(all(feature = "bags", feature = "hdf5", feature = "npz")),
    allow(dead_code)
)]
mod number_type;
#[cfg(feature = "parquet")]
mod parquet;
#[cfg_attr(
    not(all(feature = "bags", feature = "hdf5", feature = "npz")),
    allow(dead_code)
)]
pub mod reading;
pub mod table;
