//! The adapters of a model: small additions to its weights (LoRA), each for one task.

use std::io::Write;
use std::path::{Path, PathBuf};

use llama_cpp_2::gguf::GgufContext;
use llama_cpp_2::model::{LlamaLoraAdapter, LlamaModel};
use longstep::dialogue::Task;

use super::file::{check, not_loaded};
use crate::{AdapterChoice, ModelError, catalogue, store};

/// An adapter of the catalogue: the name of its model, its task and its file.
type Shipped = (&'static str, Task, &'static [u8]);

/// The adapters of the catalogue. `lab/adapter` trains them.
static SHIPPED: &[Shipped] = &[
    (
        catalogue::DEFAULT,
        Task::Goals,
        include_bytes!("../../adapters/qwen2.5-coder-1.5b/goals.gguf"),
    ),
    (
        catalogue::DEFAULT,
        Task::Description,
        include_bytes!("../../adapters/qwen2.5-coder-1.5b/description.gguf"),
    ),
    (
        catalogue::DEFAULT,
        Task::Plans,
        include_bytes!("../../adapters/qwen2.5-coder-1.5b/plans.gguf"),
    ),
];

/// The key of a file that names the task of its adapter.
const TASK: &str = "longstep.task";

/// The number of texts among the types of GGUF's values.
const TEXT: u64 = 8;

/// An adapter that is not loaded yet.
pub(super) struct Adapter {
    pub(super) task: Task,
    /// Changes with the content, and is part of the key of saved states.
    pub(super) identity: String,
    source: Source,
}

enum Source {
    Shipped(&'static [u8]),
    File(PathBuf),
}

/// Returns the adapters for the model with this name.
pub(super) fn chosen(name: &str, choice: &AdapterChoice) -> Result<Vec<Adapter>, ModelError> {
    let files = match choice {
        AdapterChoice::Off => return Ok(Vec::new()),
        AdapterChoice::Catalogue => {
            let own = SHIPPED.iter().filter(|(model, ..)| *model == name);
            return Ok(own
                .map(|(_, task, content)| Adapter {
                    task: *task,
                    identity: format!("{:08x}", crc32fast::hash(content)),
                    source: Source::Shipped(content),
                })
                .collect());
        }
        AdapterChoice::Files(files) => files,
    };
    let mut adapters: Vec<Adapter> = Vec::new();
    for path in files {
        let adapter = in_file(path)?;
        if adapters.iter().any(|own| own.task == adapter.task) {
            return Err(not_loaded(path, "another adapter has the same task"));
        }
        adapters.push(adapter);
    }
    Ok(adapters)
}

fn in_file(path: &Path) -> Result<Adapter, ModelError> {
    check(path)?;
    let task = match task_of(path).as_deref() {
        Some("goals") => Task::Goals,
        Some("description") => Task::Description,
        Some("plans") => Task::Plans,
        _ => return Err(not_loaded(path, "it is no adapter with a task (`longstep.task`)")),
    };
    Ok(Adapter {
        task,
        identity: store::identity(path)?,
        source: Source::File(path.to_path_buf()),
    })
}

/// Returns the task that a file names.
fn task_of(path: &Path) -> Option<String> {
    let metadata = GgufContext::from_file(path)?;
    let key = metadata.find_key(TASK);
    let is_text = key >= 0 && u64::from(metadata.kv_type(key)) == TEXT;
    let task = is_text.then(|| metadata.val_str(key)).flatten()?;
    Some(task.to_owned())
}

impl Adapter {
    /// Loads the adapter beside its model.
    pub(super) fn load(&self, model: &mut LlamaModel) -> Result<LlamaLoraAdapter, ModelError> {
        match &self.source {
            Source::File(path) => load(model, path),
            Source::Shipped(content) => {
                // llama.cpp reads adapters from files only, and keeps a copy.
                let folder = std::env::temp_dir();
                let file = tempfile::NamedTempFile::new();
                let mut file = file.map_err(ModelError::file("cannot create a file in", &folder))?;
                let written = file.write_all(content).and_then(|()| file.flush());
                written.map_err(ModelError::file("cannot write", file.path()))?;
                load(model, file.path())
            }
        }
    }
}

fn load(model: &mut LlamaModel, path: &Path) -> Result<LlamaLoraAdapter, ModelError> {
    let loaded = model.lora_adapter_init(path);
    loaded.map_err(|_| not_loaded(path, "it is not an adapter for this model"))
}
