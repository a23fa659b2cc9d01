//! Any script is bound, verified and repaired in two small worlds, or refused with a reason.
#![no_main]

use libfuzzer_sys::fuzz_target;
use longstep::plan::{PlanFile, TaskCohesion, script};
use longstep_fuzz::checks::check_plan;
use longstep_fuzz::scenes::{CHECKS, DUAL};

fuzz_target!(|text: &str| {
    let Ok(written) = script::read(text) else {
        return;
    };
    let file = PlanFile::from(TaskCohesion::from_written(written));
    for scene in [&CHECKS, &DUAL] {
        check_plan(scene, file.clone());
    }
});
