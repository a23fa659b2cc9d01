//! The model that the programs of the laboratory ask.

use std::error::Error;

use longstep::dialogue::ChatRequest;
use longstep_files::cache_directory;
use longstep_llm::{AdapterChoice, ChatModel, ModelReference, OpenOptions, Progress, catalogue, open};

/// Opens the model that `LONGSTEP_MODEL` names, by default the catalogue's default model, with `LONGSTEP_THREADS` threads (1)
/// and the adapter files of `LONGSTEP_ADAPTERS` (as in a `PATH`; without it, those of the catalogue).
///
/// # Errors
///
/// If a setting cannot be read or the model cannot be opened. An embedded model needs the feature `embedded`.
pub fn open_model() -> Result<Box<dyn ChatModel>, Box<dyn Error>> {
    let name = std::env::var("LONGSTEP_MODEL").unwrap_or_else(|_| catalogue::DEFAULT.to_owned());
    let reference: ModelReference = name.parse()?;
    let threads = std::env::var("LONGSTEP_THREADS").ok();
    let adapters = std::env::var_os("LONGSTEP_ADAPTERS").map_or(AdapterChoice::Catalogue, |files| {
        AdapterChoice::Files(std::env::split_paths(&files).collect())
    });
    let threads = threads.map_or(Ok(1), |threads| threads.parse())?;
    let options = OpenOptions::new(cache_directory()?)
        .with_adapters(adapters)
        .with_threads(Some(threads));
    Ok(open(&reference, &options, &mut |_: Progress| {})?)
}

/// Returns the mark of a case in a list.
pub fn mark(is_right: bool) -> &'static str {
    if is_right { "right" } else { "wrong" }
}

/// Prints the last message of a request and the form of its answer, if `LONGSTEP_SHOW` is set.
pub fn show(request: &ChatRequest) {
    if std::env::var_os("LONGSTEP_SHOW").is_some() {
        let words = request.messages.last().map_or("", |own| &own.text);
        println!("{words}\n{:?}", request.constraint);
    }
}
