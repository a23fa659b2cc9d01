//! Forty prohibitions over all ways to a plan: no accepted plan ever breaks one.
//!
//! The library decides what is accepted. Whether a plan breaks a prohibition is decided here, by a second evaluator over the
//! states and steps of the plan ([`watch`]), which knows nothing of the library's prohibitions.
//!
//! `LONGSTEP_PROHIBITIONS_MODEL=MODEL cargo test -p longstep-eval --test prohibitions model -- --ignored --nocapture` says
//! the forty to a model.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    missing_docs
)]

mod watch;

use std::path::Path;
use std::sync::Arc;

use longstep::compose::{Composed, Stored, inline};
use longstep::dialogue::{ConstraintKind, EstimatedTokens, Reply};
use longstep::domain::Domain;
use longstep::report::{self, Assessment, Status};
use longstep::session::{ModelFacts, RepairPolicy, Response, Session, Settings, Strategy};
use longstep::{Clock, Limits, VerifiedPlan, World, goal};
use longstep_core::plan::{self, PlanFile, script};
use longstep_core::repair::RepairOutcome;
use longstep_core::testing;
use longstep_files::cache_directory;
use longstep_llm::{ModelReference, OpenOptions, Progress, advance, open};
use serde::Deserialize;

use watch::Watch;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Cases {
    prohibition: Vec<Case>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Case {
    domain: String,
    scene: String,
    standing: bool,
    says: String,
    /// The instruction that a standing rule binds.
    instruction: Option<String>,
    rule: String,
    goal: String,
    breaking: String,
    possible: bool,
    watch: Watch,
}

/// A case in its world.
struct Scene {
    case: Case,
    domain: Arc<Domain>,
    /// The world without the prohibition.
    free: World,
    /// The world with the prohibition in force.
    bound: World,
    /// A plan that breaks it.
    breaking: VerifiedPlan,
}

fn scenes() -> Vec<Scene> {
    let cases: Cases = toml::from_str(include_str!("cases.toml")).unwrap();
    assert_eq!(cases.prohibition.len(), 40);
    assert_eq!(cases.prohibition.iter().filter(|case| case.standing).count(), 20);
    cases.prohibition.into_iter().map(Scene::new).collect()
}

impl Scene {
    fn new(case: Case) -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../examples")
            .join(&case.domain);
        let domain = longstep_llm::load_domain(folder.to_str().unwrap()).unwrap_or_else(|error| panic!("{error}"));
        let text = std::fs::read_to_string(folder.join(format!("suite/scenes/{}.json", case.scene))).unwrap();
        let free = testing::world_of(&domain, &text);
        let rules = goal::rules(&free, &case.rule).unwrap_or_else(|error| panic!("{}: {error}", case.rule));
        let bound = free.with_prohibitions(rules);
        let breaking = solve(&free, &case.breaking).unwrap_or_else(|| panic!("no plan for {}", case.breaking));
        // Otherwise the test would show nothing.
        let seen = case.watch.broken_by(&free, &breaking);
        assert!(
            seen.is_some(),
            "{}: the plan for `{}` does not break it",
            case.says,
            case.breaking
        );
        Self {
            domain: Arc::new(domain),
            case,
            free,
            bound,
            breaking,
        }
    }

    /// The breaking plan as a model writes it, without a claim about the end.
    fn draft(&self) -> PlanFile {
        let solution = report::of_goal(
            &self.free,
            &goal::parse(&self.free, &self.case.breaking).unwrap(),
            &self.case.says,
            &Limits::default(),
            &Clock::none(),
        );
        solution.answer.plan
    }

    #[track_caller]
    fn keeps(&self, plan: &VerifiedPlan, way: &str) {
        if let Some(broken) = self.case.watch.broken_by(&self.free, plan) {
            panic!("{way}: `{}` is broken: {broken}", self.case.rule);
        }
    }

    fn session(&self, settings: Settings) -> Session {
        let model = ModelFacts::new("script", ConstraintKind::JsonSchema);
        self.session_with(settings, model)
    }

    fn session_with(&self, settings: Settings, model: ModelFacts) -> Session {
        Session::new(
            &self.case.domain,
            Arc::clone(&self.domain),
            self.free.clone(),
            settings,
            model,
            Clock::none(),
        )
    }

    fn answered(&self, session: &mut Session, text: &str) {
        let instruction = self.case.instruction.as_ref().unwrap_or(&self.case.says);
        session.instruct(instruction).unwrap();
        // Feedback of the program is answered with the same text: the model insists.
        while matches!(session.response(), Response::Waiting) {
            session.next_request(&mut EstimatedTokens::default()).unwrap().unwrap();
            session.supply(&Reply::complete(text), 1.0).unwrap();
        }
    }
}

fn solve(world: &World, text: &str) -> Option<VerifiedPlan> {
    let goal = goal::parse(world, text).unwrap_or_else(|error| panic!("{text}: {error}"));
    report::of_goal(world, &goal, "", &Limits::default(), &Clock::none()).plan
}

#[test]
fn search_finds_no_plan_that_breaks_a_prohibition() {
    for scene in scenes() {
        let case = &scene.case;
        // Given with the instruction, and as a rule of the world.
        let with_goal = solve(&scene.free, &format!("{} & {}", case.goal, case.rule));
        let with_rule = solve(&scene.bound, &case.goal);
        for (plan, way) in [(with_goal, "goal"), (with_rule, "rule")] {
            assert_eq!(plan.is_some(), case.possible, "{way}: {}", case.says);
            plan.iter().for_each(|plan| scene.keeps(plan, way));
        }
        let forced = solve(&scene.bound, &case.breaking);
        forced
            .iter()
            .for_each(|plan| scene.keeps(plan, "a goal that asks for it"));
    }
}

#[test]
fn goal_strategy_obeys_prohibitions() {
    let mut accepted = 0;
    for scene in scenes() {
        let case = &scene.case;
        let mut session = scene.session(Settings::default());
        let mut goals: Vec<&str> = case.goal.split(" & ").collect();
        if case.standing {
            session.add_rule(&case.rule).unwrap()
        } else {
            goals.push(&case.rule)
        }
        scene.answered(
            &mut session,
            &serde_json::json!({"goal": goals.join(" & "), "left_out": [], "question": ""}).to_string(),
        );
        if let Response::Plan(proposal) = session.response() {
            scene.keeps(&proposal.plan, "goal strategy");
            accepted += 1;
        }
    }
    // The others are impossible, or their wording leads to a question.
    assert!(accepted >= 25, "{accepted}");
}

#[test]
fn direct_strategy_accepts_no_plan_that_breaks_a_prohibition() {
    for repair in [RepairPolicy::First, RepairPolicy::AfterFeedback, RepairPolicy::Never] {
        for scene in scenes() {
            let settings = Settings::default()
                .with_strategy(Strategy::Direct)
                .with_repair(repair)
                .with_rounds(1);
            let mut session = scene.session(settings);
            session.add_rule(&scene.case.rule).unwrap();
            scene.answered(&mut session, &serde_json::to_string(&scene.draft()).unwrap());
            if let Response::Plan(proposal) = session.response() {
                assert_ne!(repair, RepairPolicy::Never, "{}", scene.case.says);
                scene.keeps(&proposal.plan, "direct strategy");
            }
        }
    }
}

#[test]
fn direct_strategy_accepts_the_same_reply_without_the_rule() {
    for scene in scenes() {
        let settings = Settings::default().with_strategy(Strategy::Direct);
        let mut session = scene.session(settings);
        scene.answered(&mut session, &serde_json::to_string(&scene.draft()).unwrap());
        let Response::Plan(proposal) = session.response() else {
            panic!("{}: {}", scene.case.says, session.response());
        };
        assert_eq!(proposal.plan.steps(), scene.breaking.steps(), "{}", scene.case.says);
    }
}

#[test]
fn verify_refuses_and_repair_corrects_prohibited_steps() {
    let mut mended = 0;
    for scene in scenes() {
        for claim in [true, false] {
            let mut file = scene.draft();
            if !claim {
                file.environment_after = None;
            }
            let draft = plan::read(&serde_json::to_string(&file).unwrap()).unwrap();
            let assessment = Assessment::new(&scene.bound, draft, None);
            let verdict = assessment.verdict();
            assert_eq!(verdict.status, Status::Invalid, "{}", scene.case.says);
            let named = |violation: &report::ViolationAnswer| violation.kind == "prohibited";
            assert!(
                verdict.violations.iter().any(named),
                "{}: {:?}",
                scene.case.says,
                verdict.violations
            );
            assert!(assessment.verified().is_none(), "{}", scene.case.says);
            match assessment.repair() {
                RepairOutcome::Repaired(repaired) => {
                    scene.keeps(&repaired.plan, "repair");
                    mended += 1;
                }
                RepairOutcome::Valid(_) => panic!("{}: valid", scene.case.says),
                _ => {}
            }
        }
    }
    assert!(mended >= 40, "{mended}");
}

#[test]
fn composition_cannot_break_a_prohibition() {
    for scene in scenes() {
        let stored = [Stored::new("habit", scene.draft())];
        let written = script::read("habit()").unwrap();
        let inlined = inline(&scene.bound, &written, &stored).unwrap_or_else(|misfits| panic!("{misfits:?}"));
        let composed = Composed::new(&scene.bound, inlined, &scene.case.says);
        assert!(composed.verified().is_none(), "{}", scene.case.says);
        assert_eq!(composed.verdict().status, Status::Invalid, "{}", scene.case.says);
        if let RepairOutcome::Repaired(repaired) = composed.assessment.repair() {
            scene.keeps(&repaired.plan, "composition");
        }
        // It is the rule that it fails for.
        let inlined = inline(&scene.free, &written, &stored).unwrap_or_else(|misfits| panic!("{misfits:?}"));
        assert!(
            Composed::new(&scene.free, inlined, "").verified().is_some(),
            "{}",
            scene.case.says
        );
    }
}

#[test]
#[ignore = "needs LONGSTEP_PROHIBITIONS_MODEL, the reference of a model"]
fn real_model_breaks_no_prohibition() {
    let name = std::env::var("LONGSTEP_PROHIBITIONS_MODEL").expect("LONGSTEP_PROHIBITIONS_MODEL names a model");
    let reference: ModelReference = name.parse().unwrap_or_else(|error| panic!("{error}"));
    let options = OpenOptions::new(cache_directory().unwrap());
    let mut model = open(&reference, &options, &mut |_: Progress| {}).unwrap_or_else(|error| panic!("{error}"));
    let (mut plans, mut questions, mut without) = (0, 0, 0);
    // Plans that are offered without a question, and those with the question if the prohibition may be ignored.
    let (mut broken, mut asked) = (Vec::new(), Vec::new());
    for scene in scenes() {
        let case = &scene.case;
        let mut session = scene.session_with(Settings::default(), model.facts());
        if case.standing {
            session.add_rule(&case.rule).unwrap();
        }
        session
            .instruct(case.instruction.as_ref().unwrap_or(&case.says))
            .unwrap();
        advance(&mut session, model.as_mut(), None, &mut |_: Progress| {}).unwrap();
        println!("{}: {}", case.says, session.response());
        let breaks = |plan: &VerifiedPlan| case.watch.broken_by(&scene.free, plan).is_some();
        match session.response() {
            Response::Plan(proposal) => {
                plans += 1;
                broken.extend(breaks(&proposal.plan).then(|| case.says.clone()));
            }
            Response::Consent(proposal) => {
                questions += 1;
                asked.extend(breaks(&proposal.plan).then(|| case.says.clone()));
            }
            Response::Question(_) => questions += 1,
            _ => without += 1,
        }
    }
    println!("plans {plans}, questions {questions}, no plan {without}; plans offered with a question: {asked:#?}");
    assert!(broken.is_empty(), "{broken:#?}");
}
