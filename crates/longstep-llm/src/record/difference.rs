//! The difference between a request and the recorded requests.

use super::wire::{WireConstraint, WireMessage, WireRequest};

/// Characters to show around a difference.
const SHOWN: usize = 40;

/// The difference from the most similar recorded request, in one line.
pub(super) fn nearest<'a>(asked: &WireRequest, recorded: impl Iterator<Item = &'a WireRequest>) -> String {
    // On a tie, the first one.
    let nearest = recorded
        .enumerate()
        .map(|(number, request)| (common(asked, request), number, request))
        .max_by(|left, right| left.0.cmp(&right.0).then(right.1.cmp(&left.1)));
    match nearest {
        None => "no request is recorded".into(),
        Some((_, number, request)) => {
            format!(
                "the most similar one is request {}, which differs in {}",
                number + 1,
                difference(asked, request)
            )
        }
    }
}

/// Similarity of two requests: the common prefixes of their texts in characters, then the number of equal properties.
fn common(asked: &WireRequest, recorded: &WireRequest) -> (usize, usize) {
    let pairs = asked.messages.iter().zip(&recorded.messages);
    let characters = pairs
        .map(|(asked, recorded)| same(&asked.text, &recorded.text))
        .sum::<usize>()
        + same(&asked.answer_so_far, &recorded.answer_so_far);
    let rest = usize::from(asked.constraint == recorded.constraint)
        + usize::from(asked.max_tokens == recorded.max_tokens)
        + usize::from(asked.messages.len() == recorded.messages.len());
    (characters, rest)
}

/// Length of the common prefix of two texts, in characters.
fn same(left: &str, right: &str) -> usize {
    left.chars()
        .zip(right.chars())
        .take_while(|(left, right)| left == right)
        .count()
}

fn difference(asked: &WireRequest, recorded: &WireRequest) -> String {
    let pairs = asked.messages.iter().zip(&recorded.messages);
    if let Some((number, (asked, recorded))) = pairs.enumerate().find(|(_, (asked, recorded))| asked != recorded) {
        return format!("message {}: {}", number + 1, message(asked, recorded));
    }
    let (many, few) = (asked.messages.len(), recorded.messages.len());
    if many != few {
        return format!("the number of messages: recorded {few}, requested {many}");
    }
    if asked.answer_so_far != recorded.answer_so_far {
        let texts = texts(&asked.answer_so_far, &recorded.answer_so_far);
        return format!("the beginning of the answer: {texts}");
    }
    if asked.constraint != recorded.constraint {
        let texts = texts(&constraint(&asked.constraint), &constraint(&recorded.constraint));
        return format!("the constraint: {texts}");
    }
    let (now, then) = (asked.max_tokens, recorded.max_tokens);
    format!("the token limit of the answer: recorded {then}, requested {now}")
}

fn message(asked: &WireMessage, recorded: &WireMessage) -> String {
    if asked.role != recorded.role {
        return format!("recorded from {:?}, requested from {:?}", recorded.role, asked.role);
    }
    texts(&asked.text, &recorded.text)
}

fn constraint(constraint: &WireConstraint) -> String {
    match constraint {
        WireConstraint::Free => "none".into(),
        WireConstraint::Lark(grammar) => format!("grammar {grammar}"),
        WireConstraint::JsonSchema(schema) => format!("schema {schema}"),
    }
}

/// Excerpts of two texts around the first difference.
fn texts(asked: &str, recorded: &str) -> String {
    let from = same(asked, recorded).saturating_sub(SHOWN / 2);
    let part = |text: &str| -> String {
        let shown: String = text.chars().skip(from).take(SHOWN).collect();
        let before = if from > 0 { "..." } else { "" };
        let after = if text.chars().nth(from + SHOWN).is_some() {
            "..."
        } else {
            ""
        };
        format!("{:?}", format!("{before}{shown}{after}"))
    };
    format!("recorded {}, requested {}", part(recorded), part(asked))
}
