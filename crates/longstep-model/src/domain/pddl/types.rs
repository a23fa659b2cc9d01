//! Types, variables and the declarations of predicates.

use super::derived::is_of;
use super::{ARITY_LIMIT, Dialect, Reader, Semantics};
use crate::diagnostic::{Diagnostic, Position};
use crate::domain::sexpr::Expression;
use crate::domain::{Condition, Parameter, Predicate, Term, TypeId, Types};

/// The treatment of `(either ...)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Union {
    /// The parent must have no other types: objects must not get more of them.
    Exact,
    /// The parent may have others, which a condition excludes: variables of actions and quantifiers.
    Guarded,
    /// The parent may have others: a predicate or a function without facts about them is false or unknown for them.
    Wider,
}

/// An entry of a typed list.
struct Typed {
    name: String,
    kind: TypeId,
    /// The types that it may have, if its type admits others.
    members: Vec<TypeId>,
    position: Position,
}

impl Reader<'_> {
    pub(super) fn types(&mut self, items: &[Expression], types: &mut Types) {
        // A parent may be declared after its child, so all names come first.
        for item in items {
            match item.word() {
                Some("-") => {}
                Some(name) => {
                    types.intern(name);
                }
                None => self.report(
                    item.position,
                    "expected a type's name (`either` is not supported)",
                    "give a type one parent",
                ),
            }
        }
        let mut waiting = Vec::new();
        let mut words = items.iter();
        while let Some(item) = words.next() {
            match item.word() {
                Some("-") => {
                    let Some(parent) = words.next().and_then(Expression::word) else {
                        self.report(item.position, "`-` needs a type after it", "write `?x - type`");
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
                            self.report(item.position, message, "remove one of the two parents");
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
        let list = self.typed(items, types, Union::Exact);
        list.into_iter().map(|own| (own.name, own.kind, own.position)).collect()
    }

    fn typed(&mut self, items: &[Expression], types: &Types, union: Union) -> Vec<Typed> {
        let mut list: Vec<Typed> = Vec::new();
        let mut untyped = 0;
        let mut words = items.iter();
        while let Some(item) = words.next() {
            match item.word() {
                Some("-") => {
                    let Some(kind) = words.next() else {
                        self.report(item.position, "`-` needs a type after it", "write `?x - type`");
                        break;
                    };
                    if let Some((kind, members)) = self.type_of(kind, types, union) {
                        for entry in &mut list[untyped..] {
                            entry.kind = kind;
                            entry.members.clone_from(&members);
                        }
                    }
                    untyped = list.len();
                }
                Some(name) => list.push(Typed {
                    name: name.to_owned(),
                    kind: TypeId::OBJECT,
                    members: Vec::new(),
                    position: item.position,
                }),
                None => self.report(item.position, "expected a name", "check the parentheses before it"),
            }
        }
        list
    }

    /// Parses a type's name, or `(either ...)` as the common parent of its types, with these types if it admits others.
    /// Reports errors.
    fn type_of(&mut self, item: &Expression, types: &Types, union: Union) -> Option<(TypeId, Vec<TypeId>)> {
        let Some(members) = item.tail_of("either").filter(|members| !members.is_empty()) else {
            let name = item.word().unwrap_or("?");
            let found = types.find(name);
            if found.is_none() {
                self.report_unknown(item.position, "type", name, types.names());
            }
            return found.map(|kind| (kind, Vec::new()));
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
        let all = || (0..types.count()).map(TypeId::new);
        let is_common = |parent: &TypeId| kinds.iter().all(|kind| types.is_a(*kind, *parent));
        let is_lowest = |parent: &TypeId| all().filter(is_common).all(|other| types.is_a(*parent, other));
        let parent = all().filter(is_common).find(is_lowest).unwrap_or(TypeId::OBJECT);
        let is_leaf = |kind: TypeId| all().all(|other| other == kind || !types.is_a(other, kind));
        let others = all().filter(|kind| types.is_a(*kind, parent) && is_leaf(*kind));
        let mut others = others.filter(|leaf| !kinds.iter().any(|kind| types.is_a(*leaf, *kind)));
        match others.next() {
            Some(other) if union == Union::Exact => {
                let message = format!(
                    "an object has one type, and `(either ...)` names some of a parent's; `{}` would also admit `{}`",
                    types.name(parent),
                    types.name(other)
                );
                let position = self.place(item.position);
                self.findings
                    .push(Diagnostic::at(self.file, position, message).hint("write the one type that the object has"));
                None
            }
            Some(_) if union == Union::Guarded => Some((parent, kinds)),
            _ => Some((parent, Vec::new())),
        }
    }

    /// Parses variables like [`Self::typed_list`]; requires and removes the leading `?`.
    pub(crate) fn variables(&mut self, items: &[Expression], types: &Types) -> Vec<Parameter> {
        self.variables_of(items, types, Union::Exact).0
    }

    /// Parses the variables of an action or a quantifier, and the condition that those with `(either ...)` have one of its
    /// types. `outer` is the number of variables around them.
    pub(super) fn guarded(
        &mut self,
        items: &[Expression],
        types: &Types,
        outer: usize,
    ) -> (Vec<Parameter>, Vec<Condition>) {
        let (variables, members) = self.variables_of(items, types, Union::Guarded);
        let free = outer + variables.len();
        let is_member = |(index, kinds): (usize, Vec<TypeId>)| {
            let one = kinds
                .into_iter()
                .map(|kind| is_of(Term::Variable(outer + index), kind, free));
            Condition::Or(one.collect())
        };
        let unions = members.into_iter().enumerate().filter(|(_, kinds)| !kinds.is_empty());
        (variables, unions.map(is_member).collect())
    }

    fn variables_of(
        &mut self,
        items: &[Expression],
        types: &Types,
        union: Union,
    ) -> (Vec<Parameter>, Vec<Vec<TypeId>>) {
        let mut variables: Vec<Parameter> = Vec::new();
        let mut unions = Vec::new();
        for Typed {
            name,
            kind,
            members,
            position,
        } in self.typed(items, types, union)
        {
            match name.strip_prefix('?') {
                Some(name) if variables.iter().any(|known| known.name == name) => {
                    let message = format!("`?{name}` is declared twice");
                    self.report(position, message, "give one of them another name");
                }
                Some(name) => {
                    variables.push(Parameter {
                        name: name.to_owned(),
                        kind,
                    });
                    unions.push(members);
                }
                None => {
                    let message = format!("`{name}` must be a variable, as in `?{name}`");
                    self.report(
                        position,
                        message,
                        format!("write `?{name}`, or `- {name}` if it is a type"),
                    );
                }
            }
        }
        (variables, unions)
    }

    pub(super) fn predicate(&mut self, item: &Expression, semantics: &mut Semantics) {
        let Some([head, parameters @ ..]) = item.list() else {
            return self.report(
                item.position,
                "expected `(predicate ?x - type)`",
                "write the declaration in parentheses",
            );
        };
        let Some(name) = head.word() else {
            return self.report(
                head.position,
                "expected a predicate's name",
                "write `(predicate ?x - type)`",
            );
        };
        if semantics.predicates.iter().any(|p| p.name == name) {
            let message = format!("the predicate `{name}` is declared twice");
            return self.report(head.position, message, "give one of them another name");
        }
        if let Some(predicate) = self.declaration(head, name, parameters, &semantics.types) {
            semantics.predicate_positions.push(head.position);
            semantics.predicates.push(predicate);
        }
    }

    /// Parses the parameters of a new predicate or function; reports errors.
    pub(super) fn declaration(
        &mut self,
        head: &Expression,
        name: &str,
        parameters: &[Expression],
        types: &Types,
    ) -> Option<Predicate> {
        let parameters = self.variables_of(parameters, types, Union::Wider).0;
        if parameters.len() > ARITY_LIMIT {
            let message = format!("`{name}` has more than {ARITY_LIMIT} arguments");
            self.report(head.position, message, "leave out some, or split it into two");
            return None;
        }
        Some(Predicate {
            name: name.to_owned(),
            parameters,
        })
    }
}
