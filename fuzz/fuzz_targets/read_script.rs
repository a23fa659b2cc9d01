//! Any text is read as a script or refused, and what is read keeps everything in both notations.
#![no_main]

use libfuzzer_sys::fuzz_target;
use longstep_core::json::Path;
use longstep_core::plan::{read_tree, script, write_tree};

fuzz_target!(|text: &str| match script::read(text) {
    Ok(written) => {
        let again = script::write(&written);
        assert_eq!(script::read(&again).as_ref(), Ok(&written));
        let tree = read_tree(&write_tree(&written), written.objects.clone(), &Path::default());
        assert_eq!(tree.as_ref(), Ok(&written));
    }
    Err(error) => drop((error.to_string(), error.hint)),
});
