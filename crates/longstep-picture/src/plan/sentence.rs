//! Sentences about steps and conditions, for people.

use std::collections::BTreeSet;

use longstep_core::model::{
    Change, Changes, Domain, EntityId, Fact, NumberChange, Voice, World, fact_text, fluent_text, subject_of,
};
use longstep_core::plan::{Plan, Test};

use crate::cause::Use;
use crate::walk::possible_outcomes;

/// Returns the changes of a step as sentences: what begins to hold, then what no longer holds of entities about which
/// nothing begins to hold. Events are left out unless nothing else changes.
pub(super) fn changes(world: &World, changes: &Changes) -> Vec<String> {
    let domain = world.domain();
    let lasting = changes.facts.iter();
    let lasting = lasting.filter(|change| !domain.words(change.fact.predicate()).event);
    let (new, old): (Vec<Change>, Vec<Change>) = lasting.partition(|change| change.holds);
    // "The fridge is open" says that it is not closed, and "the robot is at the dock" that it is not elsewhere.
    let is_replaced = |change: &Change| {
        new.iter().any(|own| {
            let same_predicate = own.fact.predicate() == change.fact.predicate();
            let subject = subject(domain, own.fact);
            subject.is_some() && subject == self::subject(domain, change.fact)
                || same_predicate && !domain.is_relation(own.fact)
        })
    };
    let facts = new.iter().chain(old.iter().filter(|change| !is_replaced(change)));
    let mut sentences: Vec<String> = facts
        .map(|change| fact_text(world, change.fact, change.holds))
        .collect();
    let number = |change: &NumberChange| {
        let after = Voice::Person.number(world, change.fluent, change.after);
        format!("{} becomes {after}", fluent_text(world, change.fluent))
    };
    sentences.extend(changes.numbers.iter().map(number));
    if sentences.is_empty() {
        let events = changes.facts.iter().filter(|change| change.holds);
        sentences.extend(events.map(|change| fact_text(world, change.fact, true)));
    }
    sentences
}

/// Returns the entity that a fact is about; none for a fact without arguments.
fn subject(domain: &Domain, fact: Fact) -> Option<EntityId> {
    domain.arguments(fact).next().map(|_| subject_of(domain, fact))
}

/// Returns the possible outcomes of a sensing step as a sentence.
pub(super) fn sensing(world: &World, outcomes: &[Fact]) -> String {
    let outcomes: Vec<String> = outcomes.iter().map(|fact| fact_text(world, *fact, true)).collect();
    format!("it becomes known whether {}", outcomes.join(" or "))
}

/// Later steps in a reason.
const LATER: usize = 4;

/// Returns the most telling use of a step as a sentence; none for a step without use. Facts that the reader knows are left
/// out.
pub(super) fn reason(world: &World, goals: &[String], uses: &BTreeSet<Use>, known: &[String]) -> Option<String> {
    let with = |text: String, fact: &String| {
        let is_known = fact.is_empty() || known.contains(fact);
        if is_known { text } else { format!("{text}: {fact}") }
    };
    Some(match uses.first()? {
        Use::Goal(index) => match goals.get(*index) {
            Some(goal) => format!("for the goal: {goal}"),
            None => "for the goal".to_owned(),
        },
        Use::Stage => "for the order of the goal".to_owned(),
        Use::Step(step, fact) => with(format!("needed for {}", later_steps(uses, step.index())), fact),
        Use::Test(fact) => with("decides how the plan goes on".to_owned(), fact),
        Use::Rule(number, bindings) => {
            let says = &world.domain().rules[*number].says;
            format!("for a rule: {}", says.fill(|slot| world.with_article(bindings[slot])))
        }
        Use::End(fact) => with("for the result".to_owned(), fact),
    })
}

/// Writes the numbers of the later steps that need a step.
fn later_steps(uses: &BTreeSet<Use>, first: usize) -> String {
    let numbers: BTreeSet<usize> = uses
        .iter()
        .filter_map(|used| match used {
            Use::Step(step, _) => Some(step.index() + 1),
            _ => None,
        })
        .collect();
    if numbers.len() == 1 {
        return format!("step {}", first + 1);
    }
    let shown: Vec<String> = numbers.iter().take(LATER).map(usize::to_string).collect();
    match numbers.len() - shown.len() {
        0 => format!("steps {}", shown.join(", ")),
        more => format!("steps {} and {more} more", shown.join(", ")),
    }
}

/// Writes a condition as a sentence; `holds` is false for its negation.
pub(super) fn condition(world: &World, plan: &Plan, test: &Test, holds: bool) -> String {
    match test {
        Test::Sense(step) => {
            let outcomes = possible_outcomes(world, plan.step(*step));
            let taken = |fact: &&Fact| (Some(*fact) == outcomes.first()) == holds;
            either(world, outcomes.iter().filter(taken))
        }
        // Of a sensed fact, another outcome is known if it does not hold.
        Test::Holds(fact) if !holds && world.domain().is_sensed(fact.predicate()) => {
            let outcomes = world.domain().outcomes(*fact);
            either(world, outcomes.iter().filter(|other| *other != fact))
        }
        Test::Holds(fact) => fact_text(world, *fact, holds),
        Test::Not(inner) => condition(world, plan, inner, !holds),
        // The negation of a conjunction is a disjunction of negations.
        Test::All(parts) => joined(world, plan, parts, holds, if holds { " and " } else { " or " }),
        Test::Any(parts) => joined(world, plan, parts, holds, if holds { " or " } else { " and " }),
    }
}

/// Writes that one of the facts holds.
fn either<'f>(world: &World, facts: impl Iterator<Item = &'f Fact>) -> String {
    let sentences: Vec<String> = facts.map(|fact| fact_text(world, *fact, true)).collect();
    sentences.join(" or ")
}

fn joined(world: &World, plan: &Plan, parts: &[Test], holds: bool, word: &str) -> String {
    let sentence = |part: &Test| {
        let text = condition(world, plan, part, holds);
        let is_compound = matches!(part, Test::All(_) | Test::Any(_));
        if is_compound && parts.len() > 1 {
            format!("({text})")
        } else {
            text
        }
    };
    parts.iter().map(sentence).collect::<Vec<_>>().join(word)
}
