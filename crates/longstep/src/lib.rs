//! Longstep turns what a person says into a robot action plan that has been checked.
pub mod answer;
pub mod call;
pub mod diagnostic;
pub mod domain;
pub mod goal;
pub mod json;
pub mod plan;
pub mod prompt;
pub mod search;
pub mod verify;
pub mod world;
