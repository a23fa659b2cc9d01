//! Properties that hold of every plan that somebody could write.

use longstep::domain::Domain;
use longstep::report::Assessment;
use longstep_core::effort;
use longstep_core::environment::World;
use longstep_core::plan::{Draft, Node, Plan, PlanFile, Resolved, TaskCohesion, Written, resolve, script};
use longstep_core::repair::RepairOutcome;
use longstep_core::verify::{Purpose, Violation, bind_tree, check};

use crate::scenes::Scene;

/// Units of work for one input, a small part of what a command has, so that a second has many inputs.
const UNITS: u64 = effort::OPERATION / 400;

/// Drafts with more steps than this are not repaired.
const REPAIRED: usize = 5;

/// Binds and verifies a plan, repairs it where that is asked for, and checks what comes of each against the others.
///
/// One repair looks at up to 12,000 states and takes as long as a thousand bindings, so it is asked for rarely.
pub fn check_plan(scene: &Scene, file: PlanFile, with_repair: bool) {
    let Scene { domain, world } = scene;
    let draft = Draft {
        file,
        leniencies: Vec::new(),
    };
    let assessment = Assessment::new(world, draft, None);
    let spent = effort::within(UNITS, || check_as_written(domain, world, &assessment));
    if !with_repair || spent.exhausted || assessment.resolved.steps.len() > REPAIRED {
        return;
    }
    let repair = effort::within(UNITS, || assessment.repair());
    if repair.exhausted {
        return;
    }
    match repair.result {
        RepairOutcome::Valid(plan) => check_again(world, plan.plan(), &assessment.purpose),
        RepairOutcome::Repaired(repaired) => {
            // What was given up is no longer claimed, and claims of steps go with the steps of the draft.
            let purpose = Purpose {
                claim: None,
                step_claims: Vec::new(),
                ..assessment.purpose.clone()
            };
            check_again(world, repaired.plan.plan(), &purpose);
        }
        RepairOutcome::Unclear { why } | RepairOutcome::GaveUp { why, .. } => assert!(!why.is_empty()),
        RepairOutcome::ProvenUnsolvable { .. } => {}
    }
    drop(assessment.repaired());
}

fn check_as_written(domain: &Domain, world: &World, assessment: &Assessment<'_>) {
    let answer = assessment.verdict();
    let is_work = |violation: &Violation| matches!(violation, Violation::TooMuchWork);
    match bind_tree(world, &assessment.resolved, assessment.purpose.claim.as_ref()) {
        // The budget of the input can end between the verdict and this second binding.
        Err(issues) if issues.iter().any(is_work) => {}
        Err(issues) => {
            assert!(!issues.is_empty(), "a plan is refused with a reason");
            assert_ne!(answer.status, longstep::report::Status::Verified);
            for issue in issues {
                assert!(!issue.message(world, &[], None).is_empty());
            }
        }
        Ok((plan, assumptions)) => {
            check_bound(domain, world, &assessment.resolved, &plan);
            assumptions.iter().for_each(|open| drop(open.message(world)));
            let report = check(world, plan.clone(), &assessment.purpose);
            assert!(!report.endings.is_empty());
            if report.violations.iter().any(is_work) {
                return;
            }
            for violation in &report.violations {
                assert!(!violation.message(world, plan.steps(), None).is_empty());
            }
            let is_valid = report.violations.is_empty();
            if assessment.question().is_none() {
                assert_eq!(
                    answer.status == longstep::report::Status::Verified,
                    is_valid,
                    "{:?}",
                    report.violations
                );
            }
            if is_valid {
                check_again(world, &plan, &assessment.purpose);
            }
        }
    }
}

/// A bound plan has every step of the draft, with the arguments that were given, each of its parameter's type.
fn check_bound(domain: &Domain, world: &World, resolved: &Resolved, plan: &Plan) {
    assert_eq!(plan.steps().len(), resolved.steps.len());
    assert_eq!(plan.body(), resolved.body);
    for (step, draft) in plan.steps().iter().zip(&resolved.steps) {
        let draft = draft.as_ref().expect("a draft with unknown steps is not bound");
        assert_eq!(step.action, draft.action);
        let parameters = &domain.action(step.action).parameters;
        assert_eq!(step.arguments.len(), parameters.len());
        for ((argument, given), parameter) in step.arguments.iter().zip(&draft.arguments).zip(parameters) {
            assert!(given.is_none_or(|given| given == *argument), "a given argument is kept");
            assert!(
                world.of_kind(parameter.kind).contains(argument),
                "an argument has its type"
            );
        }
    }
}

/// A plan that was called valid is valid once more, and also after it was written as a script and read again.
fn check_again(world: &World, plan: &Plan, purpose: &Purpose) {
    let spent = effort::within(u64::MAX, || check(world, plan.clone(), purpose));
    if spent.result.violations.contains(&Violation::TooMuchWork) {
        return;
    }
    assert!(spent.result.violations.is_empty(), "{:?}", spent.result.violations);
    let text = script::write(&Written::of_plan(world, plan));
    let written = script::read(&text).expect("what was written can be read");
    let resolved = resolve(world, &TaskCohesion::from_written(written));
    assert!(resolved.issues.is_empty(), "{text}\n{:?}", resolved.issues);
    let again = match bind_tree(world, &resolved, None) {
        Ok((again, _)) => again,
        Err(issues) if issues.contains(&Violation::TooMuchWork) => return,
        Err(issues) => panic!("{text}\n{issues:?}"),
    };
    // A list of steps stays one, without the remarks between them.
    let flat = |node: &Node| matches!(node, Node::Step(_) | Node::Remark(_));
    if !plan.body().iter().all(flat) {
        assert_eq!(again.body(), plan.body(), "{text}");
    }
    for (one, other) in again.steps().iter().zip(plan.steps()) {
        assert_eq!((one.action, &one.arguments), (other.action, &other.arguments), "{text}");
    }
}
