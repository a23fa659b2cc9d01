//! A build without the embedded engine: `cargo test -p longstep-llm --no-default-features --test without_engine`.
#![cfg(not(feature = "embedded"))]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use longstep_llm::{ModelError, ModelReference, OpenOptions, catalogue, open};

#[test]
fn an_embedded_model_is_refused_with_what_to_do() {
    for name in [catalogue::DEFAULT, "weights.gguf"] {
        let reference: ModelReference = name.parse().unwrap();
        let error = open(&reference, &OpenOptions::new("unused".into()), &mut |_| {}).err();
        let Some(error @ ModelError::NoEngine { .. }) = error else {
            panic!("{name}: {error:?}");
        };
        assert!(error.to_string().contains(name), "{error}");
        assert!(error.hint().unwrap().contains("feature `embedded`"));
    }
}
