//! Explicit references in an utterance: actions by call, steps by number, and entities.

use super::negation::parts;
use crate::environment::{EntityId, World};
use crate::goal::Mentions;
use crate::model::{ActionId, plain_words, singular};
use crate::plan::{Plan, Step};
use longstep_core::model::Domain;

/// The references in an utterance about a plan.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct References {
    /// Actions whose calls the utterance contains.
    pub(super) actions: Vec<ActionId>,
    /// Steps that are named by number, in order.
    pub(super) steps: Vec<usize>,
    /// Positions between steps, from "before" and "after" with a step.
    pub(super) places: Vec<usize>,
    /// True if a step number gives one of these positions.
    pub(super) names_place: bool,
    /// Mentioned entities.
    pub(super) entities: Vec<EntityId>,
    /// For each step, the number of words that its sentence shares with the utterance.
    pub(super) likeness: Vec<usize>,
    /// True if the utterance contrasts two entities ("the pear, not the plum") and so concerns the goal.
    pub(super) corrects: bool,
    /// True if the utterance asks for a repetition.
    pub(super) again: bool,
    /// Stems of the words.
    stems: Vec<String>,
    /// Verbs of the wish language that the cues suggest.
    pub(super) verbs: Vec<&'static str>,
}

/// Cues for a change of the steps, by verb of the wish language: stems and word pairs.
const CUES: [(&str, &[&str]); 4] = [
    ("insert", &["insert", "add", "another", "additional", "extra", "more"]),
    (
        "drop",
        &[
            "omit",
            "skip",
            "drop",
            "remove",
            "delete",
            "leave out",
            "cut out",
            "unnecessary",
            "superfluous",
            "redundant",
            "needless",
            "no need",
            "dont need",
            "not need",
            "not have to",
            "dont have to",
            "not necessary",
            "neednt",
        ],
    ),
    ("replace", &["replac", "instead", "rather", "exchang", "substitut"]),
    (
        "move",
        &[
            "swap",
            "earlier",
            "later",
            "before",
            "after",
            "first",
            "order",
            "move step",
        ],
    ),
];

/// Words that ask for a repetition.
const AGAIN: [&str; 10] = [
    "again",
    "another",
    "more",
    "twice",
    "second",
    "additional",
    "extra",
    "repeat",
    "also",
    "too",
];

const ORDINALS: [&str; 10] = [
    "first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth",
];
const CARDINALS: [&str; 10] = [
    "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten",
];

/// Stop words when an utterance is compared with steps.
const EMPTY: &str = "a an and another as be because before but can case could do does for from hand have i if in \
    instead is it just last later leave let more need no not of off on once one only out over please put rather same \
    should so step task that the their them then there these they thing this those to too up use we when which why \
    will with without would you your move_object insert add omit skip drop remove delete replace after first again";

impl References {
    /// Finds the references in an utterance about a plan.
    pub(super) fn of(world: &World, plan: &Plan, words: &str) -> Self {
        let domain = world.domain();
        let tokens = plain_words(words);
        let actions = named_actions(domain, words);
        let (main, side) = clauses(words);
        let mut references = Self {
            entities: Mentions::of(world, words).entities,
            likeness: likeness(world, plan.steps(), &plain_words(&main)),
            actions,
            stems: tokens.iter().map(|token| stem(token)).collect(),
            ..Self::default()
        };
        let (meant, denied) = parts(words);
        let speaks = |text: &str| !Mentions::of(world, text).entities.is_empty();
        references.corrects = speaks(&denied) && speaks(&meant);
        references.numbered(plan, &tokens, domain);
        references.again = tokens.iter().any(|token| AGAIN.contains(&token.as_str()));
        if let (Some((after, clause)), true) = (side, references.places.is_empty()) {
            let alike = likeness(world, plan.steps(), &plain_words(&clause));
            let most = alike.iter().copied().max().unwrap_or(0);
            let best = alike.iter().enumerate().filter(|(_, like)| most > 0 && **like == most);
            references.places = best.map(|(step, _)| step + usize::from(after)).collect();
        }
        let joined = tokens.join(" ");
        let says = |cue: &str| match cue.contains(' ') {
            true => joined.contains(cue),
            false => tokens.iter().any(|token| token.starts_with(cue)),
        };
        for (verb, cues) in CUES {
            if cues.iter().any(|cue| says(cue)) {
                references.verbs.push(verb);
            }
        }
        references
    }

    /// Returns true if the utterance names a step or a call, and so concerns the steps and not the goal.
    pub(super) fn is_about_steps(&self) -> bool {
        !self.actions.is_empty() || !self.steps.is_empty() || self.names_place
    }

    /// Returns true if the utterance contains a word of the action's call.
    pub(super) fn says_verb(&self, domain: &Domain, action: ActionId) -> bool {
        let call = plain_words(&domain.action(action).call.replace('_', " "));
        let stems: Vec<String> = call.iter().map(|word| stem(word)).collect();
        self.stems.iter().any(|stem| stems.contains(stem))
    }

    /// Finds steps by number or order: "step 3", "steps 2 and 4", "the third step", "the last two", "the second
    /// move_object()".
    fn numbered(&mut self, plan: &Plan, tokens: &[String], domain: &Domain) {
        let length = plan.steps().len();
        let mut at = 0;
        while at < tokens.len() {
            let begin = at;
            let mut found = Vec::new();
            if matches!(
                tokens[at].trim_end_matches('s'),
                "step" | "number" | "no" | "task" | "line"
            ) {
                let mut next = at + 1;
                while let Some(number) = tokens.get(next).and_then(|token| number(token)) {
                    found.push(number);
                    at = next;
                    next += 1;
                    let joined = tokens.get(next).is_some_and(|token| token == "and" || token == "or");
                    if joined && tokens.get(next + 1).is_some_and(|token| number_only(token)) {
                        next += 1;
                    }
                }
            } else if let Some(counted) = self.counted(plan, tokens, at, domain) {
                found = counted;
            }
            found.retain(|number| (1..=length).contains(number));
            let before_it = &tokens[begin.saturating_sub(3)..begin];
            let side = before_it
                .iter()
                .rev()
                .find(|token| *token == "before" || *token == "after");
            for number in found {
                match side.map(String::as_str) {
                    // A number after "before" or "after" gives a position, not a step.
                    Some("before") => self.places.push(number - 1),
                    Some(_) => self.places.push(number),
                    None if !self.steps.contains(&(number - 1)) => self.steps.push(number - 1),
                    None => {}
                }
            }
            at += 1;
        }
        self.names_place = !self.places.is_empty();
        let ends = tokens.windows(3).any(|three| three.join(" ") == "at the end");
        if ends {
            self.places.push(length);
        }
        if tokens
            .windows(3)
            .any(|three| three == ["at", "the", "beginning"] || three == ["at", "the", "start"])
        {
            self.places.push(0);
        }
    }

    /// Returns steps by ordinal or "last", numbered from 1: "the third step", "the last two steps", "the second
    /// move_object()".
    fn counted(&self, plan: &Plan, tokens: &[String], at: usize, domain: &Domain) -> Option<Vec<usize>> {
        let ordinal = ORDINALS.iter().position(|word| *word == tokens[at]);
        let last = tokens[at] == "last";
        if ordinal.is_none() && !last {
            return None;
        }
        let many = tokens.get(at + 1).and_then(|token| number(token));
        let noun = tokens.get(at + 1 + usize::from(many.is_some()))?;
        // The ordinal counts all steps, or those of an action that follows it.
        let rest = tokens[at + 1 + usize::from(many.is_some())..].join(" ");
        let of_action = self.actions.iter().find(|action| {
            let call = plain_words(&domain.action(**action).call).join(" ");
            rest.starts_with(&call)
        });
        let steps = plan.steps().iter().enumerate();
        let counted: Vec<usize> = match (of_action, noun.trim_end_matches('s')) {
            (Some(action), _) => steps
                .filter(|(_, step)| step.action == *action)
                .map(|(index, _)| index + 1)
                .collect(),
            (None, "step" | "task" | "action") => steps.map(|(index, _)| index + 1).collect(),
            (None, _) => return None,
        };
        let many = many.unwrap_or(1).min(counted.len());
        Some(match ordinal {
            None => counted[counted.len() - many..].to_vec(),
            Some(0) => counted[..many].to_vec(),
            Some(ordinal) => counted.get(ordinal).copied().into_iter().collect(),
        })
    }
}

/// Splits off the clause after "before" or "after". Returns the other words, and the clause with true for "after".
fn clauses(words: &str) -> (String, Option<(bool, String)>) {
    let lower = words.to_lowercase();
    let find = |word: &str| {
        lower.match_indices(word).map(|(at, _)| at).find(|at| {
            let edge = |c: Option<char>| !c.is_some_and(char::is_alphanumeric);
            edge(lower[..*at].chars().next_back()) && edge(lower[at + word.len()..].chars().next())
        })
    };
    let Some((at, word)) = ["before", "after"]
        .iter()
        .filter_map(|word| Some((find(word)?, *word)))
        .min()
    else {
        return (lower, None);
    };
    let begin = at + word.len();
    let end = lower[begin..]
        .find([',', '.', ';'])
        .map_or(lower.len(), |end| begin + end);
    let clause = lower[begin..end].to_owned();
    (
        format!("{}{}", &lower[..at], &lower[end..]),
        Some((word == "after", clause)),
    )
}

fn number_only(token: &str) -> bool {
    number(token).is_some()
}

fn number(token: &str) -> Option<usize> {
    let written = CARDINALS.iter().position(|word| *word == token).map(|index| index + 1);
    token.parse().ok().or(written)
}

/// Returns the actions whose calls cannot be ordinary words of the utterance: `move_object`, `open()`, `PutIn`.
fn named_actions(domain: &Domain, words: &str) -> Vec<ActionId> {
    let symbol = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
    let mut named = Vec::new();
    for (id, action) in domain.action_ids() {
        let call = action.call.to_lowercase();
        let lower = words.to_lowercase();
        let spelt = lower.match_indices(&call).any(|(at, _)| {
            let before = lower[..at].chars().next_back();
            let after = lower[at + call.len()..].chars().next();
            let whole = !before.is_some_and(symbol) && !after.is_some_and(symbol);
            let odd = call.contains('_') || action.call.chars().skip(1).any(char::is_uppercase);
            whole && (odd || after == Some('('))
        });
        if spelt {
            named.push(id);
        }
    }
    named
}

/// Returns, for each step, the number of the words that occur in its sentence or its call.
fn likeness(world: &World, steps: &[Step], tokens: &[String]) -> Vec<usize> {
    let empty: Vec<&str> = EMPTY.split_whitespace().collect();
    let stems = |words: Vec<String>| -> Vec<String> {
        let full = words.into_iter().filter(|word| !empty.contains(&word.as_str()));
        let mut stems: Vec<String> = full.map(|word| stem(&word)).collect();
        stems.sort();
        stems.dedup();
        stems
    };
    let utterance = stems(tokens.to_vec());
    steps
        .iter()
        .map(|step| {
            let text = format!("{} {}", step.call(world).name.replace('_', " "), step.explanation);
            let own = stems(plain_words(&text));
            own.iter().filter(|word| utterance.contains(word)).count()
        })
        .collect()
}

/// Returns the stem of a word: a simple removal of verb and plural endings.
fn stem(word: &str) -> String {
    let single = singular(word);
    let bare = ["ing", "ed"].iter().find_map(|ending| single.strip_suffix(ending));
    let bare = bare.filter(|bare| bare.len() >= 3).unwrap_or(&single);
    // "Moving" and "move", "skipping" and "skip".
    let bare = bare.strip_suffix('e').unwrap_or(bare);
    let mut stem = bare.to_owned();
    let mut ends = bare.chars().rev();
    if let (Some(last), Some(other)) = (ends.next(), ends.next())
        && last == other
        && bare.len() > 3
    {
        stem.pop();
    }
    stem
}

/// Returns the purpose clause of an utterance, if any: "to move the tea upward".
pub(super) fn what_for(world: &World, words: &str) -> Option<String> {
    let lower = words.to_lowercase();
    let mut from = 0;
    while let Some(found) = lower[from..].find(" to ") {
        let begin = from + found + " to ".len();
        let rest = words.get(begin..)?;
        let stops = [
            " before ",
            " after ",
            " between ",
            " at the end",
            " and then ",
            " instead",
        ];
        let stop = stops.iter().filter_map(|stop| rest.find(stop)).min();
        let end = rest.find([',', '.', ';', '!', '?', '(']);
        let end = end.into_iter().chain(stop).min().unwrap_or(rest.len());
        let clause = rest[..end].trim();
        let mut parts = clause.split_whitespace();
        let verb = parts.next().map(str::to_lowercase).unwrap_or_default();
        let a_place = world
            .entities()
            .any(|(_, entity)| entity.names.iter().any(|name| plain_words(name).first() == Some(&verb)));
        let no_verb = ["the", "a", "an", "this", "that", "my", "your", "it", "step", "be"].contains(&verb.as_str());
        if parts.next().is_some() && !a_place && !no_verb && verb.chars().all(char::is_alphabetic) {
            return Some(clause.to_owned());
        }
        from = begin;
    }
    None
}
