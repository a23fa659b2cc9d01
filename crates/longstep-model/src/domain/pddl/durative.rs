//! Durative actions as actions: one step after another, an action may begin where its conditions hold at the start, and all
//! that has to hold until its end.
//!
//! The condition is the one at the start, with those over all and at the end, without what the effects at the start bring about.
//! The effect is that of the start and then that of the end. A constant duration is the cost of a step.

use crate::diagnostic::{Diagnostic, Position};
use crate::domain::sexpr::{Expression, ExpressionKind};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Time {
    Start,
    All,
    End,
}

type Timed = Vec<(Time, Expression)>;

/// Rewrites the durative actions of a domain's sections.
///
/// `problem` tells how large the durations are, if it is known.
pub(super) fn adapt(
    file: &str,
    sections: &mut Vec<Expression>,
    problem: Option<&Expression>,
    notes: &mut Vec<Diagnostic>,
) {
    let is_durative = |own: &Expression| own.tail_of(":durative-action").is_some();
    let Some(first) = sections.iter().find(|own| is_durative(own)) else {
        return;
    };
    let mut message =
        "durative actions are read as steps one after another: conditions over all and at the end hold before a step"
            .to_owned();
    let is_costly = |own: &Expression| mentions(own, "total-cost") || own.tail_of(":action").is_some();
    let mut changed = Vec::new();
    sections.iter().for_each(|own| changed_numbers(own, &mut changed));
    let durations = sections.iter().filter_map(|own| own.tail_of(":durative-action"));
    let mut durations = durations.map(|items| duration(items).is_some_and(|own| is_fixed(&own, &changed, problem)));
    let costs = durations.all(|is_fixed| is_fixed) && !sections.iter().any(is_costly);
    message.push_str(if costs { "; their durations are costs" } else { "; durations are no costs, since some change, are computed, or differ too much to be added up, or costs are there already" });
    notes.push(Diagnostic::at(file, first.position, message));
    for section in sections.iter_mut() {
        if let Some(items) = section.tail_of(":durative-action") {
            *section = action(items, section.position, costs);
        }
    }
    if costs {
        let place = sections[0].position;
        let functions = || Expression::of_items(vec![Expression::of_word("total-cost", place)], place);
        match sections.iter_mut().find(|own| own.tail_of(":functions").is_some()) {
            Some(Expression {
                kind: ExpressionKind::List(items),
                ..
            }) => items.insert(1, functions()),
            _ => {
                let section = Expression::of_items(vec![Expression::of_word(":functions", place), functions()], place);
                let after = sections.iter().rposition(|own| own.tail_of(":predicates").is_some());
                sections.insert(after.map_or(sections.len(), |after| after + 1), section);
            }
        }
    }
}

fn mentions(expression: &Expression, name: &str) -> bool {
    match &expression.kind {
        ExpressionKind::Word(word) => word == name,
        ExpressionKind::List(items) => items.iter().any(|item| mentions(item, name)),
    }
}

fn field<'a>(items: &'a [Expression], key: &str) -> Option<&'a Expression> {
    let place = items.iter().position(|item| item.word() == Some(key))?;
    items.get(place + 1)
}

/// Collects the numbers that effects change.
fn changed_numbers<'e>(expression: &'e Expression, changed: &mut Vec<&'e str>) {
    let Some(items) = expression.list() else { return };
    let words: Vec<Option<&str>> = items.iter().map(Expression::word).collect();
    if let (
        [
            Some("increase" | "decrease" | "assign" | "scale-up" | "scale-down"),
            _,
            _,
        ],
        [_, fluent, _],
    ) = (&words[..], items)
    {
        let name = fluent.word().or_else(|| fluent.list()?.first()?.word());
        changed.extend(name);
    }
    items.iter().for_each(|item| changed_numbers(item, changed));
}

/// The largest duration that may be a cost, in units of its last decimal: search adds costs up exactly.
const LARGEST: f64 = 400_000.0;

/// Returns true for a duration that may be a cost: a number, a function that no action changes, or a sum of them.
fn is_fixed(duration: &Expression, changed: &[&str], problem: Option<&Expression>) -> bool {
    let Some((head, rest)) = duration.list().and_then(<[_]>::split_first) else {
        return duration
            .word()
            .is_some_and(|own| own.parse::<f64>().is_ok_and(|own| own >= 0.0));
    };
    match head.word() {
        Some("+") => rest.iter().all(|part| is_fixed(part, changed, problem)),
        Some("*" | "-" | "/") | None => false,
        Some(name) => !changed.contains(&name) && problem.is_none_or(|problem| is_small(name, problem)),
    }
}

/// Returns true if the numbers that a problem gives for a function can be added up exactly.
fn is_small(function: &str, problem: &Expression) -> bool {
    let sections = problem.tail_of("define").unwrap_or_default();
    let facts = sections.iter().filter_map(|section| section.tail_of(":init")).flatten();
    let values = facts.filter_map(|fact| match fact.tail_of("=")? {
        [fluent, value] if fluent.tail_of(function).is_some() => value.word(),
        _ => None,
    });
    let (mut greatest, mut places) = (0.0_f64, 0);
    for value in values {
        greatest = greatest.max(value.parse().unwrap_or(f64::INFINITY));
        let decimals = value.split_once('.').map_or("", |(_, decimals)| decimals);
        places = places.max(decimals.trim_end_matches('0').len());
    }
    i32::try_from(places).is_ok_and(|places| greatest * 10_f64.powi(places) <= LARGEST)
}

/// The shortest duration; the longest if it is only limited from above.
fn duration(items: &[Expression]) -> Option<Expression> {
    let constraint = field(items, ":duration")?;
    bound(constraint, &["=", ">=", ">"]).or_else(|| bound(constraint, &["<=", "<"]))
}

/// Returns the side of the first comparison of `?duration` by one of the symbols.
fn bound(constraint: &Expression, symbols: &[&str]) -> Option<Expression> {
    let parts = constraint.list()?;
    match parts.first()?.word()? {
        "and" => parts[1..].iter().find_map(|part| bound(part, symbols)),
        "at" => bound(parts.get(2)?, symbols),
        symbol if symbols.contains(&symbol) && parts.get(1)?.word() == Some("?duration") => parts.get(2).cloned(),
        _ => None,
    }
}

fn action(items: &[Expression], position: Position, costs: bool) -> Expression {
    let duration = duration(items);
    let timed = |key: &str| {
        let mut found = Timed::new();
        if let Some(own) = field(items, key) {
            collect(own, &|inner| inner, &mut found);
        }
        found
    };
    let mut conditions = timed(":condition");
    conditions.extend(timed(":precondition"));
    let effects = timed(":effect");
    let brought: Vec<&Expression> = of(&effects, Time::Start).collect();
    let is_brought = |condition: &Expression| brought.iter().any(|own| own.is_same(condition));
    let needed = conditions
        .iter()
        .filter(|(time, condition)| *time == Time::Start || !is_brought(condition))
        .map(|(_, condition)| condition.clone());
    let needed: Vec<Expression> = needed.collect();
    let last: Vec<&Expression> = effects
        .iter()
        .filter(|(time, _)| *time != Time::Start)
        .map(|(_, own)| own)
        .collect();
    let is_overwritten = |own: &Expression| {
        last.iter()
            .any(|other| atom(own).is_same(atom(other)) && is_literal(own))
    };
    let first = brought
        .iter()
        .filter(|own| !is_overwritten(own))
        .map(|own| (**own).clone());
    // What the start takes and the end gives back, such as a free robot, is no change.
    let is_given_back = |own: &Expression| {
        let mut taken = brought.iter().filter(|start| atom(start).is_same(atom(own)));
        taken.next().is_some() && is_literal(own) && needed.iter().any(|condition| condition.is_same(own))
    };
    let last = last.iter().filter(|own| !is_given_back(own)).map(|own| (*own).clone());
    let mut changes: Vec<Expression> = first.chain(last).collect();
    if let (true, Some(duration)) = (costs, &duration) {
        let total = Expression::of_items(vec![Expression::of_word("total-cost", position)], position);
        changes.push(Expression::of_items(
            vec![Expression::of_word("increase", position), total, duration.clone()],
            position,
        ));
    }
    let both = |parts: Vec<Expression>| {
        Expression::of_items([vec![Expression::of_word("and", position)], parts].concat(), position)
    };
    let none = || Expression::of_items(Vec::new(), position);
    let name = items.first().cloned().unwrap_or_else(none);
    let mut all = vec![
        Expression::of_word(":action", position),
        name,
        Expression::of_word(":parameters", position),
        field(items, ":parameters").cloned().unwrap_or_else(none),
        Expression::of_word(":precondition", position),
        both(needed),
        Expression::of_word(":effect", position),
        both(changes),
    ];
    if let Some(duration) = &duration {
        all.iter_mut().for_each(|own| substitute(own, duration));
    }
    Expression::of_items(all, position)
}

fn of(effects: &Timed, time: Time) -> impl Iterator<Item = &Expression> {
    effects.iter().filter(move |(own, _)| *own == time).map(|(_, own)| own)
}

/// Collects the parts of a condition or an effect with their times.
fn collect(expression: &Expression, wrap: &dyn Fn(Expression) -> Expression, found: &mut Timed) {
    let Some(items) = expression.list() else { return };
    let place = expression.position;
    let words: Vec<Option<&str>> = items.iter().map(Expression::word).collect();
    match (&words[..], items) {
        ([Some("and"), ..], _) => items[1..].iter().for_each(|item| collect(item, wrap, found)),
        ([Some("at"), Some("start"), None], [_, _, inner]) => add(Time::Start, inner, wrap, found),
        ([Some("at"), Some("end"), None], [_, _, inner]) => add(Time::End, inner, wrap, found),
        ([Some("over"), Some("all"), None], [_, _, inner]) => add(Time::All, inner, wrap, found),
        ([Some("forall"), None, None], [head, variables, inner]) => {
            let forall =
                |own: Expression| wrap(Expression::of_items(vec![head.clone(), variables.clone(), own], place));
            collect(inner, &forall, found);
        }
        ([Some("when"), None, None], [head, condition, effect]) => {
            let mut conditions = Timed::new();
            collect(condition, &|own| own, &mut conditions);
            let parts = conditions.into_iter().map(|(_, own)| own);
            let condition = Expression::of_items(
                std::iter::once(Expression::of_word("and", place))
                    .chain(parts)
                    .collect(),
                place,
            );
            let when = |own: Expression| wrap(Expression::of_items(vec![head.clone(), condition.clone(), own], place));
            collect(effect, &when, found);
        }
        ([], _) => {}
        // Without a time: as at the start.
        _ => found.push((Time::Start, wrap(expression.clone()))),
    }
}

/// Adds the parts of a condition or an effect of one time.
fn add(time: Time, inner: &Expression, wrap: &dyn Fn(Expression) -> Expression, found: &mut Timed) {
    match inner.tail_of("and") {
        Some(parts) => parts.iter().for_each(|part| add(time, part, wrap, found)),
        None => found.push((time, wrap(inner.clone()))),
    }
}

/// The atom of a literal.
fn atom(literal: &Expression) -> &Expression {
    match literal.tail_of("not") {
        Some([atom]) => atom,
        _ => literal,
    }
}

fn is_literal(effect: &Expression) -> bool {
    let head = atom(effect).list().and_then(|items| items.first()?.word());
    !matches!(
        head,
        Some("when" | "forall" | "increase" | "decrease" | "assign" | "scale-up" | "scale-down") | None
    )
}

fn substitute(expression: &mut Expression, duration: &Expression) {
    match &mut expression.kind {
        ExpressionKind::Word(word) if word == "?duration" => *expression = duration.clone(),
        ExpressionKind::Word(_) => {}
        ExpressionKind::List(items) => items.iter_mut().for_each(|item| substitute(item, duration)),
    }
}
