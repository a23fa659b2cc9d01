//! The model of tests that need a real one.

use longstep_files::cache_directory;
use longstep_llm::{AdapterChoice, ChatModel, ModelReference, OpenOptions, Progress, catalogue, open};

/// Opens the model that `LONGSTEP_MODEL` names, by default the catalogue's default model, with `LONGSTEP_THREADS` threads (1)
/// and the adapter files of `LONGSTEP_ADAPTERS` (as in a `PATH`; without it, those of the catalogue).
pub(crate) fn model() -> Box<dyn ChatModel> {
    let name = std::env::var("LONGSTEP_MODEL").unwrap_or_else(|_| catalogue::DEFAULT.to_owned());
    let reference: ModelReference = name.parse().unwrap_or_else(|error| panic!("{error}"));
    let threads = std::env::var("LONGSTEP_THREADS").map_or(1, |threads| threads.parse().unwrap());
    let adapters = std::env::var_os("LONGSTEP_ADAPTERS").map_or(AdapterChoice::Catalogue, |files| {
        AdapterChoice::Files(std::env::split_paths(&files).collect())
    });
    let options = OpenOptions::new(cache_directory().unwrap()).with_adapters(adapters).with_threads(Some(threads));
    open(&reference, &options, &mut |_: Progress| {}).unwrap_or_else(|error| panic!("{error}"))
}
