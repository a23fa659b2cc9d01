//! x
pub fn starter() {}
