//! `longstep model`: the catalogue and the cache.

use anyhow::Result;
use longstep_core::diagnostic::nearest;
use longstep_files::cache_directory;
use longstep_llm::ModelError;
use longstep_llm::catalogue::{self, Entry};
use longstep_llm::store::{self, PullOptions};

use crate::arguments::ModelCommand;
use crate::failure::Failure;
use crate::output::{self, Style, print_line};
use crate::progress::Download;

pub(crate) fn run(command: &ModelCommand) -> Result<u8> {
    let cache = cache_directory()?;
    match command {
        ModelCommand::List => {
            for entry in catalogue::ENTRIES {
                let here = store::path(entry, &cache).is_some();
                let mark = if here { "here" } else { "-" };
                let default = if entry.name == catalogue::DEFAULT {
                    " (default)"
                } else {
                    ""
                };
                print_line!(
                    "{:20}  {:>8}  {:4}  {:10}  {}{default}",
                    entry.name.bold(),
                    format!("{} MB", entry.bytes / 1_000_000),
                    mark,
                    entry.licence,
                    entry.description
                );
            }
            output::blank();
            print_line!("Models are saved in {}", cache.display());
        }
        ModelCommand::Pull { name, from } => {
            let entry = find(name)?;
            let options = PullOptions::from_environment().with_from(from.clone());
            let bar = Download::new(entry.bytes);
            let path = store::pull(entry, &cache, &options, &mut |progress| bar.show(&progress))?;
            drop(bar);
            print_line!("{}", path.display());
        }
        ModelCommand::Path { name } => {
            let entry = find(name)?;
            let path = store::locate(entry, &cache)?.ok_or_else(|| ModelError::NotPulled {
                name: entry.name,
                cache: cache.clone(),
            })?;
            print_line!("{}", path.display());
        }
    }
    Ok(0)
}

fn find(name: &str) -> Result<&'static Entry> {
    Ok(catalogue::find(name).ok_or_else(|| {
        let names: Vec<&str> = catalogue::ENTRIES.iter().map(|entry| entry.name).collect();
        let hint = match nearest(name, names.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("the catalogue contains {}", names.join(", ")),
        };
        Failure::unreadable(format!("there is no model `{name}` in the catalogue")).hint(hint)
    })?)
}
