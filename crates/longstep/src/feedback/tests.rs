//! Utterances and wishes, with the amended plans or the reasons against them.

use super::reference::References;
use super::*;
use crate::dialogue::{ConstraintKind, Dialogue, Reply};
use crate::domain::{self, Domain};
use crate::environment::World;
use crate::plan::{Plan, TaskCohesion, resolve};
use crate::repair::Reach;
use crate::{goal, verify};
use longstep_core::testing;

const DEN: &str = r#"{
    "assets": ["<desk>", "<rack_low>", "<rack_high>", "<cabinet>", "<floor>"],
    "objects": ["<tea>", "<cabinet_handle>"],
    "object_states": {"<tea>": "on_something(<rack_low>)", "<cabinet_handle>": "closed()"}}"#;

const STUDIO: &str = r#"{
    "assets": ["<desk_1>", "<fridge_2>", "<sofa_3>"],
    "objects": ["<milk_4>"],
    "object_states": {"<milk_4>": ["ON(<desk_1>)"]},
    "asset_properties": {"<fridge_2>": ["IS_OPENABLE"], "<desk_1>": ["NOT_OPENABLE"], "<sofa_3>": ["NOT_OPENABLE"]}}"#;

/// A domain, a world, and a plan for a goal.
struct Scene {
    domain: Domain,
    world: World,
    plan: Plan,
    purpose: verify::Purpose,
}

fn scene(name: &str, environment: &str, wanted: &str) -> Scene {
    let domain = domain::shipped(name).unwrap().unwrap();
    let world = testing::world_of(&domain, environment);
    Scene {
        plan: testing::plan_for(&world, wanted).plan().clone(),
        purpose: goal::parse(&world, wanted).unwrap().purpose(&world),
        domain,
        world,
    }
}

fn den() -> Scene {
    scene("household", DEN, "put(tea, rack high)")
}

fn studio() -> Scene {
    scene("virtualhome", STUDIO, "put(milk, fridge)")
}

impl Scene {
    /// Returns the sentences of the amended plan and its other edits, or the reasons against it.
    fn amended(&self, wishes: &[StepWish]) -> Vec<String> {
        match amend(&self.world, &self.plan, wishes, &self.purpose) {
            Amended::Done(done) => {
                let sentences = done.plan.steps().iter().map(|step| step.explanation.clone());
                let edits = done
                    .edits
                    .iter()
                    .map(|edit| format!("({})", edit.description(usize::MAX)));
                sentences.chain(edits).collect()
            }
            Amended::Impossible { why, .. } => why.iter().map(ToString::to_string).collect(),
        }
    }

    #[track_caller]
    fn check(&self, answer: &str, expected: &[&str]) {
        let wishes = parse(&self.world, answer, self.plan.steps().len()).unwrap();
        assert_eq!(self.amended(&wishes), expected, "{answer}");
    }

    /// Interprets an answer about an utterance.
    fn supplied(&self, utterance: &str, answer: &str, kind: ConstraintKind) -> Result<Wish, String> {
        let mut dialogue = FeedbackDialogue::new(FeedbackInput {
            domain: &self.domain,
            world: &self.world,
            plan: &self.plan,
            instruction: "Do it",
            feedback: utterance,
            kind,
        });
        let request = dialogue.request();
        assert_eq!(request, dialogue.request());
        let reply = Reply::complete(answer);
        let mut wish = dialogue.supply(&reply).map_err(|error| error.to_string())?;
        if wish.is_none() {
            // A server's reply in a wrong form is asked for again, once.
            assert_eq!(kind, ConstraintKind::JsonSchema);
            assert!(dialogue.request().messages.len() > request.messages.len());
            wish = dialogue.supply(&reply).map_err(|error| error.to_string())?;
        }
        Ok(wish.expect("the second reply is the last"))
    }
}

#[test]
fn feedback_without_wishes_keeps_the_plan() {
    let sentences: Vec<String> = den().plan.steps().iter().map(|s| s.explanation.clone()).collect();
    assert_eq!(den().amended(&[]), sentences);
}

#[test]
fn inserted_step_takes_arguments_of_its_neighbours() {
    let den = den();
    let mut wishes = parse(&den.world, "insert move_object() after 3", 6).unwrap();
    if let StepWish::Insert { explanation, .. } = &mut wishes[0] {
        explanation.push_str("move the tea upward");
    }
    let expected = [
        "move the hand to the tea",
        "grasp the tea",
        "pick up the tea from the rack low",
        "move the tea upward",
        "move the tea to the rack high",
        "put down the tea at the rack high",
        "release the tea",
    ];
    assert_eq!(den.amended(&wishes), expected);
    // Either of the two `move_object` steps can be removed again.
    let plan = match amend(&den.world, &den.plan, &wishes, &den.purpose) {
        Amended::Done(done) => done.plan.plan().clone(),
        other => panic!("{other:?}"),
    };
    let longer = Scene { plan, ..den };
    for step in [3, 4] {
        assert_eq!(longer.amended(&[StepWish::Drop { step }]).len(), 6);
    }
}

#[test]
fn feedback_refuses_impossible_changes_with_the_reason() {
    let den = den();
    den.check(
        "drop 4",
        &["step 4: attach_to_plane() needs that the hand is at the rack high"],
    );
    den.check("drop 6", &["at the end: the tea must be released"]);
    den.check(
        "move 3 before 2",
        &[
            "step 2: detach_from_plane() needs that the hand holds the tea",
            "it would take 9 other changes of the plan",
        ],
    );
    let studio = studio();
    studio.check(
        "drop 4",
        &[
            "step 4: PutIn(<milk_4>, <fridge_2>) needs that the fridge is not closed",
            "step 5: Close(<fridge_2>) needs that the fridge is not closed",
        ],
    );
    studio.check(
        "drop 6",
        &[
            "at the end: the fridge must be closed again after something was put into it",
            "at the end: the fridge must be closed again",
        ],
    );
}

#[test]
fn feedback_repairs_the_rest_of_the_plan() {
    studio().check(
        "move 4 before 1",
        &[
            "walk to the fridge",
            "open the fridge",
            "walk to the milk",
            "grab the milk",
            "walk to the fridge",
            "put the milk into the fridge",
            "close the fridge",
            "(insert Walktowards(<fridge_2>) before step 1)",
        ],
    );
    // The inserted step stays although it changes nothing.
    studio().check(
        "insert Walktowards(fridge) after 3",
        &[
            "walk to the milk",
            "grab the milk",
            "walk to the fridge",
            "walk to the fridge",
            "open the fridge",
            "put the milk into the fridge",
            "close the fridge",
        ],
    );
}

#[test]
fn feedback_rejects_unknown_steps_and_calls() {
    let wish = StepWish::Drop { step: 9 };
    assert_eq!(den().amended(&[wish]), ["the plan has no step 10"]);
    for (answer, expected) in [
        ("drop 9", "`drop 9`: the plan has 6 steps"),
        ("insert fly() after 1", "`fly()` calls no action of this domain"),
        (
            "insert mov_object() after 1",
            "`mov_object()` calls no action of this domain; did you mean `move_object`?",
        ),
    ] {
        let error = parse(&den().world, answer, 6).unwrap_err();
        assert_eq!(error.to_string(), expected);
    }
}

#[test]
fn a_call_in_the_words_is_about_steps_in_any_language() {
    let den = den();
    for (words, expected) in [
        ("Skip the move_object() please.", Some("move_object")),
        ("move_objectを一回減らして", Some("move_object")),
        ("Ohne MOVE_OBJECT bitte", Some("move_object")),
        ("move the object", None),
        ("remove_objects", None),
    ] {
        let actions = References::of(&den.world, words).actions;
        let calls: Vec<&str> = actions.iter().map(|id| den.domain.action(*id).call.as_str()).collect();
        assert_eq!(calls, Vec::from_iter(expected), "{words}");
    }
}

#[test]
fn feedback_offers_every_change_of_the_plan() {
    let den = den();
    let offers = offer::offers(&den.world, &den.plan, &References::default());
    assert!(offers.goal);
    assert_eq!(offers.drops, [0, 1, 2, 3, 4, 5]);
    assert_eq!(offers.moves[2], (2, vec![0, 1, 4, 5, 6]));
    assert_eq!(offers.replaces.len(), 6);
    let call = |(action, _): &offer::Called| den.domain.action(*action).call.as_str();
    let carry = offers
        .inserts
        .iter()
        .find(|(own, _)| call(own) == "move_object")
        .unwrap();
    assert_eq!(carry.1, [3, 4], "where it can be done");
}

#[test]
fn feedback_moves_an_existing_step_instead_of_inserting() {
    let environment = r#"{
        "assets": ["<desk_1>", "<sofa_3>", "<tablelamp_5>"], "objects": ["<mug_4>"],
        "object_states": {"<mug_4>": ["ON(<desk_1>)"]},
        "asset_properties": {"<desk_1>": ["NOT_OPENABLE"], "<sofa_3>": ["NOT_OPENABLE"], "<tablelamp_5>": ["HAS_SWITCH"]}}"#;
    let scene = scene("virtualhome", environment, "put(mug, sofa) then on(tablelamp)");
    let lamp = scene.plan.steps().len() - 1;
    let reordered = |answer: &str| {
        let wishes = parse(&scene.world, answer, scene.plan.steps().len()).unwrap();
        let purpose = goal::parse(&scene.world, "put(mug, sofa) & on(tablelamp)").unwrap();
        let amendment = reordered(&scene.world, &scene.plan, &wishes, &purpose.purpose(&scene.world))?;
        let sentences = amendment.plan.steps().iter().map(|step| step.explanation.clone());
        Some(sentences.collect::<Vec<_>>()[0].clone())
    };
    assert_eq!(scene.plan.steps()[lamp].explanation, "switch on the lamp");
    // Its walk goes with it.
    assert_eq!(
        reordered("insert SwitchOn(lamp) before 1").as_deref(),
        Some("walk to the lamp")
    );
    assert_eq!(reordered("insert SwitchOn(lamp) after 6"), None, "it is there already");
    assert_eq!(
        reordered("insert Walktowards(desk) before 1"),
        None,
        "the plan has no such step"
    );
}

#[test]
fn a_reply_is_a_goal_a_question_or_steps() {
    let den = den();
    let grammar = ConstraintKind::Grammar;
    let schema = ConstraintKind::JsonSchema;
    let drop = Ok(Wish::Steps(vec![StepWish::Drop { step: 3 }]));
    assert_eq!(den.supplied("Skip step 4", "drop 4", grammar), drop);
    assert_eq!(
        den.supplied("Skip it", r#"{"question": "", "edits": ["drop 4"]}"#, schema),
        drop
    );
    assert_eq!(den.supplied("The jam", "goal", grammar), Ok(Wish::Goal));
    assert_eq!(den.supplied("The jam", r#"{"goal": true}"#, schema), Ok(Wish::Goal));
    assert_eq!(den.supplied("The jam too", "further", grammar), Ok(Wish::Further));
    assert_eq!(
        den.supplied("The jam too", r#"{"further": true}"#, schema),
        Ok(Wish::Further)
    );
    let question = Ok(Wish::Question("Which step?".to_owned()));
    assert_eq!(den.supplied("Hm", "question: Which step?", grammar), question);
    assert_eq!(den.supplied("Hm", r#"{"question": "Which step?"}"#, schema), question);
    assert!(den.supplied("Hm", "dance", grammar).is_err());
    assert!(den.supplied("Hm", "dance", schema).is_err());
}

#[test]
fn rewritten_plan_pins_the_steps_that_it_changes() {
    let den = den();
    let own = [
        "move_hand()",
        "grasp_object()",
        "detach_from_plane()",
        "move_object()",
        "attach_to_plane()",
        "release_object()",
    ];
    let sentences: Vec<&str> = den.plan.steps().iter().map(|step| step.explanation.as_str()).collect();
    let step = |index: usize| (own[index], sentences[index]);
    let upward = ("move_object()", "move the tea upward");
    let early = ("release_object()", "let go");
    let all = [0, 1, 2, 3, 4, 5].map(step);
    check_pins(&den, &all, &[], &[]);
    check_pins(&den, &[0, 1, 2, 4, 5].map(step), &[], &[(3, Reach::ThisAction)]);
    check_pins(
        &den,
        &[all[0], all[1], all[2], upward, all[3], all[4], all[5]],
        &[3],
        &[],
    );
    check_pins(
        &den,
        &[all[0], all[1], all[2], all[3], upward, all[4], all[5]],
        &[4],
        &[],
    );
    check_pins(
        &den,
        &[all[0], all[1], early, all[2], all[3], all[4]],
        &[2],
        &[(6, Reach::Here)],
    );
}

#[track_caller]
fn check_pins(scene: &Scene, steps: &[(&str, &str)], kept: &[usize], unwanted: &[(usize, Reach)]) {
    let cohesion = TaskCohesion {
        task_sequence: steps.iter().map(|(call, _)| (*call).to_owned()).collect(),
        step_instructions: steps.iter().map(|(_, sentence)| (*sentence).to_owned()).collect(),
        object_name: Some("<tea>".to_owned()),
        ..TaskCohesion::default()
    };
    let pins = pins(&scene.plan, &resolve(&scene.world, &cohesion));
    let gone: Vec<_> = pins.unwanted.iter().map(|gone| (gone.before, gone.reach)).collect();
    assert_eq!((&pins.kept[..], &gone[..]), (kept, unwanted));
}
