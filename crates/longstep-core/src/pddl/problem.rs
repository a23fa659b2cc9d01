//! The parser of PDDL problems: objects, initial state and goal.

use indexmap::IndexMap;
use rustc_hash::FxHashMap;

use crate::call::Call;
use crate::diagnostic::{Diagnostic, Diagnostics, Position};
use crate::domain::pddl::{Dialect, Reader, Semantics, foreign};
use crate::domain::sexpr::Expression;
use crate::model::{
    Arithmetic, Domain, ENTITY_LIMIT, Entity, EntityId, Environment, Fact, Function, Number, Predicate, PredicateId,
    State, Words, World,
};
use crate::search::Wanted;
use crate::verify::Purpose;

/// A planning task: a world and a goal.
#[derive(Debug, Clone)]
pub struct Problem {
    /// The name.
    pub name: String,
    /// The objects and the initial state. The identifier of an entity is the name of the object.
    pub world: World,
    /// The goal, as conditions that must all hold at the end.
    pub wanted: Vec<Wanted>,
    /// What was left out or read in another way than it is written.
    pub notes: Vec<Diagnostic>,
}

impl Problem {
    /// Returns the purpose of a plan for the problem: its goal.
    pub fn purpose(&self) -> Purpose {
        Purpose {
            wanted: self.wanted.clone(),
            ..Purpose::default()
        }
    }
}

/// Parses a problem for the domain.
///
/// `file` is the name of the text in diagnostics. As most planners allow, a fact may occur twice, and arguments may
/// have any type.
///
/// # Errors
///
/// All errors with their positions: names that are undeclared or declared twice, wrong numbers of arguments, unknown
/// sections, a problem for another domain.
pub fn read_problem(domain: &Domain, file: &str, text: &str) -> Result<Problem, Diagnostics> {
    let mut findings = Vec::new();
    let problem = match foreign::read_problem(file, text) {
        Ok(own) => read(domain, file, &own.expressions, &mut findings).map(|mut problem| {
            problem.notes.extend(own.notes);
            problem
        }),
        Err(finding) => {
            findings.push(finding);
            None
        }
    };
    match problem {
        Some(problem) if findings.is_empty() => Ok(problem),
        _ => Err(Diagnostics::sorted(findings)),
    }
}

const SECTIONS: [&str; 6] = [":domain", ":requirements", ":objects", ":init", ":goal", ":metric"];

fn read(domain: &Domain, file: &str, expressions: &[Expression], findings: &mut Vec<Diagnostic>) -> Option<Problem> {
    let top = Position { line: 1, column: 1 };
    let mut reader = Reader {
        file,
        base: top,
        dialect: Dialect::Standard,
        findings,
    };
    let Some((define, sections)) = expressions
        .first()
        .and_then(|first| Some((first, first.tail_of("define")?)))
    else {
        reader.report(top, "no `(define (problem NAME) ...)`");
        return None;
    };
    for extra in &expressions[1..] {
        reader.report(extra.position, "something follows the problem's end");
    }
    let name = match sections.first().and_then(|section| section.tail_of("problem")) {
        Some([name]) if name.word().is_some() => name.word().unwrap_or_default().to_owned(),
        _ => {
            reader.report(define.position, "the problem has no name: expected `(problem NAME)`");
            String::new()
        }
    };
    for section in sections.iter().skip(1) {
        let head = section.list().and_then(|items| items.first()?.word()).unwrap_or("?");
        if !SECTIONS.contains(&head) {
            let known = SECTIONS.join(", ");
            reader.report(
                section.position,
                format!("`{head}` is not supported here; known sections are {known}"),
            );
        }
    }
    let of = |head: &'static str| sections.iter().filter_map(move |s| Some((s, s.tail_of(head)?)));
    for (section, items) in of(":domain") {
        let word = items.first().and_then(Expression::word).unwrap_or("?");
        if word != domain.pddl_name {
            let message = format!(
                "this problem is for the domain `{word}`, not for `{}`",
                domain.pddl_name
            );
            reader.report(section.position, message);
            // Most names in it would be unknown.
            return None;
        }
    }
    let mut names = Semantics {
        types: domain.types.clone(),
        constants: domain.constants.clone(),
        predicates: domain.predicates.clone(),
        functions: domain.functions.iter().map(declared).collect(),
        costs: domain.has_costs(),
        ..Semantics::default()
    };
    // A hash map, since there are many more facts than names.
    let mut numbers: FxHashMap<String, EntityId> = FxHashMap::default();
    for (index, (name, _)) in names.constants.iter().enumerate() {
        numbers.insert(name.clone(), EntityId::new(index));
    }
    for (section, items) in of(":objects") {
        if names.constants.len() + items.len() > ENTITY_LIMIT {
            reader.report(section.position, format!("more than {ENTITY_LIMIT} objects"));
            return None;
        }
        for (name, kind, position) in reader.typed_list(items, &names.types) {
            // Some problems declare the constants of their domain again.
            if domain.constants.iter().any(|own| *own == (name.clone(), kind)) {
                continue;
            }
            if numbers
                .insert(name.clone(), EntityId::new(names.constants.len()))
                .is_some()
            {
                reader.report(position, format!("the object `{name}` is declared twice"));
            }
            names.constants.push((name, kind));
        }
    }
    let mut state = State::default();
    let predicates: FxHashMap<&str, (PredicateId, usize)> = domain
        .predicates
        .iter()
        .enumerate()
        .map(|(index, p)| (p.name.as_str(), (PredicateId::new(index), p.parameters.len())))
        .collect();
    for (_, items) in of(":init") {
        for item in items {
            if let Some(fact) = known_fact(item, &predicates, &numbers) {
                state.set(fact, true);
                continue;
            }
            if let Some([fluent, number]) = item.tail_of("=") {
                initial_number(&mut reader, &names, &mut state, fluent, number);
                continue;
            }
            // A negated fact has no effect, but its names must be valid.
            let atom = match item.tail_of("not") {
                Some([inner]) => inner,
                _ => item,
            };
            reader.atom(atom, &Vec::new(), &names);
        }
    }
    let mut notes = Vec::new();
    for (section, items) in of(":metric") {
        let is_cost = |items: &[Expression]| matches!(items, [word, cost] if word.word() == Some("minimize") && cost.tail_of("total-cost") == Some(&[]));
        if !is_cost(items) {
            let message = match domain.has_costs() {
                true => "this metric is left out: a plan costs what its steps add to `(total-cost)`",
                false => "this metric is left out: a plan costs as much as it has steps",
            };
            notes.push(Diagnostic::at(file, section.position, message));
        }
    }
    let mut wanted = Vec::new();
    let mut goals = 0;
    for (section, items) in of(":goal") {
        goals += 1;
        if let [goal] = items {
            let goal = reader.condition(goal, &mut Vec::new(), &names);
            wanted.extend(goal.conjuncts().map(|condition| Wanted {
                condition: condition.clone(),
                bindings: Vec::new(),
            }));
        } else {
            reader.report(section.position, "expected one condition");
        }
    }
    if goals != 1 {
        reader.report(define.position, format!("a problem has one goal, not {goals}"));
    }
    let entity = |(name, kind): &(String, _)| Entity {
        identifier: name.clone(),
        kind: *kind,
        name: name.clone(),
        names: vec![name.clone()],
        is_value: false,
    };
    let entities: Vec<Entity> = names.constants.iter().map(entity).collect();
    let environment = environment(domain, &entities, &state);
    let mut world = World::new(domain, entities, environment);
    world.state = state;
    Some(Problem {
        name,
        world,
        wanted,
        notes,
    })
}

/// Returns the declaration of a numeric function.
fn declared(function: &Function) -> Predicate {
    Predicate {
        name: function.name.clone(),
        parameters: function.parameters.clone(),
    }
}

/// Reads `(= (function argument ...) number)`; reports errors, and a fluent with two numbers. The cost begins at zero.
fn initial_number(
    reader: &mut Reader<'_>,
    names: &Semantics,
    state: &mut State,
    fluent: &Expression,
    number: &Expression,
) {
    let value = match reader.number(number, &Vec::new(), names) {
        Some(Arithmetic::Constant(value)) => value,
        Some(_) => return reader.report(number.position, "expected a number"),
        None => return,
    };
    if fluent.tail_of("total-cost") == Some(&[]) {
        if value != Number::ZERO {
            reader.report(number.position, "`(total-cost)` begins at 0");
        }
        return;
    }
    let Some(application) = reader.application(fluent, &Vec::new(), names) else {
        return;
    };
    let fluent = application.ground(&[]);
    if state.number(fluent).is_some_and(|known| known != value) {
        reader.report(number.position, "this fluent has another number already");
    }
    state.set_number(fluent, value);
}

/// Returns the fact if all its names are known and its number of arguments is right.
fn known_fact(
    item: &Expression,
    predicates: &FxHashMap<&str, (PredicateId, usize)>,
    numbers: &FxHashMap<String, EntityId>,
) -> Option<Fact> {
    let (head, arguments) = item.list()?.split_first()?;
    let (predicate, arity) = *predicates.get(head.word()?)?;
    if arguments.len() != arity {
        return None;
    }
    let mut bound = Vec::with_capacity(arity);
    for argument in arguments {
        bound.push(*numbers.get(argument.word()?)?);
    }
    Some(Fact::new(predicate, bound))
}

/// Writes the state as an environment; facts that have no arguments only in a domain with numbers.
fn environment(domain: &Domain, entities: &[Entity], state: &State) -> Environment {
    let mut states: IndexMap<String, Vec<String>> = IndexMap::new();
    let name = |entity: EntityId| entities[entity.index()].identifier.clone();
    for fact in state.iter() {
        let predicate = domain.predicate(fact.predicate());
        if predicate.parameters.is_empty() {
            continue;
        }
        let call = Call {
            name: predicate.name.clone(),
            arguments: (1..predicate.parameters.len())
                .map(|place| name(fact.argument(place)))
                .collect(),
        };
        states.entry(name(fact.argument(0))).or_default().push(call.to_string());
    }
    // A domain with numbers has statements without a subject; other environments leave them out.
    let mut facts: Vec<String> = Vec::new();
    if !domain.functions.is_empty() {
        let alone = |fact: &Fact| domain.predicate(fact.predicate()).parameters.is_empty();
        let facts_alone = state.iter().filter(alone);
        facts.extend(facts_alone.map(|fact| domain.predicate(fact.predicate()).name.clone()));
    }
    for (fluent, number) in state.numbers() {
        let word = &domain.function(fluent.function()).word;
        let places = 1..domain.function(fluent.function()).parameters.len();
        let others = places.map(|place| name(fluent.argument(place)));
        let call = Call {
            name: word.clone(),
            arguments: others.chain([number.to_string()]).collect(),
        };
        match domain.arguments_of(*fluent).next() {
            Some(subject) => states.entry(name(subject)).or_default().push(call.to_string()),
            None => facts.push(call.to_string()),
        }
    }
    Environment {
        facts: (!domain.functions.is_empty()).then_some(facts),
        objects: entities.iter().map(|entity| entity.identifier.clone()).collect(),
        object_states: states
            .into_iter()
            .map(|(name, words)| (name, Words::Many(words)))
            .collect(),
        ..Environment::default()
    }
}
