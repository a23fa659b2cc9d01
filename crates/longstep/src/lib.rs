//! Longstep turns what a person says into a robot action plan that has been checked.
pub mod prompt;
