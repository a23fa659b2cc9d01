//! The parser of `domain.pddl`: types, constants, predicates and actions, with all names resolved.

use super::sexpr::{self, Expression, ExpressionKind};
use super::{ActionSchema, Parameter, Predicate, PredicateId, TypeId, Types};
use super::{Atom, Condition, Effect, Term, applicability};
use crate::diagnostic::{Diagnostic, Position, nearest};
use crate::model::{
    Application, Arithmetic, Comparison, EntityId, FunctionId, Number, NumberChangeKind, NumberTest, NumericEffect,
    NumericExpression, Operation,
};

/// The largest number of arguments of a fact; see [`crate::environment::Fact`].
const ARITY_LIMIT: usize = 7;

/// The supported requirements; files with others are rejected.
const REQUIREMENTS: [&str; 11] = [
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
    let mut semantics = Semantics::default();
    let expressions = match sexpr::read(file, text) {
        Ok(expressions) => expressions,
        Err(finding) => {
            findings.push(finding);
            return semantics;
        }
    };
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
    };
    match sections.first().and_then(|s| s.tail_of("domain")) {
        Some([name]) if name.word().is_some() => {
            semantics.name = name.word().unwrap_or_default().to_owned();
        }
        _ => reader.report(define.position, "the domain has no name: expected `(domain NAME)`"),
    }
    // Sections may come in any order, but some use the names of others.
    let known = [
        ":requirements",
        ":types",
        ":constants",
        ":predicates",
        ":functions",
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
            reader.report(section.position, message);
        }
    }
    let of = |head: &'static str| sections.iter().filter_map(move |s| Some((s, s.tail_of(head)?)));
    for (_, items) in of(":requirements") {
        for item in items {
            let word = item.word().unwrap_or("?");
            if !REQUIREMENTS.contains(&word) {
                let message = format!("the requirement `{word}` is not supported");
                reader.report(item.position, message);
            }
        }
    }
    for (_, items) in of(":types") {
        reader.types(items, &mut semantics.types);
    }
    for (_, items) in of(":constants") {
        for (name, kind, position) in reader.typed_list(items, &semantics.types) {
            if semantics.constants.iter().any(|(known, _)| *known == name) {
                reader.report(position, format!("the constant `{name}` is declared twice"));
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
    for (section, items) in of(":action") {
        reader.action(section, items, &mut semantics);
    }
    semantics
}

/// The effects of an action.
#[derive(Default)]
struct Effects {
    facts: Vec<Effect>,
    numbers: Vec<NumericEffect>,
    cost: Option<NumericExpression>,
}

/// The treatment of `(either ...)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Union {
    /// The parent must have no other types: actions and objects must not get more of them.
    Exact,
    /// The parent may have others: a predicate or a function without facts about them is false or unknown for them.
    Wider,
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

    pub(crate) fn report(&mut self, position: Position, message: impl Into<String>) {
        let position = self.place(position);
        self.findings.push(Diagnostic::at(self.file, position, message));
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
        if let Some(near) = nearest(name, known) {
            finding = finding.hint(format!("did you mean `{near}`?"));
        }
        self.findings.push(finding);
    }

    fn types(&mut self, items: &[Expression], types: &mut Types) {
        // A parent may be declared after its child, so all names come first.
        for item in items {
            match item.word() {
                Some("-") => {}
                Some(name) => {
                    types.intern(name);
                }
                None => self.report(item.position, "expected a type's name (`either` is not supported)"),
            }
        }
        let mut waiting = Vec::new();
        let mut words = items.iter();
        while let Some(item) = words.next() {
            match item.word() {
                Some("-") => {
                    let Some(parent) = words.next().and_then(Expression::word) else {
                        self.report(item.position, "`-` needs a type after it");
                        break;
                    };
                    let parent = types.intern(parent);
                    for child in waiting.drain(..) {
                        // `object` may be declared: every type is below it anyway.
                        if child == TypeId::OBJECT && (parent == TypeId::OBJECT || self.dialect == Dialect::Standard) {
                            continue;
                        }
                        if !types.set_parent(child, parent) {
                            let message = format!("the type `{}` would be its own ancestor", types.name(child));
                            self.report(item.position, message);
                        }
                    }
                }
                Some(name) => waiting.push(types.intern(name)),
                None => {}
            }
        }
    }

    /// Parses `a b - kind c` into names with types; names without a type are of type `object`.
    pub(crate) fn typed_list(&mut self, items: &[Expression], types: &Types) -> Vec<(String, TypeId, Position)> {
        self.typed(items, types, Union::Exact)
    }

    fn typed(&mut self, items: &[Expression], types: &Types, union: Union) -> Vec<(String, TypeId, Position)> {
        let mut list: Vec<(String, TypeId, Position)> = Vec::new();
        let mut untyped = 0;
        let mut words = items.iter();
        while let Some(item) = words.next() {
            match item.word() {
                Some("-") => {
                    let Some(kind) = words.next() else {
                        self.report(item.position, "`-` needs a type after it");
                        break;
                    };
                    if let Some(id) = self.type_of(kind, types, union) {
                        list[untyped..].iter_mut().for_each(|entry| entry.1 = id);
                    }
                    untyped = list.len();
                }
                Some(name) => list.push((name.to_owned(), TypeId::OBJECT, item.position)),
                None => self.report(item.position, "expected a name"),
            }
        }
        list
    }

    /// Parses a type's name, or `(either ...)` as the common parent of its types. Reports errors.
    fn type_of(&mut self, item: &Expression, types: &Types, union: Union) -> Option<TypeId> {
        let Some(members) = item.tail_of("either").filter(|members| !members.is_empty()) else {
            let name = item.word().unwrap_or("?");
            let found = types.find(name);
            if found.is_none() {
                self.report_unknown(item.position, "type", name, types.names());
            }
            return found;
        };
        let mut kinds = Vec::with_capacity(members.len());
        for member in members {
            let name = member.word().unwrap_or("?");
            match types.find(name) {
                Some(kind) => kinds.push(kind),
                None => self.report_unknown(member.position, "type", name, types.names()),
            }
        }
        if kinds.len() < members.len() {
            return None;
        }
        let all = || (0..types.len()).map(TypeId::new);
        let is_common = |parent: &TypeId| kinds.iter().all(|kind| types.is_a(*kind, *parent));
        let is_lowest = |parent: &TypeId| all().filter(is_common).all(|other| types.is_a(*parent, other));
        let parent = all().filter(is_common).find(is_lowest).unwrap_or(TypeId::OBJECT);
        let is_leaf = |kind: TypeId| all().all(|other| other == kind || !types.is_a(other, kind));
        let others = all().filter(|kind| types.is_a(*kind, parent) && is_leaf(*kind));
        let mut others = others.filter(|leaf| !kinds.iter().any(|kind| types.is_a(*leaf, *kind)));
        match others.next() {
            Some(other) if union == Union::Exact => {
                let message = format!(
                    "`(either ...)` is supported here only for all the types of a parent; `{}` would also admit `{}`",
                    types.name(parent),
                    types.name(other)
                );
                let position = self.place(item.position);
                self.findings.push(
                    Diagnostic::at(self.file, position, message)
                        .hint("declare a type with these types as its children, and use it here"),
                );
                None
            }
            _ => Some(parent),
        }
    }

    /// Parses variables like [`Self::typed_list`]; requires and removes the leading `?`.
    pub(crate) fn variables(&mut self, items: &[Expression], types: &Types) -> Vec<Parameter> {
        self.variables_of(items, types, Union::Exact)
    }

    fn variables_of(&mut self, items: &[Expression], types: &Types, union: Union) -> Vec<Parameter> {
        let mut variables: Vec<Parameter> = Vec::new();
        for (name, kind, position) in self.typed(items, types, union) {
            match name.strip_prefix('?') {
                Some(name) if variables.iter().any(|known| known.name == name) => {
                    self.report(position, format!("`?{name}` is declared twice"));
                }
                Some(name) => variables.push(Parameter {
                    name: name.to_owned(),
                    kind,
                }),
                None => self.report(position, format!("`{name}` must be a variable, as in `?{name}`")),
            }
        }
        variables
    }

    fn predicate(&mut self, item: &Expression, semantics: &mut Semantics) {
        let Some([head, parameters @ ..]) = item.list() else {
            return self.report(item.position, "expected `(predicate ?x - type)`");
        };
        let Some(name) = head.word() else {
            return self.report(head.position, "expected a predicate's name");
        };
        if semantics.predicates.iter().any(|p| p.name == name) {
            return self.report(head.position, format!("the predicate `{name}` is declared twice"));
        }
        let parameters = self.variables_of(parameters, &semantics.types, Union::Wider);
        if parameters.len() > ARITY_LIMIT {
            let message = format!("`{name}` has more than {ARITY_LIMIT} arguments");
            self.report(head.position, message);
            return;
        }
        semantics.predicate_positions.push(head.position);
        semantics.predicates.push(Predicate {
            name: name.to_owned(),
            parameters,
        });
    }

    fn action(&mut self, section: &Expression, items: &[Expression], semantics: &mut Semantics) {
        let [name, fields @ ..] = items else {
            return self.report(section.position, "an action needs a name");
        };
        let Some(word) = name.word() else {
            return self.report(name.position, "an action needs a name");
        };
        if semantics.actions.iter().any(|a| a.name == word) {
            return self.report(name.position, format!("the action `{word}` is declared twice"));
        }
        let mut parameters = Vec::new();
        let mut precondition = Condition::TRUE;
        let mut effects = Effects::default();
        // The other fields need the parameters, which may come after them.
        for pair in fields.chunks(2) {
            if let [key, value] = pair
                && key.word() == Some(":parameters")
            {
                match value.list() {
                    Some(list) => parameters = self.variables(list, &semantics.types),
                    None => self.report(value.position, "expected `(?x - type ...)`"),
                }
            }
        }
        let mut scope: Scope = parameters.iter().map(|p| (p.name.clone(), p.kind)).collect();
        for pair in fields.chunks(2) {
            let [key, value] = pair else {
                self.report(pair[0].position, "this has no value");
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
                    self.report(key.position, message);
                }
            }
        }
        let Effects { facts, numbers, cost } = effects;
        let mut required = applicability(&numbers, parameters.len());
        // A step whose cost is unknown is not applicable.
        required.extend(
            cost.iter()
                .filter(|cost| !matches!(cost, Arithmetic::Constant(_)))
                .map(|cost| Condition::Number {
                    test: NumberTest::Known(cost.clone(), true),
                    initially: false,
                }),
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

    /// Parses `(:functions ...)`: numeric functions, each optionally followed by `- number`.
    fn functions(&mut self, items: &[Expression], semantics: &mut Semantics) {
        let mut items = items.iter();
        while let Some(item) = items.next() {
            if item.word() == Some("-") {
                match items.next() {
                    Some(kind) if kind.word() == Some("number") => {}
                    other => {
                        let position = other.map_or(item.position, |kind| kind.position);
                        self.report(
                            position,
                            "a function has the type `number`; other types are not supported",
                        );
                    }
                }
                continue;
            }
            let Some([head, parameters @ ..]) = item.list() else {
                self.report(item.position, "expected `(function ?x - type)`");
                continue;
            };
            let Some(name) = head.word() else {
                self.report(head.position, "expected a function's name");
                continue;
            };
            if name == TOTAL_COST {
                semantics.costs = true;
                if !parameters.is_empty() {
                    self.report(head.position, "`total-cost` has no arguments");
                }
                continue;
            }
            let taken = |own: &Predicate| own.name == name;
            if semantics.functions.iter().any(taken) || semantics.predicates.iter().any(taken) {
                self.report(head.position, format!("`{name}` is declared twice"));
                continue;
            }
            let parameters = self.variables_of(parameters, &semantics.types, Union::Wider);
            if parameters.len() > ARITY_LIMIT {
                let message = format!("`{name}` has more than {ARITY_LIMIT} arguments");
                self.report(head.position, message);
                continue;
            }
            semantics.function_positions.push(head.position);
            semantics.functions.push(Predicate {
                name: name.to_owned(),
                parameters,
            });
        }
    }

    /// Parses a numeric expression; reports errors.
    pub(crate) fn number(&mut self, item: &Expression, scope: &Scope, names: &Semantics) -> Option<NumericExpression> {
        let Some(list) = item.list() else {
            let number = item.word().and_then(Number::parse);
            if number.is_none() {
                let message = format!(
                    "`{}` is no number: expected digits with at most six places after the point, or `(function ...)`",
                    item.word().unwrap_or("?")
                );
                self.report(item.position, message);
            }
            return number.map(Arithmetic::Constant);
        };
        let Some((head, rest)) = list.split_first() else {
            self.report(item.position, "expected a number or `(function argument ...)`");
            return None;
        };
        let Some(operation) = head.word().and_then(Operation::of) else {
            return self.application(item, scope, names).map(Arithmetic::Value);
        };
        let mut values = Vec::with_capacity(rest.len());
        for part in rest {
            values.push(self.number(part, scope, names)?);
        }
        // Sums and products may have any number of parts; a single part of a difference is negated.
        let negation = operation == Operation::Minus && values.len() == 1;
        if negation {
            values.insert(0, Arithmetic::Constant(Number::ZERO));
        }
        let many = matches!(operation, Operation::Plus | Operation::Times);
        if values.len() < 2 || (values.len() > 2 && !many) {
            let message = format!("`{}` has the wrong number of parts", operation.symbol());
            self.report(item.position, message);
            return None;
        }
        let folded = values
            .into_iter()
            .reduce(|left, right| Arithmetic::operation(operation, left, right));
        // Computes operations on constants.
        folded.map(|folded| folded.map(&mut |own: &Application| Arithmetic::Value(own.clone())))
    }

    /// Parses `(function argument ...)`; reports errors.
    pub(crate) fn application(&mut self, item: &Expression, scope: &Scope, names: &Semantics) -> Option<Application> {
        let Some((head, arguments)) = item.list().and_then(<[_]>::split_first) else {
            self.report(item.position, "expected `(function argument ...)`");
            return None;
        };
        let name = head.word().unwrap_or_default();
        let Some(index) = names.functions.iter().position(|own| own.name == name) else {
            if name == TOTAL_COST {
                self.report(
                    head.position,
                    "`(total-cost)` is the cost of the plan; only effects may increase it",
                );
            } else {
                let known = names.functions.iter().map(|own| own.name.as_str());
                self.report_unknown(head.position, "function", name, known);
            }
            return None;
        };
        let parameters = &names.functions[index].parameters;
        let terms = self.arguments(item, name, arguments, parameters, scope, names)?;
        Some(Application {
            function: FunctionId::new(index),
            terms,
        })
    }

    /// Returns true if the text is a number or begins like a numeric expression.
    fn is_numeric(item: &Expression, names: &Semantics) -> bool {
        match item.list() {
            None => item
                .word()
                .is_some_and(|word| Number::parse(word).is_some() && !word.starts_with('?')),
            Some(list) => list.first().and_then(Expression::word).is_some_and(|head| {
                Operation::of(head).is_some()
                    || names.functions.iter().any(|own| own.name == head)
                    || head == TOTAL_COST
            }),
        }
    }

    /// Parses `(increase FLUENT VALUE)` and the like.
    fn numeric_effect(
        &mut self,
        (kind, item, rest): (NumberChangeKind, &Expression, &[Expression]),
        scope: &Scope,
        forall: &[(usize, TypeId)],
        when: &Condition,
        names: &Semantics,
        effects: &mut Effects,
    ) {
        let [fluent, value] = rest else {
            let message = format!("`{}` has the wrong number of parts", kind.word());
            return self.report(item.position, message);
        };
        let is_cost = fluent
            .list()
            .is_some_and(|list| matches!(list, [head] if head.word() == Some(TOTAL_COST)));
        if is_cost && names.costs {
            let value = self.number(value, scope, names);
            if kind != NumberChangeKind::Increase || !forall.is_empty() || *when != Condition::TRUE {
                let message = "the cost of a step is one `(increase (total-cost) ...)` outside of `when` and `forall`";
                return self.report(item.position, message);
            }
            effects.cost = match (effects.cost.take(), value) {
                (Some(one), Some(other)) => Some(Arithmetic::operation(Operation::Plus, one, other)),
                (one, other) => one.or(other),
            };
            return;
        }
        let fluent = self.application(fluent, scope, names);
        let value = self.number(value, scope, names);
        if let (Some(fluent), Some(value)) = (fluent, value) {
            effects.numbers.push(NumericEffect {
                forall: forall.to_vec(),
                condition: when.clone(),
                fluent,
                kind,
                value,
            });
        }
    }

    /// Parses a condition; reports errors and returns `true` in place of each unreadable part.
    pub(crate) fn condition(&mut self, item: &Expression, scope: &mut Scope, names: &Semantics) -> Condition {
        let Some(list) = item.list() else {
            self.report(item.position, "expected a condition in parentheses");
            return Condition::TRUE;
        };
        let Some((head, rest)) = list.split_first() else {
            return Condition::TRUE;
        };
        let all = |reader: &mut Self, scope: &mut Scope| -> Vec<Condition> {
            rest.iter().map(|c| reader.condition(c, scope, names)).collect()
        };
        match (head.word().unwrap_or_default(), rest) {
            ("and", _) => Condition::And(all(self, scope)),
            ("or", _) => Condition::Or(all(self, scope)),
            ("not", [inner]) => self.condition(inner, scope, names).negated(),
            ("imply", [when, then]) => Condition::Or(vec![
                self.condition(when, scope, names).negated(),
                self.condition(then, scope, names),
            ]),
            ("initially", [inner]) if self.dialect == Dialect::Longstep => {
                self.condition(inner, scope, names).initially()
            }
            ("forall" | "exists", [variables, inner]) => {
                let outer = scope.len();
                for variable in self.variables(variables.list().unwrap_or_default(), &names.types) {
                    scope.push((variable.name, variable.kind));
                }
                let quantified: Vec<TypeId> = scope[outer..].iter().map(|(_, kind)| *kind).collect();
                let inner = self.condition(inner, scope, names);
                scope.truncate(outer);
                quantified
                    .into_iter()
                    .enumerate()
                    .rev()
                    .fold(inner, |inner, (index, kind)| match head.word() {
                        Some("forall") => Condition::Forall(outer + index, kind, Box::new(inner)),
                        _ => Condition::Exists(outer + index, kind, Box::new(inner)),
                    })
            }
            (symbol @ ("=" | "<" | "<=" | ">" | ">="), [left, right])
                if symbol != "=" || Self::is_numeric(left, names) || Self::is_numeric(right, names) =>
            {
                let sides = (self.number(left, scope, names), self.number(right, scope, names));
                match (sides, Comparison::of(symbol)) {
                    ((Some(left), Some(right)), Some(comparison)) => Condition::Number {
                        test: NumberTest::Compare(left, comparison, right),
                        initially: false,
                    },
                    _ => Condition::TRUE,
                }
            }
            ("=", [left, right]) => match (self.term(left, scope, names), self.term(right, scope, names)) {
                (Some((left, _)), Some((right, _))) => Condition::Equal {
                    left,
                    right,
                    holds: true,
                },
                _ => Condition::TRUE,
            },
            ("not" | "imply" | "forall" | "exists" | "=" | "<" | "<=" | ">" | ">=", _) => {
                let message = format!("`{}` has the wrong number of parts", head.word().unwrap_or_default());
                self.report(item.position, message);
                Condition::TRUE
            }
            _ => match self.atom(item, scope, names) {
                Some(atom) => Condition::Atom {
                    atom,
                    holds: true,
                    initially: false,
                },
                None => Condition::TRUE,
            },
        }
    }

    /// Returns true if the first part is a list: a fact has names as arguments, so a predicate may be called `assign`.
    fn changes_number(names: &Semantics, rest: &[Expression]) -> bool {
        rest.first().is_some_and(|first| first.list().is_some())
            || !names
                .predicates
                .iter()
                .any(|own| NumberChangeKind::of(&own.name).is_some())
    }

    fn effect(
        &mut self,
        item: &Expression,
        scope: &mut Scope,
        forall: &mut Vec<(usize, TypeId)>,
        when: &Condition,
        names: &Semantics,
        effects: &mut Effects,
    ) {
        let Some(list) = item.list() else {
            return self.report(item.position, "expected an effect in parentheses");
        };
        let Some((head, rest)) = list.split_first() else {
            return;
        };
        match (head.word().unwrap_or_default(), rest) {
            ("and", _) => {
                for part in rest {
                    self.effect(part, scope, forall, when, names, effects);
                }
            }
            ("forall", [variables, inner]) => {
                let (outer, quantified) = (scope.len(), forall.len());
                for variable in self.variables(variables.list().unwrap_or_default(), &names.types) {
                    forall.push((scope.len(), variable.kind));
                    scope.push((variable.name, variable.kind));
                }
                // Slots of an enclosing `when` move behind the variables of the effect.
                let own = scope.len() - outer;
                let when = when
                    .clone()
                    .with_slots(&|slot| if slot < outer { slot } else { slot + own });
                self.effect(inner, scope, forall, &when, names, effects);
                scope.truncate(outer);
                forall.truncate(quantified);
            }
            ("when", [condition, inner]) => {
                let condition = self.condition(condition, scope, names);
                let both = match when {
                    Condition::And(outer) if outer.is_empty() => condition,
                    outer => Condition::And(vec![outer.clone(), condition]),
                };
                self.effect(inner, scope, forall, &both, names, effects);
            }
            ("not", [inner]) => {
                if let Some(atom) = self.atom(inner, scope, names) {
                    effects.facts.push(Effect {
                        forall: forall.clone(),
                        condition: when.clone(),
                        atom,
                        adds: false,
                    });
                }
            }
            ("forall" | "when" | "not", _) => {
                let message = format!("`{}` has the wrong number of parts", head.word().unwrap_or_default());
                self.report(item.position, message);
            }
            (word, _) if NumberChangeKind::of(word).is_some_and(|_| Self::changes_number(names, rest)) => {
                if let Some(kind) = NumberChangeKind::of(word) {
                    self.numeric_effect((kind, item, rest), scope, forall, when, names, effects);
                }
            }
            _ => {
                if let Some(atom) = self.atom(item, scope, names) {
                    effects.facts.push(Effect {
                        forall: forall.clone(),
                        condition: when.clone(),
                        atom,
                        adds: true,
                    });
                }
            }
        }
    }

    pub(crate) fn atom(&mut self, item: &Expression, scope: &Scope, names: &Semantics) -> Option<Atom> {
        let Some((head, arguments)) = item.list().and_then(<[_]>::split_first) else {
            self.report(item.position, "expected `(predicate argument ...)`");
            return None;
        };
        let Some(name) = head.word() else {
            self.report(head.position, "expected a predicate's name");
            return None;
        };
        let Some(index) = names.predicates.iter().position(|p| p.name == name) else {
            let known = names.predicates.iter().map(|p| p.name.as_str());
            self.report_unknown(head.position, "predicate", name, known);
            return None;
        };
        let parameters = &names.predicates[index].parameters;
        let terms = self.arguments(item, name, arguments, parameters, scope, names)?;
        Some(Atom {
            predicate: PredicateId::new(index),
            terms,
        })
    }

    /// Parses the arguments of a predicate or a function; reports errors.
    fn arguments(
        &mut self,
        item: &Expression,
        name: &str,
        arguments: &[Expression],
        parameters: &[Parameter],
        scope: &Scope,
        names: &Semantics,
    ) -> Option<Vec<Term>> {
        if parameters.len() != arguments.len() {
            let message = format!(
                "`{name}` takes {} argument(s), not {}",
                parameters.len(),
                arguments.len()
            );
            self.report(item.position, message);
            return None;
        }
        let mut terms = Vec::with_capacity(arguments.len());
        for (argument, parameter) in arguments.iter().zip(parameters) {
            let (term, kind) = self.term(argument, scope, names)?;
            // A supertype is allowed: the atom is false for entities of other types.
            let fits = names.types.is_a(kind, parameter.kind) || names.types.is_a(parameter.kind, kind);
            if !fits && self.dialect == Dialect::Longstep {
                let message = format!(
                    "`{name}` takes a {} here, and this is a {}",
                    names.types.name(parameter.kind),
                    names.types.name(kind)
                );
                self.report(argument.position, message);
                return None;
            }
            terms.push(term);
        }
        Some(terms)
    }

    fn term(&mut self, item: &Expression, scope: &Scope, names: &Semantics) -> Option<(Term, TypeId)> {
        let ExpressionKind::Word(word) = &item.kind else {
            self.report(item.position, "expected a variable or a constant");
            return None;
        };
        if let Some(variable) = word.strip_prefix('?') {
            // The innermost variable shadows others of the same name.
            if let Some(slot) = scope.iter().rposition(|(name, _)| name == variable) {
                return Some((Term::Variable(slot), scope[slot].1));
            }
            let known = scope.iter().map(|(name, _)| name.as_str());
            self.report_unknown(item.position, "variable", variable, known);
            return None;
        }
        match names.constants.iter().position(|(name, _)| name == word) {
            Some(index) => Some((Term::Constant(EntityId::new(index)), names.constants[index].1)),
            None => {
                let known = names.constants.iter().map(|(name, _)| name.as_str());
                self.report_unknown(item.position, "constant", word, known);
                None
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn every_mistake_is_told_at_once() {
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
    fn either_is_the_parent_of_its_types() {
        let text = |parameter: &str| {
            format!(
                "(define (domain d) (:types person plane - mover van - object) (:predicates (at ?x - (either person van)))
(:action a :parameters (?x - {parameter}) :precondition (at ?x) :effect (not (at ?x))))"
            )
        };
        check(&text("(either plane person)"), &[]);
        check(&text("(either person)"), &[]);
        check(
            &text("(either person van)"),
            &[
                "domain.pddl:2:30: `(either ...)` is supported here only for all the types of a parent; `object` would \
               also admit `plane`\n  hint: declare a type with these types as its children, and use it here",
            ],
        );
        check(
            &text("(either person vann)"),
            &["domain.pddl:2:45: unknown type `vann`\n  hint: did you mean `van`?"],
        );
    }

    #[test]
    fn what_is_not_understood_is_refused() {
        check(
            "(define (domain d) (:requirements :durative-actions) (:derived (cost)))",
            &[
                "domain.pddl:1:54: `:derived` is not supported here; known sections are :requirements, :types, :constants, :predicates, :functions, :action",
                "domain.pddl:1:35: the requirement `:durative-actions` is not supported",
            ],
        );
    }

    #[test]
    fn wrong_counts_and_types_are_told() {
        check(
            "(define (domain d) (:types cup lid) (:predicates (full ?c - cup))
(:action a :parameters (?c - cup ?l - lid) :precondition (and (full ?c ?c) (full ?l)) :effect (not)))",
            &[
                "domain.pddl:2:63: `full` takes 1 argument(s), not 2",
                "domain.pddl:2:82: `full` takes a cup here, and this is a lid",
                "domain.pddl:2:95: `not` has the wrong number of parts",
            ],
        );
    }
}
