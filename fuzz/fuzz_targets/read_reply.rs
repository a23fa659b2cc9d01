//! Any reply is read or refused, and what is read is the same when it is written and read again.
#![no_main]

use libfuzzer_sys::fuzz_target;
use longstep_core::plan::{Unreadable, read};

fuzz_target!(|text: &str| match read(text) {
    Ok(draft) => {
        let written = serde_json::to_string(&draft.file).expect("a plan can be written");
        let again = read(&written).expect("what was written can be read");
        assert_eq!(again.file, draft.file);
        assert!(again.leniencies.is_empty());
        // Without its last bracket it is no plan any more.
        assert!(matches!(
            read(&written[..written.len() - 1]),
            Err(Unreadable::CutOff { .. })
        ));
        draft.leniencies.iter().for_each(|leniency| drop(leniency.message()));
    }
    Err(unreadable) => drop((unreadable.to_string(), unreadable.hint())),
});
