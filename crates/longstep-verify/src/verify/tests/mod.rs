pub(crate) mod bench;
pub(crate) mod enumerated;
mod plans;
mod trees;
