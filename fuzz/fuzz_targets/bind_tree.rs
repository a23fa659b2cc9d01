//! Random trees of known calls with hidden and given arguments are bound, verified and repaired.
#![no_main]

use libfuzzer_sys::arbitrary::Unstructured;
use libfuzzer_sys::fuzz_target;
use longstep_core::plan::script;
use longstep_fuzz::checks::check_plan;
use longstep_fuzz::scenes::{CHECKS, DUAL};
use longstep_fuzz::trees;

fuzz_target!(|bytes: &[u8]| {
    let mut bytes = Unstructured::new(bytes);
    let scene = match bytes.ratio(1, 3) {
        Ok(true) => &DUAL,
        _ => &CHECKS,
    };
    let with_repair = bytes.ratio(1, 256).unwrap_or(false);
    let Ok(file) = trees::plan(scene, &mut bytes) else {
        return;
    };
    if let Some(tree) = &file.task_cohesion.task_tree
        && tree.is_sound()
    {
        let text = script::write(tree);
        assert_eq!(script::read(&text).as_ref(), Ok(tree), "{text}");
    }
    check_plan(scene, file, with_repair);
});
