//! PDDL of others: what is written in another way than this library reads is rewritten, with a note.

use rustc_hash::FxHashSet;

use super::{REQUIREMENTS, TOTAL_COST, declarations, durative};
use crate::diagnostic::{Diagnostic, Position};
use crate::domain::sexpr::{self, Expression, ExpressionKind};

/// A file as this library reads it.
pub(crate) struct Adapted {
    pub(crate) expressions: Vec<Expression>,
    /// The rewritten and the omitted parts.
    pub(crate) notes: Vec<Diagnostic>,
    /// True if the expressions are not those of the text.
    pub(crate) is_rewritten: bool,
}

/// Reads a domain file of any origin, and its problem if that is known.
pub(crate) fn read(file: &str, text: &str, problem: Option<&Expression>) -> Result<Adapted, Diagnostic> {
    let mut notes = Vec::new();
    let (mut expressions, mut is_rewritten) = parsed(file, text, &mut notes)?;
    let as_parsed = expressions.clone();
    if expressions.len() > 1
        && expressions.iter().any(|own| is_of(own, "domain"))
        && expressions.iter().any(|own| is_of(own, "problem"))
    {
        notes.push(note(
            file,
            &expressions[0],
            "the file has a problem too; only the domain is read here",
        ));
        expressions.retain(|own| !is_of(own, "problem"));
    }
    if let Some(define) = expressions.first_mut() {
        if let Some(problem) = problem {
            declare_constants(file, define, problem, &mut notes);
        }
        adapt(file, define, problem, &mut notes);
    }
    let mut pairs = expressions.iter().zip(&as_parsed);
    is_rewritten |= expressions.len() != as_parsed.len() || pairs.any(|(own, parsed)| !own.is_same(parsed));
    Ok(Adapted {
        expressions,
        notes,
        is_rewritten,
    })
}

/// Reads a problem file of any origin.
pub(crate) fn read_problem(file: &str, text: &str) -> Result<Adapted, Diagnostic> {
    let mut notes = Vec::new();
    let (mut expressions, is_rewritten) = parsed(file, text, &mut notes)?;
    if expressions.iter().any(|own| is_of(own, "problem")) {
        expressions.retain(|own| !is_of(own, "domain"));
    }
    if let Some(ExpressionKind::List(sections)) = expressions.first_mut().map(|define| &mut define.kind) {
        let mut known = indexmap::IndexMap::new();
        for section in sections
            .iter_mut()
            .filter(|section| section.tail_of(":objects").is_some())
        {
            let ExpressionKind::List(items) = &mut section.kind else {
                continue;
            };
            *items = declarations::distinct(file, std::mem::take(items), &mut known, &mut notes);
        }
    }
    Ok(Adapted {
        expressions,
        notes,
        is_rewritten,
    })
}

/// Declares the objects of a problem that the actions of a domain name and that it does not declare as constants.
fn declare_constants(file: &str, define: &mut Expression, problem: &Expression, notes: &mut Vec<Diagnostic>) {
    let (Some(sections), Some(of_problem)) = (define.tail_of("define"), problem.tail_of("define")) else {
        return;
    };
    let mut used = FxHashSet::default();
    let is_behaviour = |section: &&Expression| {
        let head = section.list().and_then(|items| items.first()?.word());
        matches!(head, Some(":action" | ":durative-action" | ":derived"))
    };
    for section in sections.iter().filter(is_behaviour) {
        words(section, &mut used);
    }
    let declared = sections
        .iter()
        .filter_map(|section| section.tail_of(":constants"))
        .flatten();
    for name in declared.filter_map(Expression::word) {
        used.remove(name);
    }
    let mut items = vec![Expression::of_word(":constants", define.position)];
    for objects in of_problem.iter().filter_map(|section| section.tail_of(":objects")) {
        let mut waiting = Vec::new();
        let mut objects = objects.iter();
        while let Some(item) = objects.next() {
            match item.word() {
                Some("-") => {
                    if let Some(kind) = objects.next().filter(|_| !waiting.is_empty()) {
                        items.append(&mut waiting);
                        items.extend([item.clone(), kind.clone()]);
                    }
                }
                Some(name) if used.contains(name) => waiting.push(item.clone()),
                _ => {}
            }
        }
        items.append(&mut waiting);
    }
    if items.len() > 1 {
        let position = define.position;
        let message = "objects of the problem that the actions name are read as constants of the domain";
        notes.push(note(file, &items[1], message));
        if let ExpressionKind::List(sections) = &mut define.kind {
            sections.push(Expression::of_items(items, position));
        }
    }
}

/// Collects the words of an expression that are no variables.
fn words<'a>(expression: &'a Expression, all: &mut FxHashSet<&'a str>) {
    match (expression.word(), expression.list()) {
        (Some(word), _) if !word.starts_with(['?', ':']) => {
            all.insert(word);
        }
        (_, Some(items)) => items.iter().for_each(|item| words(item, all)),
        _ => {}
    }
}

/// Reads expressions in a fence, with glued words, or with a wrong number of parentheses at the end. The second result is true if
/// they are not those of the text.
fn parsed(file: &str, text: &str, notes: &mut Vec<Diagnostic>) -> Result<(Vec<Expression>, bool), Diagnostic> {
    let own = without_fence(text);
    let notes_before = notes.len();
    let mut expressions = closed(file, &own, notes)?;
    if expressions.iter().any(|own| own.tail_of("define").is_some()) {
        let words = expressions.iter().filter_map(|own| Some((own, own.word()?)));
        if let Some((own, word)) = words.into_iter().next() {
            let message = format!("`{word}` is outside of the definition and left out");
            notes.push(note(file, own, message));
        }
        expressions.retain(|own| own.word().is_none());
    }
    let before = expressions.clone();
    expressions.iter_mut().for_each(split_words);
    let is_rewritten = own != text || notes.len() > notes_before || before != expressions;
    Ok((expressions, is_rewritten))
}

/// True for the definition of a `domain` or a `problem`.
fn is_of(expression: &Expression, kind: &str) -> bool {
    expression
        .tail_of("define")
        .is_some_and(|sections| head_of(sections) == Some(kind))
}

fn head_of(sections: &[Expression]) -> Option<&str> {
    sections.first()?.list()?.first()?.word()
}

fn note(file: &str, of: &Expression, message: impl Into<String>) -> Diagnostic {
    Diagnostic::at(file, of.position, message)
}

/// Returns the text between the marks of a code block, at its place.
fn without_fence(text: &str) -> std::borrow::Cow<'_, str> {
    if !text.contains("```") {
        return text.into();
    }
    let mut is_inside = false;
    let lines = text.lines().map(|line| {
        let is_mark = line.trim_start().starts_with("```");
        is_inside ^= is_mark;
        if is_inside && !is_mark { line } else { "" }
    });
    lines.collect::<Vec<_>>().join("\n").into()
}

/// Parentheses at the end of a file that may be missing or too many.
const LAST_PARENTHESES: usize = 3;

/// Reads expressions; the last closing parentheses may be missing or too many.
fn closed(file: &str, text: &str, notes: &mut Vec<Diagnostic>) -> Result<Vec<Expression>, Diagnostic> {
    let error = match sexpr::read(file, text) {
        Ok(expressions) => return Ok(expressions),
        Err(error) => error,
    };
    let mut shorter = text.trim_end();
    for count in 1..=LAST_PARENTHESES {
        let longer = format!("{text}\n{}", ")".repeat(count));
        shorter = shorter.strip_suffix(')').unwrap_or(shorter).trim_end();
        for (text, message) in [
            (longer.as_str(), format!("{count} `)` at the end is missing")),
            (
                shorter,
                format!("{count} `)` at the end closes nothing and is left out"),
            ),
        ] {
            match sexpr::read(file, text) {
                Ok(expressions) if expressions.len() == 1 => {
                    notes.push(note(file, &expressions[0], message));
                    return Ok(expressions);
                }
                _ => {}
            }
        }
    }
    Err(error)
}

/// Splits words that are glued together: `-block` in a typed list, `(dusty?c)`, `(=?a ?b)`.
fn split_words(expression: &mut Expression) {
    let ExpressionKind::List(items) = &mut expression.kind else {
        return;
    };
    let mut split = Vec::with_capacity(items.len());
    for mut item in std::mem::take(items) {
        split_words(&mut item);
        let Some(text) = item.word() else {
            split.push(item);
            continue;
        };
        let place = |offset: usize| Position {
            column: item.position.column + text[..offset].chars().count() as u32,
            ..item.position
        };
        let starts: Vec<usize> = match text.strip_prefix('-') {
            Some(kind) if kind.starts_with(char::is_alphabetic) => vec![0, 1],
            _ => {
                let inner = text.match_indices('?').map(|(at, _)| at).filter(|at| *at > 0);
                std::iter::once(0).chain(inner).collect()
            }
        };
        let ends = starts.iter().skip(1).copied().chain([text.len()]);
        split.extend(
            starts
                .iter()
                .zip(ends)
                .map(|(start, end)| Expression::of_word(&text[*start..end], place(*start))),
        );
    }
    *items = split;
}

fn adapt(file: &str, define: &mut Expression, problem: Option<&Expression>, notes: &mut Vec<Diagnostic>) {
    let ExpressionKind::List(sections) = &mut define.kind else {
        return;
    };
    for section in sections.iter_mut().skip(1) {
        let head = section
            .list()
            .and_then(|items| items.first()?.word().map(str::to_owned));
        match head.as_deref() {
            Some(":requirements") => requirements(file, section, notes),
            Some(":types") => types(file, section, notes),
            _ => {}
        }
    }
    durative::adapt(file, sections, problem, notes);
    conditional_costs(file, sections, notes);
    declarations::adapt(file, sections, notes);
}

/// Leaves out costs that depend on a condition: the cost of a step does not depend on facts.
fn conditional_costs(file: &str, sections: &mut [Expression], notes: &mut Vec<Diagnostic>) {
    let mut first = None;
    for section in sections
        .iter_mut()
        .filter(|section| section.tail_of(":action").is_some())
    {
        without_costs(section, false, &mut first);
    }
    if let Some(position) = first {
        let message = "costs inside of `when` and `forall` are left out, so a plan may be dearer than the cheapest one";
        notes.push(Diagnostic::at(file, position, message));
    }
}

/// Removes the changes of `(total-cost)` that are inside of `when` or `forall`.
fn without_costs(expression: &mut Expression, is_inside: bool, first: &mut Option<Position>) {
    let is_inside = is_inside || expression.tail_of("when").is_some() || expression.tail_of("forall").is_some();
    let ExpressionKind::List(items) = &mut expression.kind else {
        return;
    };
    for item in items {
        let is_cost = item
            .tail_of("increase")
            .and_then(|parts| parts.first()?.tail_of(TOTAL_COST))
            .is_some_and(<[_]>::is_empty);
        if is_inside && is_cost {
            first.get_or_insert(item.position);
            item.kind = ExpressionKind::List(vec![Expression::of_word("and", item.position)]);
        } else {
            without_costs(item, is_inside, first);
        }
    }
}

/// Leaves out requirements that nothing in this library asks for: what a file uses of them is read, or is an error at its place.
fn requirements(file: &str, section: &mut Expression, notes: &mut Vec<Diagnostic>) {
    let ExpressionKind::List(items) = &mut section.kind else {
        return;
    };
    let mut needs_quantifiers = false;
    items.retain(|item| {
        let Some(own) = item.word() else { return true };
        if own == ":requirements" || REQUIREMENTS.contains(&own) {
            return true;
        }
        if own == ":universal-preconditions" || own == ":existential-preconditions" {
            needs_quantifiers = true;
        } else if own.starts_with(':') {
            notes.push(note(file, item, format!("the requirement `{own}` is left out")));
        } else {
            return true;
        }
        false
    });
    if needs_quantifiers {
        items.push(Expression::of_word(":quantified-preconditions", section.position));
    }
}

/// Leaves out a type among its own subtypes: `location peg - location`.
fn types(file: &str, section: &mut Expression, notes: &mut Vec<Diagnostic>) {
    let ExpressionKind::List(items) = &mut section.kind else {
        return;
    };
    let mut left_out = Vec::new();
    let mut begin = 1;
    for (index, item) in items.iter().enumerate() {
        if item.word() == Some("-") {
            let parent = items.get(index + 1).and_then(Expression::word);
            let own = (begin..index).filter(|place| parent.is_some() && items[*place].word() == parent);
            left_out.extend(own.filter(|_| parent != Some("object") || index - begin > 1));
            begin = index + 2;
        }
    }
    for place in left_out.into_iter().rev() {
        let own = items.remove(place);
        let name = own.word().unwrap_or_default().to_owned();
        notes.push(note(file, &own, format!("the type `{name}` is no type below itself")));
    }
    object_below_another(file, items, notes);
}

/// `object` is above every type, so a type above it is as wide: what is below `object` belongs to that type.
fn object_below_another(file: &str, items: &mut Vec<Expression>, notes: &mut Vec<Diagnostic>) {
    let Some((place, top)) = parent_of(items, "object").filter(|(_, top)| top.word() != Some("object")) else {
        return;
    };
    let own = items.remove(place);
    let name = top.word().unwrap_or_default();
    notes.push(note(
        file,
        &own,
        format!("`object` is above every type, so every type is below `{name}`"),
    ));
    let is_object = |index: usize, items: &[Expression]| index > 0 && items[index - 1].word() == Some("-");
    for index in 0..items.len() {
        if items[index].word() == Some("object") && is_object(index, items) {
            items[index] = top.clone();
        }
    }
    // Types without a parent, at the end of the list.
    let last = items
        .iter()
        .rposition(|item| item.word() == Some("-"))
        .map_or(1, |dash| dash + 2);
    if items[last.min(items.len())..]
        .iter()
        .any(|item| item.word() != top.word())
    {
        items.extend([Expression::of_word("-", own.position), top.clone()]);
    }
    // The wide type is below `object` only.
    while let Some((place, _)) = parent_of(items, name).filter(|(_, parent)| parent.word() == top.word()) {
        items.remove(place);
    }
}

/// Returns where a type is declared, and its parent.
fn parent_of(items: &[Expression], name: &str) -> Option<(usize, Expression)> {
    let mut begin = 1;
    for (index, item) in items.iter().enumerate() {
        if item.word() == Some("-") {
            let found = (begin..index).find(|place| items[*place].word() == Some(name));
            if let (Some(place), Some(parent)) = (found, items.get(index + 1)) {
                return Some((place, parent.clone()));
            }
            begin = index + 2;
        }
    }
    None
}
