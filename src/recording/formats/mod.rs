//! File formats: a file of numbers becomes a table of named columns, read within limits; one file per format, one table of
//! them all, in `format`.

pub mod arrays;
mod arrow_schema;
mod bag;
mod csv;
mod date;
mod encoding;
pub mod format;
mod hdf5;
mod mat;
mod mat4;
pub mod memory;
mod npz;
mod number_type;
mod parquet;
pub mod reading;
pub mod table;
