//! problem_file
