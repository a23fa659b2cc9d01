//! Derived predicates: conditions with a name. Wherever a condition asks for such a fact, its definition takes its place.

use rustc_hash::{FxHashMap, FxHashSet};

use super::{Reader, Scope, Semantics};
use crate::domain::sexpr::Expression;
use crate::domain::{Atom, Condition, PredicateId, Term, TypeId};
use crate::model::DerivedPredicate;

/// The parts of all conditions that take the place of derived facts, so that a short file cannot become a large domain.
const PARTS: usize = 200_000;

/// The nesting of a definition, so that conditions cannot exhaust the stack.
const DEPTH: usize = 200;

/// The rules of a predicate: the section, the head and the condition.
type Rules<'e> = Vec<(&'e Expression, &'e Expression, &'e Expression)>;

impl Reader<'_> {
    /// Parses the `(:derived (predicate ?x - type) CONDITION)` sections, each after those that it refers to.
    pub(super) fn derived<'e>(
        &mut self,
        sections: impl Iterator<Item = (&'e Expression, &'e [Expression])>,
        semantics: &mut Semantics,
    ) {
        let mut rules: FxHashMap<&str, Rules<'e>> = FxHashMap::default();
        let mut names: Vec<&str> = Vec::new();
        for (section, items) in sections {
            let head = items.first().and_then(|head| head.list()?.first()?.word());
            let ([atom, condition], Some(name)) = (items, head) else {
                let hint = "write `(:derived (predicate ?x - type) CONDITION)`";
                self.report(section.position, "this derived predicate cannot be read", hint);
                continue;
            };
            if !semantics.predicates.iter().any(|own| own.name == name) {
                self.predicate(atom, semantics);
            }
            let own = rules.entry(name).or_default();
            if own.is_empty() {
                names.push(name);
            }
            own.push((section, atom, condition));
        }
        let mut order = TopologicalSort {
            rules: &rules,
            done: FxHashSet::default(),
            open: Vec::new(),
            sorted: Vec::new(),
            cycles: Vec::new(),
        };
        names.iter().for_each(|name| order.visit(name));
        let (sorted, cycles) = (order.sorted, order.cycles);
        for (name, on) in cycles {
            let position = rules[name][0].0.position;
            let message =
                format!("the derived predicate `{name}` depends on itself (by `{on}`), which is not supported");
            let hint = format!(
                "give the facts of `{name}` in the problem if no action changes them, or let the effects of actions keep `{name}` up to date"
            );
            self.report(position, message, hint);
        }
        for name in sorted {
            self.definition(name, &rules[name], semantics);
        }
    }

    /// Parses the rules of one derived predicate.
    fn definition(&mut self, name: &str, rules: &Rules<'_>, semantics: &mut Semantics) {
        let Some(index) = semantics.predicates.iter().position(|own| own.name == name) else {
            return;
        };
        let mut ways = Vec::with_capacity(rules.len());
        for (_, atom, condition) in rules {
            let variables = atom.list().map_or(&[][..], |items| &items[1..]);
            let parameters = self.variables(variables, &semantics.types);
            let declared: Vec<TypeId> = semantics.predicates[index]
                .parameters
                .iter()
                .map(|own| own.kind)
                .collect();
            if parameters.len() != declared.len() {
                let message = format!(
                    "`{name}` takes {} argument(s), not {}",
                    declared.len(),
                    parameters.len()
                );
                self.report(
                    atom.position,
                    message,
                    "use the variables of its declaration in `(:predicates ...)`",
                );
                continue;
            }
            let mut scope: Scope = parameters.iter().map(|own| (own.name.clone(), own.kind)).collect();
            let mut parts = vec![self.condition(condition, &mut scope, semantics)];
            for (slot, (own, declared)) in parameters.iter().zip(declared).enumerate() {
                if !semantics.types.is_a(declared, own.kind) {
                    parts.insert(0, is_of(Term::Variable(slot), own.kind, parameters.len()));
                }
            }
            ways.push(Condition::And(parts));
        }
        let condition = Condition::Or(ways);
        if extent(&condition).1 > DEPTH {
            let message = format!("the definition of `{name}` is nested more than {DEPTH} deep when it is written out");
            let hint = "define fewer predicates by others, or give their facts in the problem";
            return self.report(rules[0].0.position, message, hint);
        }
        semantics.derived.push(DerivedPredicate {
            predicate: PredicateId::new(index),
            condition,
        });
    }

    /// Returns the condition that defines a fact, if its predicate is derived.
    pub(super) fn defined(
        &mut self,
        item: &Expression,
        atom: &Atom,
        scope: &Scope,
        names: &Semantics,
    ) -> Option<Condition> {
        let derived = names.derived.iter().find(|own| own.predicate == atom.predicate)?;
        self.expanded += extent(&derived.condition).0;
        if self.expanded > PARTS {
            let message = "the derived predicates are too large when they are written out";
            self.report(
                item.position,
                message,
                "define fewer of them by others, or give their facts in the problem",
            );
            return Some(Condition::TRUE);
        }
        let parameters = &names.predicates[atom.predicate.index()].parameters;
        let mut parts = Vec::new();
        for (term, parameter) in atom.terms.iter().zip(parameters) {
            let kind = match term {
                Term::Variable(slot) => scope[*slot].1,
                Term::Constant(constant) => names.constants[constant.index()].1,
            };
            if !names.types.is_a(kind, parameter.kind) {
                parts.push(is_of(*term, parameter.kind, scope.len()));
            }
        }
        let arity = parameters.len();
        let slot = |slot: usize| slot - arity + scope.len();
        let term = |term: Term| match term {
            Term::Variable(variable) => match atom.terms.get(variable) {
                Some(term) => *term,
                None => Term::Variable(slot(variable)),
            },
            constant @ Term::Constant(_) => constant,
        };
        let own = derived.condition.clone().with_terms(&slot, &term);
        if parts.is_empty() {
            return Some(own);
        }
        parts.push(own);
        Some(Condition::And(parts))
    }
}

/// Returns the number of parts of a condition, and how deep they are nested.
fn extent(condition: &Condition) -> (usize, usize) {
    condition
        .parts()
        .iter()
        .map(extent)
        .fold((1, 1), |(parts, depth), (others, below)| {
            (parts + others, depth.max(below + 1))
        })
}

/// Returns the condition that an entity is of a type; `slot` is free.
pub(super) fn is_of(term: Term, kind: TypeId, slot: usize) -> Condition {
    let equal = Condition::Equal {
        left: Term::Variable(slot),
        right: term,
        holds: true,
    };
    Condition::Exists(slot, kind, Box::new(equal))
}

/// The search for an order in which each predicate comes after those that it depends on.
struct TopologicalSort<'r, 'e> {
    rules: &'r FxHashMap<&'e str, Rules<'e>>,
    done: FxHashSet<&'e str>,
    open: Vec<&'e str>,
    sorted: Vec<&'e str>,
    /// Predicates that depend on themselves, with the predicate before them in the cycle.
    cycles: Vec<(&'e str, &'e str)>,
}

/// The longest chain of derived predicates, so that a hostile file cannot exhaust the stack.
const CHAIN: usize = 200;

impl<'e> TopologicalSort<'_, 'e> {
    fn visit(&mut self, name: &'e str) {
        if self.open.contains(&name) || self.open.len() > CHAIN {
            let on = self.open.last().copied().unwrap_or(name);
            self.cycles.push((name, on));
            return;
        }
        if !self.done.insert(name) {
            return;
        }
        self.open.push(name);
        let mut heads = Vec::new();
        for (_, _, condition) in &self.rules[name] {
            heads_of(condition, &mut heads);
        }
        for head in heads {
            if self.rules.contains_key(head) {
                self.visit(head);
            }
        }
        self.open.pop();
        self.sorted.push(name);
    }
}

/// Collects the first words of all lists.
fn heads_of<'e>(expression: &'e Expression, heads: &mut Vec<&'e str>) {
    if let Some(items) = expression.list() {
        heads.extend(items.first().and_then(Expression::word));
        items.iter().for_each(|item| heads_of(item, heads));
    }
}
