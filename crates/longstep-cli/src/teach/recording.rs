//! A recording of a step, and its file.

use std::path::PathBuf;

use anyhow::Result;
use longstep_files::{plain_reason, write_whole};
use longstep_teach::Demonstration;

use crate::failure::Failure;
use crate::output::remark;

/// A recording of one step. One that was made just now has a file to be written.
pub(super) struct Recording {
    pub(super) demonstration: Demonstration,
    pub(super) unsaved: Option<(PathBuf, Vec<u8>)>,
}

impl Recording {
    pub(super) fn save(&self) -> Result<()> {
        let Some((path, bytes)) = &self.unsaved else {
            return Ok(());
        };
        write_whole(path, bytes).map_err(|error| {
            Failure::unreadable(format!("cannot write {}: {}", path.display(), plain_reason(&error)))
                .hint("check that the folder of `--output` is writable")
        })?;
        remark!("Saved {}", path.display());
        Ok(())
    }
}
