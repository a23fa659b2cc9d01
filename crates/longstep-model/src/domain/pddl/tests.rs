use super::*;
use crate::domain::Term;

#[track_caller]
fn check(text: &str, expected: &[&str]) {
    let mut findings = Vec::new();
    read("domain.pddl", text, Dialect::Longstep, &mut findings);
    let found: Vec<String> = findings.iter().map(ToString::to_string).collect();
    assert_eq!(found, expected);
}

#[test]
fn a_whole_domain_reads_without_findings() {
    check(
        "(define (domain d) (:requirements :adl) (:types cup - thing thing)
              (:constants home - thing) (:predicates (at ?x - thing) (full ?c - cup))
              (:action fill :parameters (?c - cup)
                :precondition (and (at home) (not (full ?c)) (forall (?o - cup) (imply (full ?o) (= ?o ?c))))
                :effect (and (full ?c) (forall (?t - thing) (when (at ?t) (not (at ?t)))))))",
        &[],
    );
}

#[test]
fn variables_of_an_effect_come_before_those_of_the_condition_around_it() {
    let text = "(define (domain d) (:types cup) (:predicates (full ?c - cup) (seen ?c - cup))
            (:action spill :parameters (?p - cup) :precondition (and)
              :effect (when (forall (?v - cup) (full ?v)) (forall (?w - cup) (when (seen ?w) (not (full ?w)))))))";
    let mut findings = Vec::new();
    let read = read("domain.pddl", text, Dialect::Longstep, &mut findings);
    assert!(findings.is_empty(), "{findings:?}");
    let effect = &read.actions[0].effects[0];
    assert_eq!(effect.forall.iter().map(|(slot, _)| *slot).collect::<Vec<_>>(), [1]);
    let Condition::And(parts) = &effect.condition else {
        panic!("{effect:?}")
    };
    let Condition::Forall(slot, _, inner) = &parts[0] else {
        panic!("{effect:?}")
    };
    assert_eq!(*slot, 2);
    let is_about = |condition: &Condition, slot: usize| match condition {
        Condition::Atom { atom, .. } => atom.terms == [Term::Variable(slot)],
        _ => false,
    };
    assert!(is_about(inner, 2) && is_about(&parts[1], 1), "{effect:?}");
}

#[test]
fn domain_reader_reports_all_mistakes_at_once() {
    check(
        "(define (domain d) (:types cup)\n (:predicates (full ?c - cup))\n (:action fill :parameters (?c - cop)\n  :precondition (ful ?c)\n  :effect (full ?d)))",
        &[
            "domain.pddl:3:34: unknown type `cop`\n  hint: did you mean `cup`?",
            "domain.pddl:4:18: unknown predicate `ful`\n  hint: did you mean `full`?",
            "domain.pddl:5:17: unknown variable `d`\n  hint: did you mean `c`?",
        ],
    );
}

#[test]
fn domain_reader_resolves_either_to_the_parent_type() {
    let text = |parameter: &str| {
        format!(
            "(define (domain d) (:types person plane - mover van - object) (:predicates (at ?x - (either person van)))
(:action a :parameters (?x - {parameter}) :precondition (at ?x) :effect (not (at ?x))))"
        )
    };
    check(&text("(either plane person)"), &[]);
    check(&text("(either person)"), &[]);
    check(&text("(either person van)"), &[]);
    check(
        &text("person").replace("(:predicates", "(:constants x - (either person van)) (:predicates"),
        &[
            "domain.pddl:1:79: an object has one type, and `(either ...)` names some of a parent's; `object` would also \
             admit `plane`\n  hint: write the one type that the object has",
        ],
    );
    check(
        &text("(either person vann)"),
        &["domain.pddl:2:45: unknown type `vann`\n  hint: did you mean `van`?"],
    );
}

#[test]
fn domain_reader_rejects_unsupported_sections_and_requirements() {
    check(
        "(define (domain d) (:requirements :durative-actions) (:axiom (cost)))",
        &[
            "domain.pddl:1:54: `:axiom` is not supported here; known sections are :requirements, :types, :constants, \
             :predicates, :functions, :derived, :action\n  hint: write it as `(:derived (predicate ?x - type) CONDITION)`",
            "domain.pddl:1:35: the requirement `:durative-actions` is not supported\n  hint: remove it, and what it is for",
        ],
    );
}

#[test]
fn wrong_counts_and_types_are_told() {
    check(
        "(define (domain d) (:types cup lid) (:predicates (full ?c - cup))
(:action a :parameters (?c - cup ?l - lid) :precondition (and (full ?c ?c) (full ?l)) :effect (not)))",
        &[
            "domain.pddl:2:63: `full` takes 1 argument(s), not 2\n  hint: it is declared as `(full ?c - cup)`",
            "domain.pddl:2:82: `full` takes a cup here, and this is a lid\n  hint: use a cup, or declare a wider type for the argument of `full`",
            "domain.pddl:2:95: `not` has the wrong number of parts\n  hint: write `(not (predicate argument ...))`",
        ],
    );
}
