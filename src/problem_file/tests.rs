//! Tests of the problem file as a whole.
