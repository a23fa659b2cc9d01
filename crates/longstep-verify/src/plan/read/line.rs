//! One line with a step: its marks, its calls, and its explanation.

use crate::plan::{WrittenStep, script};
use longstep_model::call::{Call, unquoted};

/// The forms of lines with steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    Bare,
    Bullet,
    Number,
    Table,
    VirtualHome,
}

/// A line with at least one step.
#[derive(Debug)]
pub(super) struct Line {
    pub(super) form: Form,
    pub(super) indentation: usize,
    /// The number of an entry of a list.
    pub(super) number: Option<u32>,
    pub(super) steps: Vec<WrittenStep>,
    /// The character of a line of a VirtualHome script.
    pub(super) character: Option<String>,
}

impl Form {
    /// Returns the name of the notation, for people.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Bare => "calls on lines of their own",
            Self::Bullet => "a list of calls",
            Self::Number => "a numbered list",
            Self::Table => "a Markdown table",
            Self::VirtualHome => "a VirtualHome script",
        }
    }

    /// Returns the form, the indentation and the number of an entry of a list, of a row, or of a line of a VirtualHome script,
    /// whether it has a step or not; none for other lines.
    pub(super) fn of_line(line: &str) -> Option<(Self, usize, Option<u32>)> {
        let indentation = line.len() - line.trim_start().len();
        let bare = line.trim();
        let is_rule = bare.chars().all(|c| matches!(c, '|' | '-' | ':' | ' '));
        let begins_verb = bare.starts_with('[') || bare.starts_with("<char");
        let form = match marks(bare) {
            _ if bare.starts_with('|') => (!is_rule).then_some((Self::Table, None))?,
            _ if begins_verb => (Self::VirtualHome, None),
            (Self::Bare, ..) => return None,
            (form, number, _) => (form, number),
        };
        Some((form.0, indentation, form.1))
    }
}

impl Line {
    /// Reads a line; none if it has no step, or words beside it that are no explanation.
    pub(super) fn read(line: &str) -> Option<Self> {
        let indentation = line.len() - line.trim_start().len();
        let bare = untagged(line);
        let of = |form, number, steps| Self {
            form,
            indentation,
            number,
            steps,
            character: None,
        };
        if let Some(row) = bare.strip_prefix('|') {
            let mut cells = row.split('|').filter_map(steps);
            let mut only = cells.next()?;
            if cells.next().is_some() {
                return None;
            }
            if let [step] = &mut only[..]
                && step.explanation.is_empty()
            {
                step.explanation = other_cells(row);
            }
            return Some(of(Form::Table, None, only));
        }
        let (form, number, rest) = marks(bare);
        if let Some((character, step)) = virtualhome(rest) {
            return Some(Self {
                character,
                ..of(Form::VirtualHome, number, vec![step])
            });
        }
        // In a line of its own, words say what several steps are: `The plan: a() -> b()`.
        let explained = || steps_behind_words(rest).filter(|steps| form == Form::Number || steps.len() > 1);
        Some(of(form, number, steps(rest).or_else(explained)?))
    }
}

/// Takes the tags off that enclose a line: `<step>Open(<box>)</step>`.
fn untagged(line: &str) -> &str {
    let mut bare = line.trim();
    while let Some((tag, inside)) = bare.strip_prefix('<').and_then(|rest| rest.split_once('>'))
        && let Some(inside) = inside.strip_suffix(&format!("</{}>", tag.split(' ').next().unwrap_or_default()))
    {
        bare = inside.trim();
    }
    bare
}

/// Returns the cells of a row that are no call and no number, as the explanation of its step.
fn other_cells(row: &str) -> String {
    let cells = row.split('|').map(|cell| cell.trim_matches(is_emphasis));
    let cells: Vec<&str> = cells
        .filter(|cell| cell.contains(char::is_alphabetic) && steps(cell).is_none())
        .collect();
    cells.join("; ")
}

/// Reads the text of one step, as it stands in a list of texts: a call, a line of a VirtualHome script, or `(action argument ...)`.
pub(super) fn step_of_text(text: &str) -> Option<WrittenStep> {
    if let Some(step) = bracketed_step(text.trim()) {
        return Some(step);
    }
    let mut line = Line::read(text).filter(|_| !text.trim().contains('\n'))?;
    let only = line.steps.pop()?;
    line.steps.is_empty().then_some(only)
}

/// Reads a step as planners write it.
fn bracketed_step(text: &str) -> Option<WrittenStep> {
    let inside = text.strip_prefix('(')?.strip_suffix(')')?;
    let mut words = inside.split_whitespace();
    let step = Call::parse(words.next()?).ok()?;
    let arguments: Vec<String> = words.map(str::to_owned).collect();
    let is_plain = !inside.contains(['(', ')', ',', '"']);
    is_plain.then(|| WrittenStep::of_call(Call { arguments, ..step }))
}

/// Marks of emphasis and quotes around a step.
fn is_emphasis(c: char) -> bool {
    matches!(c, '*' | '`' | '"' | '\'' | '“' | '”' | '‘' | '’') || c.is_whitespace()
}

/// Splits the marks of a list off a line: its form, its number, and the rest.
fn marks(line: &str) -> (Form, Option<u32>, &str) {
    let mut rest = line.trim_start_matches(['#', '>', ' ']);
    let mut form = Form::Bare;
    if let Some(entry) = ["- ", "* ", "+ ", "• ", "– "]
        .iter()
        .find_map(|mark| rest.strip_prefix(mark))
    {
        form = Form::Bullet;
        rest = ["[ ]", "[x]", "[X]"]
            .iter()
            .fold(entry, |rest, mark| rest.strip_prefix(mark).unwrap_or(rest));
    }
    let bold = rest.trim_start_matches(is_emphasis);
    // `Step 1:`, in any language.
    let word = bold.trim_start_matches(char::is_alphabetic);
    let counted = if word.len() < bold.len() {
        word.strip_prefix(' ').map(str::trim_start)
    } else {
        Some(bold.strip_prefix('(').unwrap_or(bold))
    };
    let number = counted.and_then(|counted| {
        let digits = counted.trim_start_matches(|c: char| c.is_ascii_digit());
        let number = counted[..counted.len() - digits.len()].parse().ok()?;
        let end = digits.trim_start_matches(is_emphasis);
        let end = end.strip_prefix(['.', ')', ':', '-', '–', '—'])?;
        Some((number, end.trim_start_matches(is_emphasis)))
    });
    if let Some((number, rest)) = number {
        return (Form::Number, Some(number), rest);
    }
    // The format of agents that reason and act by turns.
    (form, None, rest.strip_prefix("Action:").unwrap_or(rest))
}

/// Reads the calls of a part of a line, with an explanation behind them.
fn steps(part: &str) -> Option<Vec<WrittenStep>> {
    let mut rest = part.trim_matches(is_emphasis);
    if let Some(inside) = rest.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
        rest = inside.trim_matches(is_emphasis);
    }
    let mut steps: Vec<WrittenStep> = Vec::new();
    loop {
        rest = &rest[receiver(rest)..];
        let length = call_length(rest)?;
        steps.push(call(&rest[..length])?);
        rest = rest[length..].trim_start_matches(is_emphasis);
        if is_ornament(rest) {
            return Some(steps);
        }
        let next = ["->", "→", ",", ";"].iter().find_map(|sign| rest.strip_prefix(sign));
        let next = next.map(|next| next.trim_start_matches(is_emphasis));
        match next {
            Some(next) if call_length(&next[receiver(next)..]).is_some() => rest = next,
            _ => break,
        }
    }
    let words = match rest.strip_prefix([',', '.']) {
        // Words behind several steps are a sentence of their own.
        Some(behind) if steps.len() > 1 && behind.starts_with(' ') => behind,
        Some(behind) => behind.trim().is_empty().then_some("")?,
        None => EXPLANATION_SIGNS.iter().find_map(|sign| rest.strip_prefix(sign))?,
    };
    let words = words.trim().trim_end_matches(['*', '`']).trim();
    let words = if rest.starts_with('(') {
        words.strip_suffix(')').unwrap_or(words)
    } else {
        words
    };
    steps.last_mut()?.explanation = words.to_owned();
    Some(steps)
}

/// Signs between a step and its explanation.
const EXPLANATION_SIGNS: [&str; 11] = ["->", "=>", "→", "–", "—", "-", ":", "#", "//", ";", "("];

/// Number of places in an entry at which a step behind words is looked for, of each sign: each takes a pass over the entry.
const MOST_SIGNS: usize = 4;

/// Reads the steps of an entry with words before them: `1. Go to the desk: Walk(<desk>)`.
fn steps_behind_words(entry: &str) -> Option<Vec<WrittenStep>> {
    let signs = [": ", " – ", " — ", " - ", " → ", " -> "];
    let places = signs.iter().flat_map(|sign| entry.match_indices(sign).take(MOST_SIGNS));
    let (words, mut steps) = places
        .filter_map(|(at, sign)| Some((&entry[..at], steps(&entry[at + sign.len()..])?)))
        .next()?;
    if let [only] = &mut steps[..]
        && only.explanation.is_empty()
    {
        only.explanation = words.trim_matches(is_emphasis).to_owned();
    }
    Some(steps)
}

/// Returns the length of the object whose method a call is: `robot.`.
fn receiver(text: &str) -> usize {
    let name = text.trim_start_matches(|c: char| c.is_alphanumeric() || matches!(c, '_' | '.'));
    let path = &text[..text.len() - name.len()];
    match path.rfind('.') {
        Some(dot) if name.starts_with('(') && text.starts_with(char::is_alphabetic) => dot + 1,
        _ => 0,
    }
}

/// Returns true for what may stand behind a step without a meaning: nothing, `!`, a symbol, a closing tag.
fn is_ornament(rest: &str) -> bool {
    let mut rest = rest.trim();
    while let Some((before, tag)) = rest.rsplit_once('<')
        && (tag.starts_with('/') || tag.starts_with("br"))
        && tag.ends_with('>')
    {
        rest = before.trim_end();
    }
    let is_sign = |c: char| {
        if c.is_ascii() {
            c == '!'
        } else {
            !c.is_alphanumeric() && !matches!(c, '\u{2026}' | '\u{2010}'..='\u{2015}' | '\u{2190}'..='\u{21ff}')
        }
    };
    rest.chars().all(is_sign)
}

/// Returns the length of the call at the beginning of a text.
pub(super) fn call_length(text: &str) -> Option<usize> {
    let name = text.trim_start_matches(|c: char| c.is_alphanumeric() || matches!(c, '_' | '-'));
    let begin = text.len() - name.len();
    if !text.starts_with(char::is_alphabetic) || !name.starts_with('(') {
        return None;
    }
    let mut depth = 0_usize;
    for (at, letter) in unquoted(name) {
        match letter {
            '(' => depth += 1,
            ')' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return Some(begin + at + 1);
        }
    }
    None
}

/// Reads a call, with quotes and names of parameters as in a script.
fn call(text: &str) -> Option<WrittenStep> {
    if let Ok(mut written) = script::read(text)
        && written.is_sequence()
        && written.steps.len() == 1
    {
        return written.steps.pop();
    }
    // Names with signs that scripts do not have.
    Call::parse(text).ok().map(WrittenStep::of_call)
}

/// Reads a line of a VirtualHome script, with its character: `[GRAB] <soap> (1.1002)` of the data set, `[WALK] <kitchen> (205) [0]`,
/// or `<char0> [putback] <pot> (3) <table> (5)` of the simulator. An entity is named by its class and the number of its node.
fn virtualhome(line: &str) -> Option<(Option<String>, WrittenStep)> {
    let mut rest = line.trim().trim_matches('`');
    let mut character = None;
    if let Some(named) = rest.strip_prefix("<char") {
        let (number, behind) = named.split_once('>').filter(|(number, _)| is_digits(number))?;
        character = Some(number.to_owned());
        rest = behind.trim_start();
    }
    let (verb, behind) = rest.strip_prefix('[')?.split_once(']')?;
    let is_verb = !verb.is_empty() && verb.chars().all(|c| c.is_alphabetic() || c == '_');
    rest = behind.trim();
    let mut arguments = Vec::new();
    while let Some(class) = rest.strip_prefix('<') {
        let (class, behind) = class.split_once('>')?;
        rest = behind.trim_start();
        let mut name = class.trim().to_owned();
        if let Some(number) = rest.strip_prefix('(') {
            let (number, behind) = number.split_once(')')?;
            // In the data set, the number of the node stands behind the number of the object in the script.
            let node = number.rsplit('.').next().filter(|node| is_digits(node))?;
            name = format!("{name}_{node}");
            rest = behind.trim_start();
        }
        arguments.push(format!("<{name}>"));
    }
    if let Some(index) = rest.strip_prefix('[') {
        let (index, behind) = index.split_once(']').filter(|(index, _)| is_digits(index))?;
        character.get_or_insert(index.to_owned());
        rest = behind.trim();
    }
    let is_sure = !arguments.is_empty() || character.is_some() || verb.chars().all(char::is_uppercase);
    (is_verb && is_sure && rest.is_empty()).then(|| {
        let name = verb.to_owned();
        (character, WrittenStep::of_call(Call { name, arguments }))
    })
}

fn is_digits(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}
