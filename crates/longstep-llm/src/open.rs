//! Opening a model by its reference.

#[cfg(feature = "embedded")]
use crate::embedded::EmbeddedModel;
use crate::model::{ChatModel, OpenOptions, Progress};
use crate::record::{Recording, Replay};
use crate::server::ServerModel;
#[cfg(feature = "embedded")]
use crate::store;
use crate::{ModelError, ModelReference};

/// Opens the model that is meant.
///
/// An embedded model is loaded here (about a second); a server is not contacted before the first request, or before
/// something is asked that only it knows. Servers are waited for on the calling thread: not in asynchronous code.
///
/// # Errors
///
/// [`ModelError::NotPulled`] for a model of the catalogue that is not in the cache,
/// [`ModelError::WrongHash`] for one that has changed there, [`ModelError::NotLoaded`] for a
/// file that is no model, [`ModelError::NoKey`] and [`ModelError::NoAddress`] for a server whose key or address is not
/// set, [`ModelError::NoEngine`] for an embedded model without the feature `embedded`, [`ModelError::File`] and [`ModelError::BadRecording`] for a recording that cannot be read or written.
pub fn open(
    reference: &ModelReference,
    options: &OpenOptions,
    progress: &mut dyn FnMut(Progress),
) -> Result<Box<dyn ChatModel>, ModelError> {
    let model = open_itself(reference, options, progress)?;
    Ok(match &options.record {
        Some(path) => Box::new(Recording::new(model, path)?),
        None => model,
    })
}

fn open_itself(
    reference: &ModelReference,
    options: &OpenOptions,
    progress: &mut dyn FnMut(Progress),
) -> Result<Box<dyn ChatModel>, ModelError> {
    if let Some(model) = ServerModel::open(reference, options) {
        return Ok(Box::new(model?));
    }
    match reference {
        #[cfg(feature = "embedded")]
        ModelReference::Catalogue(entry) => {
            progress(Progress::Loading);
            let path = store::locate(entry, &options.cache)?.ok_or_else(|| ModelError::NotPulled {
                name: entry.name,
                cache: options.cache.clone(),
            })?;
            let identity = entry.sha256.to_owned();
            let model = EmbeddedModel::open(entry.name, &path, identity, options)?;
            Ok(Box::new(model))
        }
        #[cfg(feature = "embedded")]
        ModelReference::File(path) => {
            progress(Progress::Loading);
            let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
            let identity = store::identity(path)?;
            let model = EmbeddedModel::open(&name, path, identity, options)?;
            Ok(Box::new(model))
        }
        #[cfg(not(feature = "embedded"))]
        ModelReference::Catalogue(_) | ModelReference::File(_) => {
            // Only a model in this process takes time to load.
            let _ = progress;
            Err(ModelError::NoEngine {
                model: reference.to_string(),
            })
        }
        ModelReference::Replay(path) => Ok(Box::new(Replay::open(path)?)),
        ModelReference::OpenAi { .. }
        | ModelReference::Azure { .. }
        | ModelReference::Ollama { .. }
        | ModelReference::Anthropic { .. }
        | ModelReference::Gemini { .. }
        | ModelReference::Server { .. } => Err(ModelError::Unsupported {
            model: reference.to_string(),
            reason: "it is on a server".into(),
        }),
    }
}
