//! The parser of `domain.pddl`: types, constants, predicates and actions, with all names resolved.

mod conditions;
mod declarations;
mod derived;
mod durative;
pub(crate) mod foreign;
mod numbers;
mod types;
pub(crate) mod written;

use conditions::Effects;

use super::sexpr::{self, Expression};
use super::{ActionSchema, Condition, Predicate, TypeId, Types, applicability};
use crate::diagnostic::{Diagnostic, Position, nearest};
use crate::model::{Arithmetic, DerivedPredicate, NumberTest};

/// The largest number of arguments of a fact; see [`crate::environment::Fact`].
const ARITY_LIMIT: usize = 7;

/// The supported requirements; files with others are rejected.
const REQUIREMENTS: [&str; 12] = [
    ":strips",
    ":typing",
    ":negative-preconditions",
    ":disjunctive-preconditions",
    ":quantified-preconditions",
    ":conditional-effects",
    ":equality",
    ":adl",
    ":fluents",
    ":numeric-fluents",
    ":action-costs",
    ":derived-predicates",
];

/// The function whose increase is the cost of a step.
const TOTAL_COST: &str = "total-cost";

/// The dialect of a PDDL file, which decides how strict parsing is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Dialect {
    /// Files of this library: probable mistakes are errors.
    Longstep,
    /// Files for any planner: arguments may have any type, and `object` may be declared. A fact with an argument of the
    /// wrong type holds, but no action can use it. `(initially ...)` is an extension of this library and not accepted.
    Standard,
}

/// The contents of `domain.pddl`.
#[derive(Debug, Clone, Default)]
pub(crate) struct Semantics {
    pub(crate) name: String,
    pub(crate) types: Types,
    pub(crate) constants: Vec<(String, TypeId)>,
    pub(crate) predicates: Vec<Predicate>,
    /// The derived predicates, each after those that it depends on.
    pub(crate) derived: Vec<DerivedPredicate>,
    /// The numeric functions, without the cost of the plan.
    pub(crate) functions: Vec<Predicate>,
    /// True if `(total-cost)` is declared.
    pub(crate) costs: bool,
    pub(crate) actions: Vec<ActionSchema>,
    /// The positions of the declarations of predicates and actions, for diagnostics of the wording file.
    pub(crate) predicate_positions: Vec<Position>,
    pub(crate) function_positions: Vec<Position>,
    pub(crate) action_positions: Vec<Position>,
}

/// Parses a domain file; appends errors to `findings` and returns everything that could be read.
pub(crate) fn read(file: &str, text: &str, dialect: Dialect, findings: &mut Vec<Diagnostic>) -> Semantics {
    let read = match dialect {
        Dialect::Longstep => sexpr::read(file, text),
        Dialect::Standard => foreign::read(file, text, None).map(|own| own.expressions),
    };
    match read {
        Ok(expressions) => read_expressions(file, &expressions, dialect, findings),
        Err(finding) => {
            findings.push(finding);
            Semantics::default()
        }
    }
}

/// Parses the expressions of a domain file, as [`read`] does.
pub(crate) fn read_expressions(
    file: &str,
    expressions: &[Expression],
    dialect: Dialect,
    findings: &mut Vec<Diagnostic>,
) -> Semantics {
    let mut semantics = Semantics::default();
    let Some((define, sections)) = expressions
        .first()
        .and_then(|first| Some((first, first.tail_of("define")?)))
    else {
        findings.push(
            Diagnostic::at(file, Position { line: 1, column: 1 }, "no `(define (domain NAME) ...)`")
                .hint("a domain file is one `(define (domain NAME) ...)` list"),
        );
        return semantics;
    };
    for extra in &expressions[1..] {
        findings.push(Diagnostic::at(
            file,
            extra.position,
            "something follows the domain's end",
        ));
    }
    let mut reader = Reader {
        file,
        base: Position { line: 1, column: 1 },
        dialect,
        findings,
        expanded: 0,
    };
    match sections.first().and_then(|s| s.tail_of("domain")) {
        Some([name]) if name.word().is_some() => {
            semantics.name = name.word().unwrap_or_default().to_owned();
        }
        _ => reader.report(
            define.position,
            "the domain has no name: expected `(domain NAME)`",
            "write `(define (domain NAME) ...)`",
        ),
    }
    // Sections may come in any order, but some use the names of others.
    let known = [
        ":requirements",
        ":types",
        ":constants",
        ":predicates",
        ":functions",
        ":derived",
        ":action",
    ];
    for section in sections.iter().skip(1) {
        let head = section.list().and_then(|items| items.first()?.word());
        if !head.is_some_and(|head| known.contains(&head)) {
            let message = format!(
                "`{}` is not supported here; known sections are {}",
                head.unwrap_or("?"),
                known.join(", ")
            );
            reader.report(section.position, message, section_hint(head.unwrap_or("?"), &known));
        }
    }
    let of = |head: &'static str| sections.iter().filter_map(move |s| Some((s, s.tail_of(head)?)));
    for (_, items) in of(":requirements") {
        for item in items {
            let word = item.word().unwrap_or("?");
            if !REQUIREMENTS.contains(&word) {
                let message = format!("the requirement `{word}` is not supported");
                reader.report(item.position, message, "remove it, and what it is for");
            }
        }
    }
    for (_, items) in of(":types") {
        reader.types(items, &mut semantics.types);
    }
    for (_, items) in of(":constants") {
        for (name, kind, position) in reader.typed_list(items, &semantics.types) {
            if semantics.constants.iter().any(|(known, _)| *known == name) {
                let message = format!("the constant `{name}` is declared twice");
                reader.report(
                    position,
                    message,
                    "keep one of the declarations, or give one another name",
                );
            }
            semantics.constants.push((name, kind));
        }
    }
    for (_, items) in of(":predicates") {
        for item in items {
            reader.predicate(item, &mut semantics);
        }
    }
    for (_, items) in of(":functions") {
        reader.functions(items, &mut semantics);
    }
    reader.derived(of(":derived"), &mut semantics);
    for (section, items) in of(":action") {
        reader.action(section, items, &mut semantics);
    }
    semantics
}

/// Returns what to write in place of a section that is not read.
fn section_hint(head: &str, known: &[&str]) -> String {
    let hint = match head {
        ":process" | ":event" => "PDDL+ is not read: let actions change the facts and numbers",
        ":axiom" => "write it as `(:derived (predicate ?x - type) CONDITION)`",
        ":constraint" | ":constraints" => "write it as a `[[rule]]` in `domain.toml`, or with `--rules`",
        ":task" | ":method" => "tasks and methods are not read: write a goal, and search finds the steps",
        ":init" | ":goal" | ":objects" | ":metric" => "put it into the problem file",
        _ => match nearest(head, known.iter().copied()) {
            Some(near) => return format!("did you mean `{near}`?"),
            None => "remove it",
        },
    };
    hint.to_owned()
}

/// Returns what to write in place of a part of an action that is not read.
fn part_hint(key: &str) -> String {
    let known = [":parameters", ":precondition", ":effect"];
    match key {
        ":observe" | ":sense" => {
            "an action that senses has the effect `(and)` and names its outcomes as `senses` in `domain.toml`"
                .to_owned()
        }
        ":duration" | ":condition" => "write `:durative-action` in place of `:action`".to_owned(),
        _ => match nearest(key, known) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "remove it, or check the parentheses before it".to_owned(),
        },
    }
}

/// The names that a hint lists.
const LISTED: usize = 8;

/// Returns where an unknown name can be declared, or which names are known.
fn declaration_hint(what: &str, known: &[&str]) -> String {
    let section = match what {
        "type" => "(:types ...)",
        "predicate" => "(:predicates ...)",
        "function" => "(:functions ...)",
        "constant" => "(:constants ...)` or `(:objects ...)",
        // A variable.
        _ => ":parameters (?x - type)",
    };
    let mut hint = format!("declare it in `{section}`");
    if !known.is_empty() {
        let listed: Vec<String> = known.iter().take(LISTED).map(|name| format!("`{name}`")).collect();
        let more = if known.len() > LISTED { ", ..." } else { "" };
        hint.push_str(&format!("; known are {}{more}", listed.join(", ")));
    }
    hint
}

/// Variables in scope, outermost first.
pub(crate) type Scope = Vec<(String, TypeId)>;

/// Resolves expressions against the names read so far.
pub(crate) struct Reader<'a> {
    pub(crate) file: &'a str,
    /// The position of the text in the file: a condition may be inside a TOML string.
    pub(crate) base: Position,
    pub(crate) dialect: Dialect,
    pub(crate) findings: &'a mut Vec<Diagnostic>,
    /// The parts of the conditions that took the place of derived facts.
    pub(crate) expanded: usize,
}

impl Reader<'_> {
    fn place(&self, position: Position) -> Position {
        Position {
            line: self.base.line + position.line - 1,
            column: if position.line == 1 {
                self.base.column + position.column - 1
            } else {
                position.column
            },
        }
    }

    pub(crate) fn report(&mut self, position: Position, message: impl Into<String>, hint: impl Into<String>) {
        let position = self.place(position);
        self.findings
            .push(Diagnostic::at(self.file, position, message).hint(hint));
    }

    fn report_unknown<'n>(
        &mut self,
        position: Position,
        what: &str,
        name: &str,
        known: impl IntoIterator<Item = &'n str>,
    ) {
        let position = self.place(position);
        let mut finding = Diagnostic::at(self.file, position, format!("unknown {what} `{name}`"));
        let known: Vec<&str> = known.into_iter().collect();
        finding = finding.hint(match nearest(name, known.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => declaration_hint(what, &known),
        });
        self.findings.push(finding);
    }

    fn action(&mut self, section: &Expression, items: &[Expression], semantics: &mut Semantics) {
        let [name, fields @ ..] = items else {
            return self.report(
                section.position,
                "an action needs a name",
                "write `(:action NAME :parameters (?x - type) ...)`",
            );
        };
        let Some(word) = name.word() else {
            return self.report(
                name.position,
                "an action needs a name",
                "write `(:action NAME :parameters (?x - type) ...)`",
            );
        };
        if semantics.actions.iter().any(|a| a.name == word) {
            let message = format!("the action `{word}` is declared twice");
            return self.report(name.position, message, "give one of them another name");
        }
        let (mut parameters, mut guards) = (Vec::new(), Vec::new());
        let mut precondition = Condition::TRUE;
        let mut effects = Effects::default();
        // The other fields need the parameters, which may come after them.
        for pair in fields.chunks(2) {
            if let [key, value] = pair
                && key.word() == Some(":parameters")
            {
                match value.list() {
                    Some(list) => (parameters, guards) = self.guarded(list, &semantics.types, 0),
                    None => self.report(
                        value.position,
                        "expected `(?x - type ...)`",
                        "write the variables in parentheses",
                    ),
                }
            }
        }
        let mut scope: Scope = parameters.iter().map(|p| (p.name.clone(), p.kind)).collect();
        for pair in fields.chunks(2) {
            let [key, value] = pair else {
                self.report(
                    pair[0].position,
                    "this has no value",
                    "write what it needs behind it, or remove it",
                );
                continue;
            };
            match key.word() {
                Some(":parameters") => {}
                Some(":precondition") => precondition = self.condition(value, &mut scope, semantics),
                Some(":effect") => {
                    let mut path = Vec::new();
                    self.effect(value, &mut scope, &mut path, &Condition::TRUE, semantics, &mut effects);
                }
                other => {
                    let message = format!(
                        "`{}` is not a part of an action; known are :parameters, :precondition, :effect",
                        other.unwrap_or("?")
                    );
                    self.report(key.position, message, part_hint(other.unwrap_or("?")));
                }
            }
        }
        let Effects { facts, numbers, cost } = effects;
        let mut required = applicability(&numbers, parameters.len());
        // A step whose cost is unknown is not applicable.
        required.extend(guards);
        required.extend(
            cost.iter()
                .filter(|cost| !matches!(cost, Arithmetic::Constant(_)))
                .map(|cost| Condition::Number(NumberTest::Known(cost.clone(), true))),
        );
        if !required.is_empty() {
            precondition = Condition::And(std::iter::once(precondition).chain(required).collect());
        }
        semantics.action_positions.push(name.position);
        semantics.actions.push(ActionSchema {
            name: word.to_owned(),
            parameters,
            precondition,
            effects: facts,
            numeric: numbers,
            cost,
        });
    }
}

#[cfg(test)]
mod tests;
