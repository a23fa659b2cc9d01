//! Declarations of a domain file of others: names that are used without a declaration, and names that are declared twice.

use indexmap::IndexMap;
use rustc_hash::FxHashSet;

use super::TOTAL_COST;
use crate::diagnostic::{Diagnostic, Position, nearest};
use crate::domain::sexpr::{Expression, ExpressionKind};

/// Words with a meaning of their own in conditions and effects.
const CONNECTIVES: [&str; 8] = ["and", "or", "not", "imply", "when", "forall", "exists", "="];

/// Words whose arguments are numbers.
const NUMERIC: [&str; 13] = [
    "<",
    ">",
    "<=",
    ">=",
    "increase",
    "decrease",
    "assign",
    "scale-up",
    "scale-down",
    "+",
    "-",
    "*",
    "/",
];

/// Completes the declarations of a domain's sections, with a note for each.
pub(super) fn adapt(file: &str, sections: &mut Vec<Expression>, notes: &mut Vec<Diagnostic>) {
    repeated_parameters(file, sections, notes);
    declare_types(file, sections, notes);
    repeated_constants(file, sections, notes);
    declare_derived(file, sections, notes);
    repeated_predicates(file, sections, notes);
    repeated_actions(file, sections, notes);
    declare_predicates(file, sections, notes);
    declare_cost(file, sections, notes);
}

/// Adds items to a section, which is created if there is none.
fn extend(sections: &mut Vec<Expression>, head: &str, items: Vec<Expression>, position: Position) {
    let own = sections.iter_mut().find(|section| section.tail_of(head).is_some());
    if let Some(Expression {
        kind: ExpressionKind::List(own),
        ..
    }) = own
    {
        // A list of types may end with names without a type, so the new ones come first.
        own.splice(1..1, items);
        return;
    }
    let word = Expression::of_word(head, position);
    let section = Expression::of_items(std::iter::once(word).chain(items).collect(), position);
    // Behind `define` and the name.
    sections.insert(sections.len().min(2), section);
}

/// Declares types that are used and not declared, unless the name is probably misspelt.
fn declare_types(file: &str, sections: &mut Vec<Expression>, notes: &mut Vec<Diagnostic>) {
    let mut used: IndexMap<&str, Position> = IndexMap::new();
    for section in sections.iter() {
        types_of(section, &mut used);
    }
    let of_types = sections
        .iter()
        .filter_map(|section| section.tail_of(":types"))
        .flatten();
    let declared: FxHashSet<&str> = of_types
        .filter_map(Expression::word)
        .chain(["object", "number"])
        .collect();
    used.retain(|name, _| !declared.contains(name) && nearest(name, declared.iter().copied()).is_none());
    let mut items = Vec::new();
    for (name, position) in &used {
        let message = format!("the type `{name}` is not declared; it is read as a type of its own");
        notes.push(Diagnostic::at(file, *position, message));
        items.extend([name, "-", "object"].map(|word| Expression::of_word(word, *position)));
    }
    if let Some(position) = used.values().next().copied() {
        extend(sections, ":types", items, position);
    }
}

/// Collects the types that typed lists name.
fn types_of<'e>(expression: &'e Expression, used: &mut IndexMap<&'e str, Position>) {
    let Some(items) = expression.list() else { return };
    if matches!(
        items.first().and_then(Expression::word),
        Some(":types" | ":requirements" | "-")
    ) {
        return;
    }
    for pair in items.windows(2) {
        let [dash, kind] = pair else { continue };
        if dash.word() != Some("-") {
            continue;
        }
        let members = match kind.tail_of("either") {
            Some(members) => members,
            None => std::slice::from_ref(kind),
        };
        for member in members {
            if let Some(name) = member.word() {
                used.entry(name).or_insert(member.position);
            }
        }
    }
    items.iter().for_each(|item| types_of(item, used));
}

/// Numbers the parameters of a predicate or a function that share a name: nothing refers to them by it.
fn repeated_parameters(file: &str, sections: &mut [Expression], notes: &mut Vec<Diagnostic>) {
    for section in sections.iter_mut() {
        if section.tail_of(":predicates").is_none() && section.tail_of(":functions").is_none() {
            continue;
        }
        let ExpressionKind::List(declarations) = &mut section.kind else {
            continue;
        };
        for declaration in declarations {
            let ExpressionKind::List(items) = &mut declaration.kind else {
                continue;
            };
            let mut taken: FxHashSet<String> = FxHashSet::default();
            for (index, item) in items.iter_mut().enumerate() {
                let Some(name) = item.word().filter(|name| name.starts_with('?')) else {
                    continue;
                };
                if taken.insert(name.to_owned()) {
                    continue;
                }
                let mut other = format!("{name}-{index}");
                while !taken.insert(other.clone()) {
                    other.push_str("-b");
                }
                let message = format!("the parameter `{name}` is declared twice; this one is called `{other}`");
                notes.push(Diagnostic::at(file, item.position, message));
                *item = Expression::of_word(&other, item.position);
            }
        }
    }
}

/// Leaves out a constant that is declared again with the same type.
fn repeated_constants(file: &str, sections: &mut [Expression], notes: &mut Vec<Diagnostic>) {
    let mut known: IndexMap<String, Expression> = IndexMap::new();
    for section in sections
        .iter_mut()
        .filter(|section| section.tail_of(":constants").is_some())
    {
        let ExpressionKind::List(items) = &mut section.kind else {
            continue;
        };
        *items = distinct(file, std::mem::take(items), &mut known, notes);
    }
}

/// Leaves out names of a typed list that it has already with the same type; the first item is the head of the section.
pub(super) fn distinct(
    file: &str,
    items: Vec<Expression>,
    known: &mut IndexMap<String, Expression>,
    notes: &mut Vec<Diagnostic>,
) -> Vec<Expression> {
    let mut result = Vec::with_capacity(items.len());
    let mut items = items.into_iter();
    result.extend(items.next());
    let list: Vec<Expression> = items.collect();
    let untyped = Expression::of_word("object", Position { line: 1, column: 1 });
    for (names, kind) in groups(&list) {
        let before = result.len();
        for name in names {
            let word = name.word().unwrap_or_default();
            match known.get(word) {
                Some(own) if own.is_same(kind.unwrap_or(&untyped)) => {
                    let message = format!("`{word}` is declared twice; it is read as one");
                    notes.push(Diagnostic::at(file, name.position, message));
                    continue;
                }
                Some(_) => {}
                None => {
                    known.insert(word.to_owned(), kind.unwrap_or(&untyped).clone());
                }
            }
            result.push(name.clone());
        }
        if let Some(kind) = kind.filter(|_| result.len() > before) {
            result.extend([Expression::of_word("-", kind.position), kind.clone()]);
        }
    }
    result
}

/// Returns the names of a typed list by the types that follow them; the last may have none.
fn groups(items: &[Expression]) -> Vec<(&[Expression], Option<&Expression>)> {
    let mut groups = Vec::new();
    let mut begin = 0;
    for (index, item) in items.iter().enumerate() {
        if item.word() == Some("-") && index >= begin {
            groups.push((&items[begin..index], items.get(index + 1)));
            begin = (index + 2).min(items.len());
        }
    }
    if begin < items.len() {
        groups.push((&items[begin..], None));
    }
    groups
}

/// Declares derived predicates that only their rules name, for the types of all rules.
fn declare_derived(file: &str, sections: &mut Vec<Expression>, notes: &mut Vec<Diagnostic>) {
    let declared = sections
        .iter()
        .filter_map(|section| section.tail_of(":predicates"))
        .flatten();
    let head = |atom: &Expression| atom.list()?.first()?.word().map(str::to_owned);
    let declared: FxHashSet<String> = declared.filter_map(head).collect();
    let mut heads: IndexMap<String, Expression> = IndexMap::new();
    for atom in sections
        .iter()
        .filter_map(|section| section.tail_of(":derived")?.first())
    {
        let Some(name) = head(atom).filter(|name| !declared.contains(name)) else {
            continue;
        };
        let parameters = typed_parameters(&atom.list().unwrap_or_default()[1..]);
        match heads.get_mut(&name) {
            Some(known) if known.list().map(|own| typed_parameters(&own[1..]).len()) == Some(parameters.len()) => {
                widen(known, &parameters);
            }
            // Another number of arguments is an error where the rule is read.
            Some(_) => {}
            None => {
                let message = format!("the derived predicate `{name}` is not declared; its rules declare it");
                notes.push(Diagnostic::at(file, atom.position, message));
                heads.insert(name, atom.clone());
            }
        }
    }
    if let Some(position) = heads.values().next().map(|atom| atom.position) {
        extend(sections, ":predicates", heads.into_values().collect(), position);
    }
}

/// Reads the declarations of one predicate as one that admits the types of all of them.
fn repeated_predicates(file: &str, sections: &mut [Expression], notes: &mut Vec<Diagnostic>) {
    let mut first: IndexMap<(String, usize), (usize, usize)> = IndexMap::new();
    for section in 0..sections.len() {
        let Some(count) = sections[section].tail_of(":predicates").map(<[_]>::len) else {
            continue;
        };
        let mut left_out = Vec::new();
        for place in 1..=count {
            let Some(own) = item_of(&sections[section], place).cloned() else {
                continue;
            };
            let Some((head, parameters)) = own.list().and_then(<[_]>::split_first) else {
                continue;
            };
            let Some(name) = head.word() else { continue };
            let parameters = typed_parameters(parameters);
            let known = *first
                .entry((name.to_owned(), parameters.len()))
                .or_insert((section, place));
            if known == (section, place) {
                continue;
            }
            let message = format!("the predicate `{name}` is declared twice; it is read as one for the types of both");
            notes.push(Diagnostic::at(file, head.position, message));
            left_out.push(place);
            if let ExpressionKind::List(sections) = &mut sections[known.0].kind {
                widen(&mut sections[known.1], &parameters);
            }
        }
        if let ExpressionKind::List(items) = &mut sections[section].kind {
            for place in left_out.into_iter().rev() {
                items.remove(place);
            }
        }
    }
}

fn item_of(section: &Expression, place: usize) -> Option<&Expression> {
    section.list()?.get(place)
}

/// Returns the variables of a declaration, each with the names of its types.
fn typed_parameters(items: &[Expression]) -> Vec<(Expression, Vec<Expression>)> {
    let mut parameters = Vec::new();
    for (names, kind) in groups(items) {
        let kinds = match kind.map(|kind| (kind, kind.tail_of("either"))) {
            Some((_, Some(members))) => members.to_vec(),
            Some((kind, None)) => vec![kind.clone()],
            None => Vec::new(),
        };
        parameters.extend(names.iter().map(|name| (name.clone(), kinds.clone())));
    }
    parameters
}

/// Adds the types of other parameters to those of a declaration. A parameter without a type admits everything.
fn widen(declaration: &mut Expression, others: &[(Expression, Vec<Expression>)]) {
    let ExpressionKind::List(items) = &mut declaration.kind else {
        return;
    };
    let own = typed_parameters(&items[1..]);
    items.truncate(1);
    for ((name, mut kinds), (_, other)) in own.into_iter().zip(others) {
        let place = name.position;
        if kinds.is_empty() || other.is_empty() {
            kinds = vec![Expression::of_word("object", place)];
        } else {
            let is_new = |kind: &&Expression| !kinds.iter().any(|own| own.is_same(kind));
            let more: Vec<Expression> = other.iter().filter(is_new).cloned().collect();
            kinds.extend(more);
        }
        let kind = match &kinds[..] {
            [only] => only.clone(),
            _ => Expression::of_items([vec![Expression::of_word("either", place)], kinds].concat(), place),
        };
        items.extend([name, Expression::of_word("-", place), kind]);
    }
}

/// Numbers actions that share a name, and leaves out those that are equal.
fn repeated_actions(file: &str, sections: &mut Vec<Expression>, notes: &mut Vec<Diagnostic>) {
    let name_of = |section: &Expression| section.tail_of(":action")?.first()?.word().map(str::to_owned);
    let mut taken: FxHashSet<String> = sections.iter().filter_map(name_of).collect();
    let mut first: IndexMap<String, Vec<Expression>> = IndexMap::new();
    let mut kept = Vec::with_capacity(sections.len());
    for mut section in std::mem::take(sections) {
        let Some(name) = name_of(&section) else {
            kept.push(section);
            continue;
        };
        let known = first.entry(name.clone()).or_default();
        if known.iter().any(|own| own.is_same(&section)) {
            let message = format!("the action `{name}` is declared twice in the same way; it is read as one");
            notes.push(Diagnostic::at(file, section.position, message));
            continue;
        }
        known.push(section.clone());
        let count = known.len();
        if let (true, ExpressionKind::List(items)) = (count > 1, &mut section.kind) {
            let mut other = format!("{name}-{count}");
            while !taken.insert(other.clone()) {
                other.push_str("-b");
            }
            let position = items[1].position;
            let message = format!("the action `{name}` is declared twice; this one is called `{other}`");
            notes.push(Diagnostic::at(file, position, message));
            items[1] = Expression::of_word(&other, position);
        }
        kept.push(section);
    }
    *sections = kept;
}

/// A name that is used as a predicate.
struct Use {
    position: Position,
    arity: usize,
    is_ambiguous: bool,
}

/// Declares predicates that are used and not declared, unless the name is probably misspelt.
fn declare_predicates(file: &str, sections: &mut Vec<Expression>, notes: &mut Vec<Diagnostic>) {
    let mut used: IndexMap<&str, Use> = IndexMap::new();
    for section in sections.iter() {
        if let Some(fields) = section.tail_of(":action") {
            fields.iter().skip(1).for_each(|field| predicates_of(field, &mut used));
        } else if let Some([_, condition]) = section.tail_of(":derived") {
            predicates_of(condition, &mut used);
        }
    }
    let heads = |head: &'static str| {
        let items = sections
            .iter()
            .filter_map(move |section| section.tail_of(head))
            .flatten();
        items.filter_map(|item| item.list()?.first()?.word())
    };
    let declared: FxHashSet<&str> = heads(":predicates")
        .chain(heads(":functions"))
        .chain(heads(":derived"))
        .chain([TOTAL_COST])
        .collect();
    used.retain(|name, own| {
        !own.is_ambiguous && !declared.contains(name) && nearest(name, declared.iter().copied()).is_none()
    });
    let mut items = Vec::new();
    for (name, own) in &used {
        let message = format!(
            "the predicate `{name}` is not declared; it is read with {} argument(s) of any type",
            own.arity
        );
        notes.push(Diagnostic::at(file, own.position, message));
        let word = |word: &str| Expression::of_word(word, own.position);
        let variables = (1..=own.arity).map(|index| word(&format!("?x{index}")));
        items.push(Expression::of_items(
            std::iter::once(word(name)).chain(variables).collect(),
            own.position,
        ));
    }
    if let Some(first) = used.values().next().map(|own| own.position) {
        extend(sections, ":predicates", items, first);
    }
}

/// Collects the heads of the atoms in a condition or an effect.
fn predicates_of<'e>(expression: &'e Expression, used: &mut IndexMap<&'e str, Use>) {
    let Some((head, rest)) = expression.list().and_then(<[_]>::split_first) else {
        return;
    };
    match head.word() {
        Some("forall" | "exists") => rest.iter().skip(1).for_each(|item| predicates_of(item, used)),
        // Comparisons, also of two constants.
        Some("=" | "<" | "<=" | ">" | ">=") => {}
        Some(word) if CONNECTIVES.contains(&word) => rest.iter().for_each(|item| predicates_of(item, used)),
        Some(word) if NUMERIC.contains(&word) && rest.iter().any(|item| item.list().is_some()) => {}
        Some(word) if !word.starts_with(['?', ':', '-']) && rest.iter().all(|item| item.word().is_some()) => {
            let own = used.entry(word).or_insert(Use {
                position: head.position,
                arity: rest.len(),
                is_ambiguous: false,
            });
            own.is_ambiguous |= own.arity != rest.len();
        }
        _ => {}
    }
}

/// Declares `(total-cost)` if an effect increases it and nothing declares it.
fn declare_cost(file: &str, sections: &mut Vec<Expression>, notes: &mut Vec<Diagnostic>) {
    let mut functions = sections
        .iter()
        .filter_map(|section| section.tail_of(":functions"))
        .flatten();
    if functions.any(|own| {
        own.list().and_then(|items| items.first()?.word()) == Some(TOTAL_COST) || own.word() == Some(TOTAL_COST)
    }) {
        return;
    }
    let increased = sections.iter().filter(|section| section.tail_of(":action").is_some());
    let Some(position) = increased.filter_map(increase_of_cost).next() else {
        return;
    };
    notes.push(Diagnostic::at(
        file,
        position,
        "`(total-cost)` is not declared; it is read as the cost of a plan",
    ));
    let cost = Expression::of_items(vec![Expression::of_word(TOTAL_COST, position)], position);
    extend(sections, ":functions", vec![cost], position);
}

fn increase_of_cost(expression: &Expression) -> Option<Position> {
    if let Some([fluent, _]) = expression.tail_of("increase")
        && fluent.tail_of(TOTAL_COST).is_some_and(<[_]>::is_empty)
    {
        return Some(expression.position);
    }
    expression.list()?.iter().find_map(increase_of_cost)
}
