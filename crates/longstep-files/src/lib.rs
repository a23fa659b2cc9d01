//! Files for Longstep: bounded reads, atomic writes, and the folders of domains.
//!
//! Every read has a limit in bytes, a file is replaced as a whole, and new files are for their owner alone. No network.
//!
//! Verify a plan for the domain in a folder:
//!
//! ```no_run
//! use longstep_model::{domain, environment};
//! use longstep_verify::plan::{self, resolve};
//! use longstep_verify::verify::{Purpose, bind, check};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let domain = domain::load(&longstep_files::domain_files("my_robot")?)?;
//! let scene = longstep_files::read_text("kitchen.json".as_ref())?;
//! let world = environment::parse(&domain, "kitchen.json", &scene)?;
//! let file = plan::PlanFile::from_json(&longstep_files::read_text("plan.json".as_ref())?)?;
//! let resolved = resolve(&world, &file.task_cohesion);
//! let steps = resolved.complete().ok_or("the plan names what the world lacks")?;
//! let (plan, _) = bind(&world, &steps, &resolved.objects, None).map_err(|violation| violation.message(&world, &[], None))?;
//! let report = check(&world, plan, &Purpose::default());
//! for violation in &report.violations {
//!     println!("{}", violation.message(&world, report.plan.steps(), None));
//! }
//! # Ok(())
//! # }
//! ```

mod bounded;
mod domain_folder;
mod places;
mod private;
mod text_file;
mod whole_file;

pub use bounded::{LOG_LIMIT, read_bounded, read_text_bounded, read_to_limit, text_of};
pub use domain_folder::{DomainError, domain_files, overlay_prompt};
pub use places::{NoHomeFolder, cache_directory, session_directory};
pub use private::{create_private_folder, restrict, tighten_folder};
pub use text_file::{TextFileError, plain_reason, read_text, read_texts};
pub use whole_file::{append, write_whole};
