//! Variables of prompt templates: the domain's actions, states and rules in words.

use minijinja::{Value, context};

use super::forms::{acts, has_trees, senses};
use crate::model::{Action, Condition, Domain, NumberTest, NumericExpression, RuleTime, Slot, Term, TypeId, When};

/// Builds the variables of a template:
///
/// - `name`, `about`;
/// - `actions` (`call`, `means`, `needs`, `object`, `hidden`, `tells`);
/// - `states` and `properties` (`word`, `means`), `rules` (`name`, `when`, `says`);
/// - `objects_matter`: calls omit the handled object; `something_hidden`: calls omit other arguments;
/// - `trees`: plans are trees; `senses`: with branches and loops; `asked`: an example of a condition on a sensed state;
/// - `acts`: calls name actors, and plans can have lanes; `actors`: the actors of every environment.
pub(super) fn context(domain: &Domain) -> Value {
    let actions: Vec<Value> = domain
        .actions
        .iter()
        .map(|action| action_context(domain, action))
        .collect();
    let states: Vec<Value> = domain
        .states
        .iter()
        .map(|state| {
            let word = call(&state.word, state.parameters.iter().map(String::as_str));
            context! { word, means => &state.means }
        })
        .collect();
    let properties: Vec<Value> = domain
        .properties
        .iter()
        .map(|property| {
            let sentences = property.literals.iter().map(|literal| {
                let words = domain.words(literal.atom.predicate);
                let template = if literal.holds { &words.says } else { &words.denies };
                template.fill(|_| "the thing".to_owned())
            });
            context! { word => &property.word, means => sentences.collect::<Vec<_>>().join(", and ") }
        })
        .collect();
    let rules: Vec<Value> = domain
        .rules
        .iter()
        .map(|rule| {
            let says = rule
                .says
                .fill(|variable| format!("<{}>", rule.variables[variable].name));
            let when = match rule.time {
                RuleTime::Start => "in every environment",
                RuleTime::Always => "at every step",
                RuleTime::End => "at the end",
                RuleTime::Tidy => "at the end, unless something else was asked for",
            };
            context! { name => &rule.name, when, says }
        })
        .collect();
    let something_hidden = domain
        .actions
        .iter()
        .any(|action| action.implicit().any(|p| action.object != Some(p)));
    let objects_matter = domain.actions.iter().any(|action| action.object.is_some());
    let sensed_condition = domain.states.iter().find(|state| {
        let mut outcomes = domain.actions.iter().flat_map(|action| &action.senses);
        outcomes.any(|outcome| outcome.predicate == state.atom.predicate)
    });
    let sensed_condition = sensed_condition.map(|state| {
        let things = std::iter::once("thing").chain(state.parameters.iter().map(String::as_str));
        call(&state.word, things)
    });
    let by_whom: Vec<String> = domain
        .constants
        .iter()
        .filter(|(_, kind)| is_actor(domain, *kind))
        .map(|(name, _)| name.clone())
        .collect();
    context! {
        name => &domain.name,
        about => &domain.about,
        actions,
        states,
        properties,
        rules,
        objects_matter,
        something_hidden,
        trees => has_trees(domain),
        senses => senses(domain),
        asked => sensed_condition,
        acts => acts(domain),
        actors => by_whom,
    }
}

/// Returns the approximate size of the variables' texts in bytes.
pub(super) fn size(domain: &Domain) -> usize {
    let actions = domain
        .actions
        .iter()
        .map(|action| action.call.len() + action.means.len());
    let states = domain.states.iter().map(|state| state.word.len() + state.means.len());
    actions.chain(states).sum::<usize>() + domain.name.len() + domain.about.len()
}

/// Returns true if entities of this type are actors (hands, arms or robots).
fn is_actor(domain: &Domain, kind: TypeId) -> bool {
    let actor_kind = |action: &Action| action.actor.map(|actor| action.parameters[actor].kind);
    let mut kinds = domain.actions.iter().filter_map(actor_kind);
    kinds.any(|actor| domain.types.is_a(kind, actor))
}

fn call<'a>(word: &str, parameters: impl Iterator<Item = &'a str>) -> String {
    let parameters: Vec<String> = parameters
        .map(|name| format!("<{}>", name.trim_matches(['<', '>'])))
        .collect();
    format!("{word}({})", parameters.join(", "))
}

fn action_context(domain: &Domain, action: &Action) -> Value {
    let name = |parameter: usize| action.parameters[parameter].name.clone();
    let hidden = action.implicit().filter(|parameter| action.object != Some(*parameter));
    let object = action.object.filter(|parameter| !action.explicit.contains(parameter));
    let names = action
        .parameters
        .iter()
        .map(|parameter| format!("<{}>", parameter.name))
        .collect::<Vec<_>>();
    let tells = action.senses.iter().map(|outcome| {
        let says = &domain.words(outcome.predicate).says;
        says.fill(|place| called(domain, outcome.terms[place], &names))
    });
    context! {
        call => call(&action.call, action.explicit.iter().map(|parameter| action.parameters[*parameter].name.as_str())),
        means => &action.means,
        needs => needs(domain, &action.precondition, &names),
        object => object.map(name),
        hidden => hidden.map(name).collect::<Vec<_>>(),
        tells => tells.collect::<Vec<_>>(),
    }
}

/// Splits a condition into short sentences that must all hold. `names` are the names of the variables, by slot.
fn needs(domain: &Domain, condition: &Condition, names: &[String]) -> Vec<String> {
    // That the numbers of an effect are known goes without saying.
    let is_implied = |part: &&Condition| part.numbers().any(|test| matches!(test, NumberTest::Known(..)));
    let parts = condition.conjuncts().filter(|part| !is_implied(part));
    parts.map(|part| sentence(domain, part, names)).collect()
}

/// Writes a numeric expression.
fn number(domain: &Domain, expression: &NumericExpression, names: &[String]) -> String {
    expression.written(&|own| {
        let says = &domain.function(own.function).says;
        let sentence = says.fill(|place| called(domain, own.terms[place], names));
        if own.at != When::Now {
            format!("{sentence} at the start")
        } else {
            sentence
        }
    })
}

fn sentence(domain: &Domain, condition: &Condition, names: &[String]) -> String {
    let all = |parts: &[Condition], joint: &str| -> String {
        let parts: Vec<String> = parts.iter().map(|part| sentence(domain, part, names)).collect();
        parts.join(joint)
    };
    match condition {
        Condition::And(parts) => all(parts, " and "),
        Condition::Or(parts) => {
            // An implication of PDDL arrives as a disjunction with a negated part; the consequent may be negated too.
            let (mut unless, mut then): (Vec<Condition>, Vec<Condition>) = parts.iter().cloned().partition(denies);
            if then.is_empty() {
                then.extend(unless.pop());
            }
            if unless.is_empty() || then.is_empty() {
                return all(parts, " or ");
            }
            let given: Vec<Condition> = unless.into_iter().map(Condition::negated).collect();
            format!("if {}, then {}", all(&given, " and "), all(&then, " or "))
        }
        Condition::Forall(slot, kind, inner) => quantified(domain, (*slot, *kind), inner, names, true),
        Condition::Exists(slot, kind, inner) => quantified(domain, (*slot, *kind), inner, names, false),
        Condition::Atom { atom, holds, at } => {
            let words = domain.words(atom.predicate);
            let template = if *holds { &words.says } else { &words.denies };
            let sentence = template.fill(|place| called(domain, atom.terms[place], names));
            if *at != When::Now {
                format!("{sentence} at the start")
            } else {
                sentence
            }
        }
        Condition::Equal { left, right, holds } => {
            let (left, right) = (called(domain, *left, names), called(domain, *right, names));
            let relation = if *holds { "is" } else { "is not" };
            format!("{left} {relation} {right}")
        }
        Condition::Number(test) => match test {
            NumberTest::Compare(left, comparison, right) => {
                let (left, right) = (number(domain, left, names), number(domain, right, names));
                format!("{left} {comparison} {right}")
            }
            NumberTest::Known(expression, true) => format!("{} is known", number(domain, expression, names)),
            NumberTest::Known(expression, false) => format!("{} is not known", number(domain, expression, names)),
        },
    }
}

/// Returns true if the condition is a negated literal, or a disjunction of such literals.
fn denies(condition: &Condition) -> bool {
    match condition {
        Condition::Atom { holds, .. } | Condition::Equal { holds, .. } => !holds,
        Condition::Or(parts) => parts.iter().all(denies),
        _ => false,
    }
}

fn called(domain: &Domain, term: Term, names: &[String]) -> String {
    match term {
        Term::Variable(slot) => names[slot].clone(),
        Term::Constant(entity) => domain.constants[entity.index()].0.clone(),
    }
}

fn quantified(
    domain: &Domain,
    (slot, kind): (Slot, TypeId),
    inner: &Condition,
    names: &[String],
    every: bool,
) -> String {
    debug_assert_eq!(slot, names.len());
    let kind = domain.types.name(kind);
    let within = |name: String, inner: &Condition| sentence(domain, inner, &[names, &[name]].concat());
    // A single literal reads well without a variable: "the hand holds no item".
    match inner {
        Condition::Atom { holds: false, .. } if every => within(format!("no {kind}"), &inner.clone().negated()),
        Condition::Atom { holds: true, .. } => {
            let which = if every { "every" } else { "some" };
            within(format!("{which} {kind}"), inner)
        }
        _ => {
            let around = names.iter().filter(|name| !name.starts_with('<')).count();
            let letter = char::from(b'X' + (around % 3) as u8);
            let which = if every { "every" } else { "some" };
            format!("for {which} {kind} {letter}: {}", within(letter.to_string(), inner))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::shipped;

    #[track_caller]
    fn check(domain: &str, call: &str, expected: &[&str]) {
        let domain = shipped(domain).unwrap().unwrap();
        let action = domain.actions.iter().find(|action| action.call == call).unwrap();
        let names = action
            .parameters
            .iter()
            .map(|parameter| format!("<{}>", parameter.name));
        assert_eq!(
            needs(&domain, &action.precondition, &names.collect::<Vec<_>>()),
            expected
        );
    }

    #[test]
    fn preconditions_read_as_sentences() {
        check("virtualhome", "Walktowards", &[]);
        check(
            "virtualhome",
            "Grab",
            &[
                "<item> is within reach",
                "no item is in hand",
                "for every thing X: if <item> is in X, then X is not closed",
            ],
        );
        check(
            "virtualhome",
            "Put",
            &[
                "<item> is in hand",
                "<place> is within reach",
                "<item> is not <place>",
                "if <place> gets hot on top and <place> is switched on, then <item> is made to stand on a stove",
            ],
        );
        check(
            "household",
            "move_hand",
            &["for every item X: if the hand holds X, then X is lifted"],
        );
        check(
            "household",
            "release_object",
            &[
                "the hand holds <item>",
                "if <item> is lifted, then for some thing X: things can be dropped into X and the hand is at X",
                "for every thing X: if X is upright, then <item> is not on X",
            ],
        );
    }
}
