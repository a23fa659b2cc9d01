//! Any script is bound, verified and repaired in two small worlds, or refused with a reason.
#![no_main]

use libfuzzer_sys::fuzz_target;
use longstep_core::plan::{PlanFile, TaskCohesion, script};
use longstep_fuzz::checks::check_plan;
use longstep_fuzz::scenes::{CHECKS, DUAL};

fuzz_target!(|text: &str| {
    let Ok(written) = script::read(text) else {
        return;
    };
    let file = PlanFile::from(TaskCohesion::from_written(written));
    // Decided by the text, so that an input that fails fails again.
    let number = text
        .bytes()
        .fold(7u32, |sum, byte| sum.wrapping_mul(31).wrapping_add(byte.into()));
    for scene in [&CHECKS, &DUAL] {
        check_plan(scene, file.clone(), number.is_multiple_of(256));
    }
});
