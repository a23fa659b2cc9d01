//! Files for Longstep: bounded reads, atomic writes, and the folders of domains.
//!
//! Every read has a limit in bytes, a file is replaced as a whole, and new files are for their owner alone. No network.
//!
//! Verify a plan for the domain in a folder:
//!
//! ```no_run
//! use longstep_model::{domain, environment};
//! use longstep_verify::plan;
//! use longstep_verify::verify::check_file;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let domain = domain::load(&longstep_files::domain_files("my_robot")?)?;
//! let scene = longstep_files::read_text("kitchen.json".as_ref())?;
//! let world = environment::parse(&domain, "kitchen.json", &scene)?;
//! let draft = plan::read(&longstep_files::read_text("plan.json".as_ref())?)?;
//! match check_file(&world, &draft.file) {
//!     Ok(report) => println!("{} violations", report.violations.len()),
//!     Err(violations) => println!("{} names or arguments do not fit", violations.len()),
//! }
//! # Ok(())
//! # }
//! ```

mod bounded;
mod domain_folder;
mod file_set;
mod places;
mod private;
mod text_file;
mod whole_file;

pub use bounded::{LOG_LIMIT, read_bounded, read_text_bounded, read_to_limit, text_of};
pub use domain_folder::{DomainError, domain_files, overlay_prompt};
pub use file_set::{FileSetError, write_file_set};
pub use places::{NoHomeFolder, cache_directory, session_directory};
pub use private::{create_private_folder, restrict, tighten_folder};
pub use text_file::{TextFileError, plain_reason, read_text, read_texts};
pub use whole_file::{append, write_whole};
