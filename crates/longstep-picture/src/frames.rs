//! The states along a plan, step by step: the pictures of a slider.

use longstep_core::model::{Fact, State, Voice, World};
use longstep_core::plan::StepId;
use longstep_core::verify::VerifiedPlan;
use serde::Serialize;

use crate::scene::{Changes, Placement, Scene, SceneMoment, SceneSchema, changes_between};
use crate::walk::{Follower, Visit, outcomes, walk};

/// A step with the states before and after it, on the first path that reaches it.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct Frame {
    /// Index of the step, from 0; none for the beginning.
    pub step: Option<usize>,
    /// Explanation of the step; empty for the beginning.
    pub text: String,
    /// Outcomes of sensing on the path before the step, as sentences.
    pub way: Vec<String>,
    /// The outcome that a sensing step has on the path, as a sentence.
    pub outcome: Option<String>,
    /// The changes of the step.
    pub changes: Changes,
    #[serde(skip)]
    before: State,
    #[serde(skip)]
    after: State,
}

impl Frame {
    /// Returns the state before the step.
    pub fn before(&self) -> &State {
        &self.before
    }

    /// Returns the state after the step.
    pub fn after(&self) -> &State {
        &self.after
    }

    /// Returns the scene after the step, in the world of the plan.
    pub fn scene(&self, world: &World) -> Scene {
        Scene::of(world, &self.after)
    }
}

/// Returns the frames of a plan: the beginning, then the steps in reading order.
///
/// A step that no path reaches has no frame. Of a plan with very many paths or visits of steps (256 states at a node,
/// 100,000 visits), steps may be left out too. A plan of 1,000 steps in a world of 500 entities takes about 0.1 s.
///
/// ```
/// use longstep_core::plan;
/// use longstep_core::verify::check_file;
/// use longstep_core::{domain, environment};
/// use longstep_picture::frames;
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
/// let world = environment::parse(&household, "env.json", text).unwrap();
/// let draft = plan::read(r#"{"task_sequence": ["move_hand()", "grasp_object()", "release_object()"], "object_name": "<pen>"}"#).unwrap();
/// let plan = check_file(&world, &draft.file).unwrap().into_verified().unwrap();
/// let frames = frames(&plan);
/// assert_eq!(frames.iter().map(|frame| frame.step).collect::<Vec<_>>(), [None, Some(0), Some(1), Some(2)]);
/// assert_eq!(frames[2].changes.states[0].gained, ["in the hand"]);
/// ```
pub fn frames(plan: &VerifiedPlan) -> Vec<Frame> {
    let world = plan.world();
    let schema = SceneSchema::of(world.domain());
    let mut recorder = Recorder {
        plan,
        schema: &schema,
        frames: vec![None; plan.steps().len()],
        last: None,
    };
    walk(world, plan.plan(), &mut recorder);
    let beginning = Frame {
        step: None,
        text: String::new(),
        way: Vec::new(),
        outcome: None,
        changes: Changes::default(),
        before: world.state.clone(),
        after: world.state.clone(),
    };
    std::iter::once(beginning)
        .chain(recorder.frames.into_iter().flatten())
        .collect()
}

/// Records the first visit of each step.
struct Recorder<'a> {
    plan: &'a VerifiedPlan,
    schema: &'a SceneSchema,
    frames: Vec<Option<Frame>>,
    /// The state after the last recorded step, with its placement: usually the one before the next step.
    last: Option<(State, Placement)>,
}

impl Recorder<'_> {
    fn sentence(&self, fact: Fact) -> String {
        Voice::Person.fact(self.plan.world(), fact, true)
    }

    fn frame(&mut self, visit: &Visit<'_>) -> Frame {
        let world = self.plan.world();
        let place = |state: &State| Placement::of(self.schema, world, state);
        let before = match self.last.take() {
            Some((state, placement)) if state == *visit.before => placement,
            _ => place(visit.before),
        };
        let after = place(visit.after);
        let moment = |state, placement| SceneMoment { state, placement };
        let changes = changes_between(
            self.schema,
            world,
            moment(visit.before, &before),
            moment(visit.after, &after),
            visit.changes,
        );
        self.last = Some((visit.after.clone(), after));
        Frame {
            step: Some(visit.step.index()),
            text: self.plan.plan().step(visit.step).explanation.clone(),
            way: outcomes(visit.way)
                .into_iter()
                .map(|fact| self.sentence(fact))
                .collect(),
            outcome: visit.outcome.map(|fact| self.sentence(fact)),
            changes,
            before: visit.before.clone(),
            after: visit.after.clone(),
        }
    }

    fn is_recorded(&self, step: StepId) -> bool {
        self.frames[step.index()].is_some()
    }
}

impl Follower for Recorder<'_> {
    type Memory = ();

    fn visit(&mut self, visit: &Visit<'_>, _memory: &mut ()) {
        if !self.is_recorded(visit.step) {
            let frame = self.frame(visit);
            self.frames[visit.step.index()] = Some(frame);
        }
    }

    fn join(&mut self, _memory: &mut (), _other: ()) {}
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use longstep_core::plan::{self, Node, Plan, Step, StepId, Test};
    use longstep_core::testing;
    use longstep_core::verify::check_file;

    use super::*;
    use crate::draw::SvgOptions;
    use crate::draw::inspect;
    use crate::scene::svg;
    use crate::shipped;

    /// Reads and verifies a script.
    fn scripted(world: &World, script: &str) -> VerifiedPlan {
        let draft = plan::read(script).unwrap();
        check_file(world, &draft.file).unwrap().into_verified().unwrap()
    }

    /// Checks that frames are in reading order, that the changes are those between their scenes, and that they can be drawn.
    #[track_caller]
    fn check_frames(plan: &VerifiedPlan) -> Vec<Frame> {
        let frames = frames(plan);
        assert_eq!(frames[0].step, None);
        assert!(frames.windows(2).all(|pair| pair[0].step < pair[1].step));
        for frame in &frames {
            let scenes = [frame.before(), frame.after()].map(|state| Scene::of(plan.world(), state));
            assert_eq!(
                frame.changes,
                Scene::difference(&scenes[0], &scenes[1]),
                "{}",
                frame.text
            );
            let picture = svg(&scenes[1], &frame.changes, &SvgOptions::new(400.0));
            inspect::check(&picture, "longstep");
        }
        frames
    }

    #[test]
    fn frames_of_a_sequence_follow_each_other_to_its_ending() {
        let table = [
            (
                "long",
                "crates/longstep-eval/suites/long/scenes/cafe.json",
                "household",
                "put(cheesecake, window table)",
            ),
            (
                "arms",
                "crates/longstep-eval/suites/two-arms/scenes/workshop.json",
                "household-dual",
                "put(screws, workbench)",
            ),
            (
                "kitchen",
                "crates/longstep-eval/suites/kitchen/scenes/family.json",
                "virtualhome",
                "put(plate 1, sink)",
            ),
            (
                "hall",
                "examples/warehouse/suite/scenes/cold_store.json",
                "warehouse",
                "brought(pallet 17, dock 3)",
            ),
        ];
        for (label, file, domain, goal) in table {
            let plan = testing::plan_for(&shipped::world(domain, file), goal);
            let frames = check_frames(&plan);
            assert_eq!(frames.len(), plan.steps().len() + 1, "{label}");
            for pair in frames.windows(2) {
                assert_eq!(pair[0].after(), pair[1].before(), "{label}");
            }
            assert_eq!(frames[frames.len() - 1].after(), &plan.ending().after, "{label}");
        }
    }

    const CHECKS: &str = r#"{"assets": ["<table>", "<fridge>", "<bin>"], "objects": ["<milk>"],
        "object_states": {"<milk>": "on_something(<table>)"}}"#;

    #[test]
    fn frames_of_a_branch_say_which_outcome_leads_to_them() {
        let world = testing::world("household-checks", CHECKS);
        let plan = scripted(
            &world,
            "# objects: [\"<milk>\"]\nmove_hand()\ngrasp_object()\ndetach_from_plane()\nif check_best_by_date():\n    move_object(to=\"<fridge>\")\n    attach_to_plane()\n    release_object()\nelse:\n    move_object(to=\"<bin>\")\n    release_object()\n",
        );
        let frames = check_frames(&plan);
        let ways: Vec<(usize, Vec<String>, Option<String>)> = frames[4..]
            .iter()
            .map(|frame| (frame.step.unwrap(), frame.way.clone(), frame.outcome.clone()))
            .collect();
        let fresh = vec!["the milk is not past its date".to_owned()];
        let expired = vec!["the milk is past its date".to_owned()];
        assert_eq!(ways[0], (3, Vec::new(), Some(fresh[0].clone())));
        assert_eq!(ways[1], (4, fresh, None));
        assert_eq!(ways[4].1, expired, "{ways:?}");
        assert_eq!(frames.len(), 10);
    }

    #[test]
    fn loops_are_followed_until_their_states_repeat() {
        let world = testing::world(
            "household-checks",
            r#"{"assets": ["<table>"], "objects": ["<sponge>"], "object_states": {"<sponge>": "on_something(<table>)"}}"#,
        );
        let step = |name: &str, arguments: &[&str]| shipped::step(&world, name, arguments);
        let steps = vec![
            step("move-hand", &["<sponge>"]),
            step("grasp", &["<sponge>"]),
            step("detach", &["<sponge>", "<table>"]),
            step("move-object", &["<sponge>", "<table>"]),
            step("attach", &["<sponge>", "<table>"]),
            step("check-cleanness", &["<table>"]),
            step("wipe", &["<sponge>", "<table>"]),
            step("release", &["<sponge>"]),
            step("move-hand", &["<table>"]),
            step("move-hand", &["<sponge>"]),
        ];
        let id = StepId::new;
        let mut body: Vec<Node> = (0..5).map(id).map(Node::Step).collect();
        body.push(Node::While {
            condition: Test::Not(Box::new(Test::Sense(id(5)))),
            body: vec![Node::Step(id(6))],
        });
        body.push(Node::Step(id(7)));
        body.push(Node::Repeat {
            times: 4_000_000_000,
            body: vec![Node::Step(id(8)), Node::Step(id(9))],
        });
        let plan = shipped::verified(&world, Plan::tree(steps, body).unwrap());
        assert_eq!(check_frames(&plan).len(), plan.steps().len() + 1);
    }

    #[test]
    fn step_that_no_path_reaches_has_no_frame() {
        let text = CHECKS.replace("\"on_something(<table>)\"", "[\"on_something(<table>)\", \"fresh()\"]");
        let world = testing::world("household-checks", text);
        let plan = scripted(
            &world,
            "# objects: [\"<milk>\"]\nmove_hand()\ngrasp_object()\nif not fresh(\"<milk>\"):\n    release_object()\n    grasp_object()\nrelease_object()\n",
        );
        let steps: Vec<Option<usize>> = check_frames(&plan).iter().map(|frame| frame.step).collect();
        assert_eq!(steps, [None, Some(0), Some(1), Some(4)]);
    }

    #[test]
    fn thousand_steps_in_a_world_of_five_hundred_entities() {
        let assets: Vec<String> = (0..50).map(|number| format!("<shelf_{number}>")).collect();
        let objects: Vec<String> = (0..450).map(|number| format!("<item_{number}>")).collect();
        let on =
            |(number, item): (usize, &String)| (item.clone(), format!("on_something({})", assets[number % 50]).into());
        let states: serde_json::Map<_, _> = objects.iter().enumerate().map(on).collect();
        let world = testing::world(
            "household",
            serde_json::json!({"assets": assets, "objects": objects, "object_states": states}),
        );
        let step = |name: &str, arguments: &[&str]| shipped::step(&world, name, arguments);
        let mut steps: Vec<Step> = Vec::new();
        for (number, item) in objects.iter().enumerate().take(167) {
            let (from, to) = (&assets[number % 50], &assets[(number + 1) % 50]);
            steps.push(step("move-hand", &[item]));
            steps.push(step("grasp", &[item]));
            steps.push(step("detach", &[item, from]));
            steps.push(step("move-object", &[item, to]));
            steps.push(step("attach", &[item, to]));
            steps.push(step("release", &[item]));
        }
        let plan = shipped::verified(&world, Plan::sequence(steps));
        let begin = Instant::now();
        let frames = frames(&plan);
        let taken = begin.elapsed();
        assert_eq!(frames.len(), 1003);
        // Room for a slow machine and a build without optimisation; the measure is in the report of the crate.
        assert!(taken.as_millis() < 2_000, "{taken:?}");
    }
}
