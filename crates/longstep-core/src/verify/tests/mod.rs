mod bench;
mod enumerated;
mod plans;
mod trees;
