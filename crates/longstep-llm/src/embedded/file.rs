//! Checks a model file before llama.cpp loads it, for clear error messages.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use llama_cpp_2::gguf::GgufContext;

use crate::ModelError;

/// Checks that the file is a GGUF file with readable metadata, and that this processor can run the engine.
pub(super) fn check(path: &Path) -> Result<(), ModelError> {
    let mut magic = [0; 4];
    let mut file = File::open(path).map_err(ModelError::file("cannot read", path))?;
    let metadata = file.metadata().map_err(ModelError::file("cannot read", path))?;
    if !metadata.is_file() {
        return Err(not_loaded(path, "it is not a file"));
    }
    if file.read_exact(&mut magic).is_err() || magic != *b"GGUF" {
        return Err(not_loaded(path, "it is not a GGUF file"));
    }
    if !processor_is_new_enough() {
        return Err(not_loaded(
            path,
            "the engine was built for processors with AVX2, which this one lacks",
        ));
    }
    super::engine::backend().map_err(|reason| not_loaded(path, &reason))?;
    if GgufContext::from_file(path).is_none() {
        return Err(not_loaded(path, "its metadata is damaged or incomplete"));
    }
    Ok(())
}

pub(super) fn not_loaded(path: &Path, reason: &str) -> ModelError {
    ModelError::NotLoaded {
        path: path.to_path_buf(),
        reason: reason.to_owned(),
    }
}

/// llama.cpp is compiled with AVX2 unless the build turns it off. Without this check the program would end with an
/// illegal instruction on an older processor.
#[cfg(target_arch = "x86_64")]
fn processor_is_new_enough() -> bool {
    option_env!("GGML_AVX2") == Some("OFF")
        || (std::is_x86_feature_detected!("avx2")
            && std::is_x86_feature_detected!("fma")
            && std::is_x86_feature_detected!("f16c")
            && std::is_x86_feature_detected!("bmi2"))
}

#[cfg(not(target_arch = "x86_64"))]
fn processor_is_new_enough() -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn check_rejects_files_that_are_not_gguf_models() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.gguf");
        assert!(check(&path).unwrap_err().to_string().contains("x.gguf"));
        for (content, expected) in [
            (&b""[..], "not a GGUF file"),
            (b"GGU", "not a GGUF file"),
            (b"PK\x03\x04 something", "not a GGUF file"),
            (b"GGUF", "damaged or incomplete"),
            (
                b"GGUF\x03\0\0\0\xff\xff\xff\xff\xff\xff\xff\x7f",
                "damaged or incomplete",
            ),
        ] {
            std::fs::write(&path, content).unwrap();
            let error = check(&path).unwrap_err();
            assert!(error.to_string().contains(expected), "{error}");
            assert!(error.to_string().contains("x.gguf") && error.hint().is_some());
        }
        let error = check(folder.path()).unwrap_err();
        assert!(error.to_string().contains("not a file"), "{error}");
    }
}
