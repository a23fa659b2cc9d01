#![allow(clippy::unwrap_used)]

use longstep_core::{domain, environment};

use super::*;

fn desk() -> Sim {
    let household = domain::shipped("household").unwrap().unwrap();
    let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
    let world = environment::parse(&household, "env.json", text).unwrap();
    Sim::new(world, &SimOptions::default()).unwrap()
}

#[test]
fn an_order_that_no_plan_can_have_is_refused_and_changes_nothing() {
    for (action, arguments, reason) in [
        (
            "grasp",
            vec!["<desk>"],
            "step 1 cannot be sent: `<desk>` is no `item`, which `grasp` takes",
        ),
        ("grasp", vec!["<cup>"], "step 1 cannot be sent: no entity `<cup>`"),
        (
            "grasp",
            vec![],
            "step 1 cannot be sent: 0 arguments where `grasp` takes 1",
        ),
        ("fly", vec![], "the robot cannot perform `fly`"),
    ] {
        let mut sim = desk();
        let before = sim.state().clone();
        let error = sim.start(&Order::new(1, action, arguments)).unwrap_err();
        assert_eq!(error.to_string(), reason);
        assert!(!error.is_final());
        assert_eq!((sim.state(), sim.counts().orders), (&before, 0));
    }
}
