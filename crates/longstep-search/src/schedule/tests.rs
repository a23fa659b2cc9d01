//! Tests of lanes made from sequences of steps.

use super::*;
use crate::goal;
use crate::testing;
use longstep_model::environment;
use longstep_model::model::World;
use longstep_verify::plan::{Lane, LaneItem, Node, Plan, Step, StepId, TaskCohesion, Test, resolve};
use longstep_verify::verify::{Purpose, VerifiedPlan, bind, check};

/// A bench with two objects on it, a rack, and a locker with a jar in it.
const ROOM: &str = r#"{
    "assets": ["<bench>", "<rack>", "<locker>"],
    "objects": ["<mug>", "<towel>", "<jar>", "<trunk>", "<locker_handle>"],
    "object_states": {"<mug>": "on_something(<bench>)", "<towel>": "on_something(<bench>)",
        "<trunk>": "on_something(<bench>)",
        "<jar>": "inside_something(<locker>)", "<locker_handle>": "closed()"},
    "object_properties": {"<locker_handle>": "ROTATES", "<trunk>": "HEAVY"}}"#;

fn room(text: &str) -> (Domain, World) {
    let domain = testing::domain("household-dual");
    let world = testing::world_of(&domain, text);
    (domain, world)
}

fn solved(world: &World, goal: &str) -> (VerifiedPlan, Purpose) {
    let purpose = goal::parse(world, goal).unwrap().purpose(world);
    (testing::plan_for(world, goal), purpose)
}

/// Solves a goal in the room, and checks the number of steps and the makespans as a sequence and as lanes.
#[track_caller]
fn check_time(goal: &str, expected: (usize, u64)) {
    let (_, world) = room(ROOM);
    let (plan, purpose) = solved(&world, goal);
    let shared = share(&world, &plan, &purpose);
    let time = shared.as_ref().map_or(makespan(plan.plan()), |shared| shared.after);
    assert_eq!((plan.steps().len(), time.units()), expected, "{goal}");
    if let Some(shared) = shared {
        let after = |plan: &VerifiedPlan| environment::write(&world, &plan.ending().after);
        assert_eq!(after(&shared.plan), after(&plan), "{goal}");
        assert_eq!(shared.before, makespan(plan.plan()), "{goal}");
        assert_eq!(shared.after, makespan(shared.plan.plan()), "{goal}");
    }
}

#[test]
fn schedule_shares_independent_work_between_hands() {
    // One object is the work of one hand.
    check_time("put(mug, rack)", (6, 6));
    check_time("put(mug, rack) & put(towel, rack)", (12, 6));
    // A hand that the goal names stays.
    check_time("put(mug, rack, right hand) & put(towel, rack, right hand)", (12, 12));
    check_time("put(mug, rack, right hand) & put(towel, rack, left hand)", (12, 6));
    // Two hands handle one object in turn.
    check_time("put(trunk, rack)", (9, 9));
    check_time("put(jar, rack) & closed(locker)", (11, 8));
}

#[track_caller]
fn check_units(body: Vec<Node>, expected: &str) {
    let (domain, world) = room(ROOM);
    let count = longstep_verify::plan::tree::steps(&body).count();
    let mug = world.find("<mug>").unwrap();
    let (wait, _) = domain.action_ids().find(|(_, action)| action.name == "grasp").unwrap();
    let step = Step::explained(&world, wait, vec![world.find("right").unwrap(), mug]);
    let plan = Plan::tree(vec![step; count], body).unwrap();
    assert_eq!(makespan(&plan).to_string(), expected);
}

fn step(number: usize) -> Node {
    Node::Step(StepId::new(number))
}

/// Parses a lane: numbers are steps, all other words are synchronisation points.
fn lane(actor: usize, items: &str) -> Lane {
    let item = |word: &str| match word.parse() {
        Ok(number) => LaneItem::Step(StepId::new(number)),
        Err(_) => LaneItem::Sync(word.to_owned()),
    };
    Lane {
        actor: EntityId::new(actor),
        items: items.split_whitespace().map(item).collect(),
    }
}

#[test]
fn makespan_follows_the_longest_path() {
    check_units(vec![step(0), Node::Remark("on".to_owned()), step(1)], "2 units");
    let branch = Node::If {
        condition: Test::Sense(StepId::new(0)),
        then: vec![step(1)],
        otherwise: vec![step(2), step(3)],
    };
    check_units(vec![branch], "3 units");
    check_units(
        vec![
            Node::Repeat {
                times: 3,
                body: vec![step(0)],
            },
            step(1),
        ],
        "4 units",
    );
    let endless = Node::While {
        condition: Test::Sense(StepId::new(0)),
        body: vec![step(1)],
    };
    check_units(vec![endless, step(2)], "at least 4 units");
    let lanes = |lanes: &[&str]| Node::Parallel {
        lanes: lanes
            .iter()
            .enumerate()
            .map(|(actor, items)| lane(actor, items))
            .collect(),
    };
    check_units(vec![lanes(&["0 1 2", "3"])], "3 units");
    check_units(vec![lanes(&["0 1 a 2", "a 3 4"]), step(5)], "5 units");
    // Three lanes, two of which synchronise.
    check_units(vec![lanes(&["0 1 a 2", "3 4 5", "a 6"])], "3 units");
    // A deadlock, which verification reports.
    check_units(vec![lanes(&["a 0 b", "b 1 a"])], "2 units");
}

/// Parses calls and their explanations, and arranges them as lanes; steps are counted from 1.
#[track_caller]
fn check_lanes(things: &[&str], steps: &[(&str, &str)], expected: &str) {
    let (_, world) = room(ROOM);
    let written = TaskCohesion {
        task_sequence: steps.iter().map(|(call, _)| (*call).to_owned()).collect(),
        step_instructions: steps.iter().map(|(_, about)| (*about).to_owned()).collect(),
        object_names: things.iter().map(|thing| (*thing).to_owned()).collect(),
        ..TaskCohesion::default()
    };
    let resolved = resolve(&world, &written);
    let (plan, _) = bind(&world, &resolved.complete().unwrap(), &resolved.objects, None).unwrap();
    let plan = check(&world, plan, &Purpose::default()).into_verified();
    let plan = plan.unwrap_or_else(|report| panic!("{:?}", report.violations));
    let outline = match compact(&world, &plan, &Purpose::default()) {
        None => "as it was".to_owned(),
        Some(compacted) => {
            let same = compacted.plan.ending().after == plan.ending().after;
            assert!(same);
            outline(&world, compacted.plan.plan())
        }
    };
    assert_eq!(outline, expected);
}

fn outline(world: &World, plan: &Plan) -> String {
    let call = |id: &StepId| plan.step(*id).call(world).name;
    let node = |node: &Node| match node {
        Node::Step(id) => call(id),
        Node::Parallel { lanes } => {
            let item = |item: &LaneItem| match item {
                LaneItem::Step(id) => call(id),
                LaneItem::Sync(name) => format!("<{name}>"),
                LaneItem::Remark(_) => String::new(),
            };
            let lane = |lane: &Lane| {
                let items: Vec<String> = lane.items.iter().map(item).collect();
                format!("{}: {}", world.entity(lane.actor).identifier, items.join(" "))
            };
            format!("[{}]", lanes.iter().map(lane).collect::<Vec<_>>().join(" | "))
        }
        _ => "?".to_owned(),
    };
    plan.body().iter().map(node).collect::<Vec<_>>().join("; ")
}

#[test]
fn schedule_synchronizes_lanes_where_order_matters() {
    let open = [
        ("move_hand(right)", "to the locker handle"),
        ("grasp_object(right)", "grasp the locker handle"),
        ("open_by_rotate(right)", "open with the locker handle"),
    ];
    let jar = [
        ("move_hand(left)", "to the jar"),
        ("grasp_object(left)", "grasp the jar"),
        ("detach_from_plane(left)", "pick up the jar"),
        ("move_object(left)", "move the jar to the rack"),
        ("attach_to_plane(left)", "put the jar on the rack"),
        ("release_object(left)", "release the jar"),
    ];
    let close = [
        ("close_by_rotate(right)", "close with the locker handle"),
        ("release_object(right)", "release the locker handle"),
    ];
    // The left hand goes to the locker while the right one opens it, and the locker is closed when the jar is out.
    check_lanes(
        &["<locker_handle>", "<jar>"],
        &[&open[..], &jar, &close].concat(),
        "[right: move_hand grasp_object open_by_rotate <sync 1> <sync 2> close_by_rotate release_object | \
         left: move_hand <sync 1> grasp_object detach_from_plane <sync 2> move_object attach_to_plane release_object]",
    );
    check_lanes(&["<locker_handle>"], &[&open[..], &close].concat(), "as it was");
}

#[test]
fn schedule_does_not_parallelize_across_two_handed_steps() {
    check_lanes(
        &["<trunk>"],
        &[
            ("move_hand(right)", "to the trunk"),
            ("grasp_object(right)", "grasp the trunk"),
            ("move_hand(left)", "to the trunk"),
            ("grasp_object(left)", "grasp the trunk"),
            ("lift_with_both_hands()", "lift the trunk"),
            ("carry_with_both_hands()", "carry the trunk to the rack"),
            ("put_down_with_both_hands()", "put the trunk on the rack"),
            ("release_object(right)", "release the trunk"),
            ("move_hand(right)", "move the right hand to the mug"),
            ("release_object(left)", "release the trunk"),
        ],
        "move_hand; grasp_object; move_hand; grasp_object; lift_with_both_hands; carry_with_both_hands; \
         put_down_with_both_hands; [right: release_object <sync 1> move_hand | left: <sync 1> release_object]",
    );
}
