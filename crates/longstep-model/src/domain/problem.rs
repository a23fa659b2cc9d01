//! The parser of PDDL problems: objects, initial state and goal.

use indexmap::IndexMap;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::call::Call;
use crate::diagnostic::{Diagnostic, Diagnostics, Position, nearest};
use crate::domain::pddl::{Dialect, Reader, Semantics, foreign};
use crate::domain::sexpr::Expression;
use crate::model::{
    Action, Application, Arithmetic, Condition, Domain, ENTITY_LIMIT, Entity, EntityId, Environment, Fact, Function,
    FunctionId, Number, NumberChangeKind, NumberTest, Predicate, PredicateId, State, Wanted, When, Words, World,
};

/// A planning task: a world and a goal.
#[derive(Debug, Clone)]
pub struct Problem {
    /// The name.
    pub name: String,
    /// The objects and the initial state. The identifier of an entity is the name of the object.
    pub world: World,
    /// The goal, as conditions that must all hold at the end.
    pub wanted: Vec<Wanted>,
    /// Notes on the parts that were left out or read in another way than they are written.
    pub notes: Vec<Diagnostic>,
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
    let (mut problem, goals) = read_world(domain, file, text)?;
    match goals {
        Goals::One => Ok(problem),
        Goals::None(position) => {
            let finding = Diagnostic::at(file, position, "the problem has no goal");
            Err(Diagnostics(vec![
                finding.hint("add `(:goal (and (predicate object ...) ...))`"),
            ]))
        }
        Goals::Empty(position) => {
            problem.notes.push(Diagnostic::at(
                file,
                position,
                "the goal is empty, so it holds from the start",
            ));
            Ok(problem)
        }
    }
}

/// Parses a problem as [`read_problem`] does, for its objects and its initial state: the goal may be missing.
///
/// # Errors
///
/// As those of [`read_problem`], without those about a missing goal.
pub fn read_start(domain: &Domain, file: &str, text: &str) -> Result<Problem, Diagnostics> {
    read_world(domain, file, text).map(|(problem, _)| problem)
}

/// The goals of a problem file.
enum Goals {
    None(Position),
    Empty(Position),
    One,
}

fn read_world(domain: &Domain, file: &str, text: &str) -> Result<(Problem, Goals), Diagnostics> {
    let mut findings = Vec::new();
    let problem = match foreign::read_problem(file, text) {
        Ok(own) => read(domain, file, &own.expressions, &mut findings).map(|(mut problem, goals)| {
            problem.notes.extend(own.notes);
            (problem, goals)
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

/// Sections of other languages, with what to write in place of them.
const OTHER_SECTIONS: [(&str, &str); 5] = [
    (
        ":constraints",
        "leave it out, or write a prohibition with `--rules` for `longstep solve --goal`",
    ),
    (
        ":reveals",
        "give the facts of the start in `(:init ...)`; for facts that only sensing reveals use `senses` in `domain.toml`",
    ),
    (
        ":htn",
        "write what holds at the end as `(:goal ...)`: tasks and methods are not read",
    ),
    (
        ":tasks",
        "write what holds at the end as `(:goal ...)`: tasks and methods are not read",
    ),
    (":init-beliefs", "give the facts of the start in `(:init ...)`"),
];

fn read(
    domain: &Domain,
    file: &str,
    expressions: &[Expression],
    findings: &mut Vec<Diagnostic>,
) -> Option<(Problem, Goals)> {
    let top = Position { line: 1, column: 1 };
    let mut reader = Reader {
        file,
        base: top,
        dialect: Dialect::Standard,
        findings,
        expanded: 0,
    };
    let Some((define, sections)) = expressions
        .first()
        .and_then(|first| Some((first, first.tail_of("define")?)))
    else {
        let hint = "a problem file is one `(define (problem NAME) (:domain NAME) ...)` list";
        reader.report(top, "no `(define (problem NAME) ...)`", hint);
        return None;
    };
    for extra in &expressions[1..] {
        let hint = "remove it, or a `)` too many before it";
        reader.report(extra.position, "something follows the problem's end", hint);
    }
    let name = match sections.first().and_then(|section| section.tail_of("problem")) {
        Some([name]) if name.word().is_some() => name.word().unwrap_or_default().to_owned(),
        _ => {
            let hint = "write `(define (problem NAME) ...)`";
            reader.report(
                define.position,
                "the problem has no name: expected `(problem NAME)`",
                hint,
            );
            String::new()
        }
    };
    let mut notes = Vec::new();
    let other_domain = of_sections(sections, ":domain").find_map(|(section, items)| {
        let word = items.first().and_then(Expression::word).unwrap_or("?");
        let message = || {
            format!(
                "this problem is for the domain `{word}`, not for `{}`",
                domain.pddl_name
            )
        };
        (word != domain.pddl_name).then(|| (section.position, message()))
    });
    report_other_sections(&mut reader, sections, &mut notes);
    let mut names = names_of(domain);
    let numbers = objects(&mut reader, domain, sections, &mut names, &mut notes)?;
    let mut state = initial_state(&mut reader, domain, sections, (&names, &numbers), &mut notes);
    notes.extend(metric_notes(domain, file, sections));
    let (wanted, goals) = goal(&mut reader, sections, define, &names);
    begin_counters(domain, file, &wanted, &mut state, &mut notes);
    if let Some((position, message)) = other_domain {
        if reader.findings.is_empty() {
            notes.push(Diagnostic::at(file, position, format!("{message}; all its names fit")))
        } else {
            // One sample is enough: the names of another domain are all unknown.
            reader.findings.truncate(1);
            let hint = "give the domain of this problem with `--domain`";
            reader.report(position, message, hint);
        }
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
    let problem = Problem {
        name,
        world,
        wanted,
        notes,
    };
    Some((problem, goals))
}

/// Returns the sections with a head, and their items.
fn of_sections<'e>(
    sections: &'e [Expression],
    head: &'static str,
) -> impl Iterator<Item = (&'e Expression, &'e [Expression])> {
    sections
        .iter()
        .filter_map(move |section| Some((section, section.tail_of(head)?)))
}

fn report_other_sections(reader: &mut Reader<'_>, sections: &[Expression], notes: &mut Vec<Diagnostic>) {
    for section in sections.iter().skip(1) {
        let head = section.list().and_then(|items| items.first()?.word()).unwrap_or("?");
        if SECTIONS.contains(&head) {
            continue;
        }
        if head == ":length" {
            notes.push(Diagnostic::at(
                reader.file,
                section.position,
                "`:length` is left out: a plan has any length",
            ));
            continue;
        }
        let known = SECTIONS.join(", ");
        let message = format!("`{head}` is not supported here; known sections are {known}");
        let other = OTHER_SECTIONS.iter().find(|(own, _)| *own == head);
        let hint = match (other, nearest(head, SECTIONS)) {
            (Some((_, hint)), _) => (*hint).to_owned(),
            (None, Some(near)) => format!("did you mean `{near}`?"),
            (None, None) => "remove it".to_owned(),
        };
        reader.report(section.position, message, hint);
    }
}

/// Returns the names of a domain as a reader of conditions needs them.
fn names_of(domain: &Domain) -> Semantics {
    Semantics {
        types: domain.types.clone(),
        constants: domain.constants.clone(),
        predicates: domain.predicates.clone(),
        derived: domain.derived.clone(),
        functions: domain.functions.iter().map(declared).collect(),
        costs: domain.has_costs(),
        ..Semantics::default()
    }
}

/// Reads the objects; returns their numbers by name. A hash map, since there are many more facts than names.
fn objects(
    reader: &mut Reader<'_>,
    domain: &Domain,
    sections: &[Expression],
    names: &mut Semantics,
    notes: &mut Vec<Diagnostic>,
) -> Option<FxHashMap<String, EntityId>> {
    let mut numbers: FxHashMap<String, EntityId> = FxHashMap::default();
    for (index, (name, _)) in names.constants.iter().enumerate() {
        numbers.insert(name.clone(), EntityId::new(index));
    }
    // A domain without types admits every object everywhere.
    let is_untyped = names.types.names().count() == 1;
    for (section, items) in of_sections(sections, ":objects") {
        if names.constants.len() + items.len() > ENTITY_LIMIT {
            let hint = "give fewer objects: those that the plan is about";
            reader.report(section.position, format!("more than {ENTITY_LIMIT} objects"), hint);
            return None;
        }
        let is_type = |item: &Expression| item.word() == Some("-");
        let mut items = std::borrow::Cow::Borrowed(items);
        if is_untyped && items.iter().any(is_type) {
            let mut pairs = items.windows(2);
            if pairs.any(|pair| is_type(&pair[0]) && pair[1].word() != Some("object")) {
                notes.push(Diagnostic::at(
                    reader.file,
                    section.position,
                    "the domain has no types, so those of the objects are left out",
                ));
            }
            items = without_types(&items).into();
        }
        for (name, kind, position) in reader.typed_list(&items, &names.types) {
            // Some problems declare the constants of their domain again.
            if domain.constants.iter().any(|own| *own == (name.clone(), kind)) {
                continue;
            }
            if numbers
                .insert(name.clone(), EntityId::new(names.constants.len()))
                .is_some()
            {
                let message = format!("the object `{name}` is declared twice, with two types");
                reader.report(
                    position,
                    message,
                    "keep one of the declarations, or give one another name",
                );
            }
            names.constants.push((name, kind));
        }
    }
    Some(numbers)
}

/// Returns the names of a typed list.
fn without_types(items: &[Expression]) -> Vec<Expression> {
    let is_name =
        |index: &usize| items[*index].word() != Some("-") && (*index == 0 || items[index - 1].word() != Some("-"));
    (0..items.len())
        .filter(is_name)
        .map(|index| items[index].clone())
        .collect()
}

/// Reads the facts and numbers of the start.
fn initial_state(
    reader: &mut Reader<'_>,
    domain: &Domain,
    sections: &[Expression],
    (names, numbers): (&Semantics, &FxHashMap<String, EntityId>),
    notes: &mut Vec<Diagnostic>,
) -> State {
    let is_derived = |id: PredicateId| domain.derived.iter().any(|own| own.predicate == id);
    let predicates: FxHashMap<&str, (PredicateId, usize)> = domain
        .predicates
        .iter()
        .enumerate()
        .map(|(index, p)| (p.name.as_str(), (PredicateId::new(index), p.parameters.len())))
        .filter(|(_, (id, _))| !is_derived(*id))
        .collect();
    let mut state = State::default();
    let mut unknown: FxHashSet<&str> = FxHashSet::default();
    for (_, items) in of_sections(sections, ":init") {
        let items = match items {
            [only] => only.tail_of("and").unwrap_or(items),
            _ => items,
        };
        for item in items {
            if let Some(fact) = known_fact(item, &predicates, numbers) {
                state.set(fact, true);
                continue;
            }
            if let Some([fluent, number]) = item.tail_of("=") {
                initial_number(reader, names, &mut state, (fluent, number), notes);
                continue;
            }
            if let Some((message, hint)) = uncertain(item, domain) {
                reader.report(item.position, message, hint);
                continue;
            }
            // A negated fact has no effect, but its names must be valid.
            let atom = match item.tail_of("not") {
                Some([inner]) => inner,
                _ => item,
            };
            if let Some(name) = undeclared(atom, names) {
                if unknown.insert(name) {
                    let message = format!(
                        "facts of `{name}` are left out: the domain does not declare it, so no action needs it"
                    );
                    notes.push(Diagnostic::at(reader.file, atom.position, message));
                }
                continue;
            }
            reader.changed(atom, &Vec::new(), names);
        }
    }
    state
}

/// Returns why an entry of `:init` says nothing certain about the start, and what to write.
fn uncertain(item: &Expression, domain: &Domain) -> Option<(String, &'static str)> {
    let items = item.list()?;
    let head = items.first()?.word()?;
    if domain.predicates.iter().any(|own| own.name == head) && items[1..].iter().all(|own| own.word().is_some()) {
        return None;
    }
    match (head, items) {
        ("at", [_, time, fact]) if fact.list().is_some() => {
            let time = time.word().unwrap_or("?");
            let hint = "plans here have no times: leave it out, or write the fact without the time if it may hold from the start";
            Some((
                format!("a fact that changes at the time {time} by itself is not supported"),
                hint,
            ))
        }
        ("unknown" | "oneof" | "or", _) => {
            let hint = "give the facts that hold; for facts that only sensing reveals, make a folder with `longstep domain new --pddl` \
                        and leave them out of its environment";
            Some((
                format!("`{head}` says that facts are not known at the start, which a problem here cannot say"),
                hint,
            ))
        }
        ("probabilistic" | "forall", _) => {
            let hint = "list the facts that hold at the start";
            Some((format!("`{head}` is not supported in `:init`"), hint))
        }
        _ => None,
    }
}

/// Returns the name of a fact's predicate if the domain does not declare it and it is not probably misspelt.
fn undeclared<'e>(atom: &'e Expression, names: &Semantics) -> Option<&'e str> {
    let (head, arguments) = atom.list()?.split_first()?;
    let name = head.word()?;
    let known = || names.predicates.iter().map(|own| own.name.as_str());
    let is_plain = arguments.iter().all(|argument| argument.word().is_some());
    (is_plain && known().all(|own| own != name) && nearest(name, known()).is_none()).then_some(name)
}

fn metric_notes(domain: &Domain, file: &str, sections: &[Expression]) -> Vec<Diagnostic> {
    let is_cost = |items: &[Expression]| {
        matches!(items, [word, cost] if word.word() == Some("minimize")
            && (cost.tail_of("total-cost") == Some(&[]) || cost.word() == Some("total-cost")))
    };
    let others = of_sections(sections, ":metric").filter(|(_, items)| !is_cost(items));
    let note = |(section, _): (&Expression, _)| {
        let message = if domain.has_costs() {
            "this metric is left out: a plan costs what its steps add to `(total-cost)`"
        } else {
            "this metric is left out: a plan costs as much as it has steps"
        };
        Diagnostic::at(file, section.position, message)
    };
    others.map(note).collect()
}

fn goal(
    reader: &mut Reader<'_>,
    sections: &[Expression],
    define: &Expression,
    names: &Semantics,
) -> (Vec<Wanted>, Goals) {
    let mut wanted = Vec::new();
    let mut goals = Goals::None(define.position);
    for (index, (section, items)) in of_sections(sections, ":goal").enumerate() {
        if index > 0 {
            let hint = "join them: `(:goal (and ...))`";
            reader.report(section.position, "the problem has a second goal", hint);
        }
        goals = Goals::One;
        match items {
            [] => goals = Goals::Empty(section.position),
            [goal] => {
                let goal = reader.condition(goal, &mut Vec::new(), names);
                wanted.extend(goal.conjuncts().map(|condition| Wanted {
                    condition: condition.clone(),
                    bindings: Vec::new(),
                }));
                if wanted.is_empty() {
                    goals = Goals::Empty(section.position);
                }
            }
            _ => reader.report(
                section.position,
                "expected one condition",
                "join them: `(:goal (and ...))`",
            ),
        }
    }
    (wanted, goals)
}

/// Lets counters without a number begin at zero: numbers without arguments that actions only increase or decrease, and that no
/// comparison, cost or other number reads.
fn begin_counters(domain: &Domain, file: &str, wanted: &[Wanted], state: &mut State, notes: &mut Vec<Diagnostic>) {
    let mut read: FxHashSet<FunctionId> = FxHashSet::default();
    let mut counted: Vec<FunctionId> = Vec::new();
    let conditions = |action: &Action| {
        let of_effects = action.effects.iter().map(|effect| effect.condition.clone());
        let of_numbers = action.numeric.iter().map(|effect| effect.condition.clone());
        std::iter::once(action.precondition.clone())
            .chain(of_effects)
            .chain(of_numbers)
            .collect::<Vec<_>>()
    };
    for action in &domain.actions {
        conditions(action)
            .iter()
            .for_each(|condition| compared(condition, &mut read));
        for effect in &action.numeric {
            read.extend(effect.value.functions());
            match effect.kind {
                NumberChangeKind::Assign => _ = read.insert(effect.fluent.function),
                _ => counted.push(effect.fluent.function),
            }
        }
        read.extend(action.cost.iter().flat_map(Arithmetic::functions));
    }
    wanted.iter().for_each(|wanted| compared(&wanted.condition, &mut read));
    counted.sort();
    counted.dedup();
    for function in counted {
        let declared = domain.function(function);
        let fluent = Application {
            function,
            terms: Vec::new(),
            at: When::Now,
        };
        if declared.parameters.is_empty() && !read.contains(&function) && state.number(fluent.ground(&[])).is_none() {
            state.set_number(fluent.ground(&[]), Number::ZERO);
            let message = format!("`({})` has no number at the start; it begins at 0", declared.name);
            notes.push(Diagnostic::whole(file, message));
        }
    }
}

/// Collects the functions that comparisons read.
fn compared(condition: &Condition, read: &mut FxHashSet<FunctionId>) {
    for part in condition.iter() {
        if let Condition::Number(test @ NumberTest::Compare(..)) = part {
            read.extend(test.functions());
        }
    }
}

/// Returns the declaration of a numeric function.
fn declared(function: &Function) -> Predicate {
    Predicate {
        name: function.name.clone(),
        parameters: function.parameters.clone(),
    }
}

/// Reads `(= (function argument ...) number)`; reports errors, and notes a fluent with two numbers.
fn initial_number(
    reader: &mut Reader<'_>,
    names: &Semantics,
    state: &mut State,
    (fluent, number): (&Expression, &Expression),
    notes: &mut Vec<Diagnostic>,
) {
    let value = match reader.number(number, &Vec::new(), names) {
        Some(Arithmetic::Constant(value)) => value,
        Some(_) => {
            return reader.report(
                number.position,
                "expected a number",
                "write digits, as in `(= (distance a b) 3)`",
            );
        }
        None => return,
    };
    if fluent.tail_of("total-cost") == Some(&[]) {
        // Where the cost begins changes no plan.
        return;
    }
    let Some(application) = reader.application(fluent, &Vec::new(), names) else {
        return;
    };
    let fluent = application.ground(&[]);
    if state.number(fluent).is_some_and(|known| known != value) {
        let message = "this number has another value before; the last one counts";
        notes.push(Diagnostic::at(reader.file, number.position, message));
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
