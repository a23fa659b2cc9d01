//! The difference between a request and the recorded requests.

use crate::wire::{WireConstraint, WireMessage, WirePicture, WireRequest};

/// Characters to show around a difference.
const SHOWN: usize = 40;
/// Digits of a picture's hash to show.
const HASH_SHOWN: usize = 12;

/// The difference from the most similar recorded request, in one line.
pub(super) fn nearest<'a>(requested: &WireRequest, recorded: impl Iterator<Item = &'a WireRequest>) -> String {
    // On a tie, the first one.
    let nearest = recorded
        .enumerate()
        .map(|(number, request)| (common(requested, request), number, request))
        .max_by(|left, right| left.0.cmp(&right.0).then(right.1.cmp(&left.1)));
    match nearest {
        None => "no request is recorded".into(),
        Some((_, number, request)) => {
            format!(
                "the most similar one is request {}, which differs in {}",
                number + 1,
                difference(requested, request)
            )
        }
    }
}

/// Similarity of two requests: the common prefixes of their texts in characters, then the number of equal properties.
fn common(requested: &WireRequest, recorded: &WireRequest) -> (usize, usize) {
    let pairs = requested.messages.iter().zip(&recorded.messages);
    let characters = pairs
        .map(|(requested, recorded)| same(&requested.text, &recorded.text))
        .sum::<usize>()
        + same(&requested.answer_so_far, &recorded.answer_so_far);
    let rest = usize::from(requested.constraint == recorded.constraint)
        + usize::from(requested.max_tokens == recorded.max_tokens)
        + usize::from(requested.messages.len() == recorded.messages.len());
    (characters, rest)
}

/// Length of the common prefix of two texts, in characters.
fn same(left: &str, right: &str) -> usize {
    left.chars()
        .zip(right.chars())
        .take_while(|(left, right)| left == right)
        .count()
}

fn difference(requested: &WireRequest, recorded: &WireRequest) -> String {
    let pairs = requested.messages.iter().zip(&recorded.messages);
    if let Some((number, (requested, recorded))) = pairs
        .enumerate()
        .find(|(_, (requested, recorded))| requested != recorded)
    {
        return format!("message {}: {}", number + 1, message(requested, recorded));
    }
    let (many, few) = (requested.messages.len(), recorded.messages.len());
    if many != few {
        return format!("the number of messages: recorded {few}, requested {many}");
    }
    if requested.answer_so_far != recorded.answer_so_far {
        let texts = texts(&requested.answer_so_far, &recorded.answer_so_far);
        return format!("the beginning of the answer: {texts}");
    }
    if requested.constraint != recorded.constraint {
        let texts = texts(&constraint(&requested.constraint), &constraint(&recorded.constraint));
        return format!("the constraint: {texts}");
    }
    let (now, then) = (requested.max_tokens, recorded.max_tokens);
    format!("the token limit of the answer: recorded {then}, requested {now}")
}

fn message(requested: &WireMessage, recorded: &WireMessage) -> String {
    if requested.role != recorded.role {
        return format!("recorded from {:?}, requested from {:?}", recorded.role, requested.role);
    }
    if requested.text == recorded.text {
        return pictures(&requested.pictures, &recorded.pictures);
    }
    texts(&requested.text, &recorded.text)
}

/// The first pictures that differ, by their hashes: a recording has no copies of them.
fn pictures(requested: &[WirePicture], recorded: &[WirePicture]) -> String {
    let (many, few) = (requested.len(), recorded.len());
    if many != few {
        return format!("the number of pictures: recorded {few}, requested {many}");
    }
    let pairs = requested.iter().zip(recorded).enumerate();
    let differs = |(_, (requested, recorded)): &(usize, (&WirePicture, &WirePicture))| requested != recorded;
    let named = |picture: &WirePicture| {
        let hash: String = picture.sha256.chars().take(HASH_SHOWN).collect();
        format!("{} with the SHA-256 {hash}...", picture.media_type)
    };
    match pairs.into_iter().find(differs) {
        Some((number, (requested, recorded))) => format!(
            "picture {}: recorded {}, requested {}",
            number + 1,
            named(recorded),
            named(requested)
        ),
        None => "the pictures".to_owned(),
    }
}

fn constraint(constraint: &WireConstraint) -> String {
    match constraint {
        WireConstraint::Free => "none".into(),
        WireConstraint::Lark(grammar) => format!("grammar {grammar}"),
        WireConstraint::JsonSchema(schema) => format!("schema {schema}"),
    }
}

/// Excerpts of two texts around the first difference.
fn texts(requested: &str, recorded: &str) -> String {
    let from = same(requested, recorded).saturating_sub(SHOWN / 2);
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
    format!("recorded {}, requested {}", part(recorded), part(requested))
}
