//! Worlds and checks that several fuzz targets share.

pub mod checks;
pub mod scenes;
pub mod trees;
