//! Opens a model by its reference.

#[cfg(feature = "embedded")]
use crate::embedded::EmbeddedModel;
use crate::lent::LentModel;
use crate::model::{AdapterChoice, ChatModel, OpenOptions, Progress};
use crate::record::{Recording, Replay};
use crate::server::ServerModel;
#[cfg(feature = "embedded")]
use crate::store;
use crate::{ModelError, ModelReference};

/// Opens the model of a reference.
///
/// Loads an embedded model (about a second). Asks a Longstep server for its model. Does not contact another server: that
/// happens with the first request, or when the size of its context or a token count is needed. Calls to servers block the calling thread: do not use them in
/// asynchronous code.
///
/// # Errors
///
/// [`ModelError::NotPulled`] for a model of the catalogue that is not in the cache, [`ModelError::WrongHash`] for one
/// that has changed there, [`ModelError::NotLoaded`] for a file that is not a model, [`ModelError::NoKey`] and
/// [`ModelError::NoAddress`] for a server whose key or address is not set, [`ModelError::NoEngine`] for an embedded
/// model without the feature `embedded`, [`ModelError::NoVisionEngine`] and [`ModelError::BadProjector`] for a projector
/// that cannot be used, [`ModelError::File`] and [`ModelError::BadRecording`] for a recording that
/// cannot be read or written.
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
    let has_adapters = matches!(options.adapters, AdapterChoice::Files(_));
    for (is_given, reason) in [
        (
            has_adapters,
            "adapters are for an embedded model; leave out `--adapter`",
        ),
        (
            options.vision.is_some(),
            "a projector is for an embedded model; leave out `--vision`",
        ),
    ] {
        if is_given && !reference.is_embedded() {
            return Err(ModelError::Unsupported {
                model: reference.to_string(),
                reason: reason.into(),
            });
        }
    }
    if let Some(projector) = options.vision.as_ref().filter(|_| !cfg!(feature = "vision")) {
        return Err(ModelError::NoVisionEngine {
            place: projector.display().to_string(),
        });
    }
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
            // Only an embedded model takes time to load.
            let _ = progress;
            Err(ModelError::NoEngine {
                model: reference.to_string(),
            })
        }
        ModelReference::Replay(path) => Ok(Box::new(Replay::open(path)?)),
        ModelReference::Lent { url } => Ok(Box::new(LentModel::open(url, options)?)),
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
