//! Coverage: the role of every part of an instruction, and the parts that the goal does not represent.
//!
//! A verified plan for a part of what a person said looks like a plan for all of it. [`Coverage`] accounts for the whole
//! text: each part belongs to a goal or a constraint, is background, or is a [`Gap`]. Most gaps are a question to the
//! person before the plan counts as an answer.
//!
//! Gaps have two sources. A model says which words its goal does not say ([`LeftOut`]). The others are facts about the text that
//! need no language (`literal`): numbers in digits, and quotations, that no goal contains.

mod literal;
mod names;
#[cfg(test)]
mod tests;

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::environment::{EntityId, World};
use crate::goal::{Goal, Group};
use names::FullNames;

/// The kind of a part that the goal does not represent. It decides whether the part is a question or a note.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Gap {
    /// A deadline, an hour, a date.
    Time,
    /// How something is done: quietly, neatly.
    Manner,
    /// Why something is wished.
    #[serde(alias = "other")]
    Reason,
    /// How much, how often, how long.
    #[serde(alias = "quantity")]
    Amount,
    /// A case or an occasion in which alone something is to be done.
    Condition,
    /// An order in which things are to be done.
    Order,
    /// A text that somebody is to be told.
    #[serde(alias = "quotation")]
    Message,
    /// Something that must not be done.
    Prohibition,
    /// A further wish.
    #[serde(alias = "name")]
    Wish,
}

impl Gap {
    /// All kinds.
    pub const ALL: [Self; 9] = [
        Self::Time,
        Self::Manner,
        Self::Reason,
        Self::Amount,
        Self::Condition,
        Self::Order,
        Self::Message,
        Self::Prohibition,
        Self::Wish,
    ];

    /// Returns the name in JSON and in the answers of models.
    pub fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Manner => "manner",
            Self::Reason => "reason",
            Self::Amount => "amount",
            Self::Condition => "condition",
            Self::Order => "order",
            Self::Message => "message",
            Self::Prohibition => "prohibition",
            Self::Wish => "wish",
        }
    }

    /// Returns the kind with a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// Returns true if the plan would be another one if a goal could say such a part: the person is asked then. Otherwise the
    /// part is a note.
    pub fn is_question(self) -> bool {
        !matches!(self, Self::Time | Self::Manner | Self::Reason)
    }
}

/// Words of an instruction that the goal does not say.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct LeftOut {
    /// The words, as they were said.
    pub text: String,
    /// Their kind.
    pub kind: Gap,
}

/// The role of a part.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum CoverageRole {
    /// It asks for these goals: indices into [`Goal::facts`].
    Goals(Vec<usize>),
    /// It asks for these constraints: indices into [`Goal::constraints`].
    Constraints(Vec<usize>),
    /// It asks for nothing.
    Background,
    /// No goal and no constraint represents it.
    NotRepresented(Gap),
}

/// A part of an instruction, as bytes of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InstructionPart {
    /// The part.
    pub range: Range<usize>,
    /// Its role.
    pub role: CoverageRole,
}

/// The parts of an instruction in the order of the text. They do not overlap; what lies between them is space and
/// punctuation.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Coverage {
    instruction: String,
    parts: Vec<InstructionPart>,
}

impl Coverage {
    /// Accounts for an instruction: `goal` is what was understood, and `left_out` are the words that it does not say. If the person
    /// has said anything since, only these count (`is_alone` is false): the later words may have replaced a number of the
    /// instruction.
    ///
    /// ```
    /// use longstep::coverage::{Coverage, Gap};
    /// let planner = longstep::Planner::shipped("household")?;
    /// let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>", "<ruler>"],
    ///     "object_states": {"<pen>": "on_something(<desk>)", "<ruler>": "on_something(<shelf>)"}}"#)?;
    /// let goal = longstep::goal::parse(&world, "put(pen, shelf)").unwrap();
    /// let coverage = Coverage::new(&world, "Put the pen on the shelf in 5 minutes", &goal, &[], true);
    /// let gaps: Vec<(&str, Gap)> = coverage.gaps().collect();
    /// assert_eq!(gaps, [("5", Gap::Amount)]);
    /// # Ok::<(), longstep::Error>(())
    /// ```
    pub fn new(world: &World, instruction: &str, goal: &Goal, left_out: &[LeftOut], is_alone: bool) -> Self {
        let mentions = FullNames::of(world, instruction);
        let mut gaps = marked(world, instruction, goal, left_out, is_alone);
        if is_alone {
            for (range, gap) in literal::gaps(world, instruction, goal, &mentions) {
                enter(&mut gaps, range, CoverageRole::NotRepresented(gap));
            }
        }
        Self::with_gaps(world, instruction, goal, &mentions, gaps)
    }

    fn with_gaps(
        world: &World,
        instruction: &str,
        goal: &Goal,
        mentions: &FullNames,
        mut gaps: Vec<InstructionPart>,
    ) -> Self {
        gaps.sort_by_key(|part| part.range.start);
        let mut parts = Vec::new();
        let mut start = 0;
        for gap in gaps {
            parts.extend(
                clauses(instruction, start..gap.range.start).map(|range| with_role(world, goal, mentions, range)),
            );
            start = gap.range.end;
            parts.push(gap);
        }
        let rest = clauses(instruction, start..instruction.len());
        parts.extend(rest.map(|range| with_role(world, goal, mentions, range)));
        attribute_the_rest(goal, &mut parts);
        Self {
            instruction: instruction.to_owned(),
            parts,
        }
    }

    /// Returns the parts in the order of the text.
    pub fn parts(&self) -> &[InstructionPart] {
        &self.parts
    }

    /// Returns the text of a part.
    pub fn text(&self, part: &InstructionPart) -> &str {
        &self.instruction[part.range.clone()]
    }

    /// Returns the parts that are not represented, as texts with their kinds.
    pub fn gaps(&self) -> impl Iterator<Item = (&str, Gap)> {
        self.parts.iter().filter_map(|part| match part.role {
            CoverageRole::NotRepresented(gap) => Some((self.text(part), gap)),
            _ => None,
        })
    }

    /// Returns the question to the person; none if every part is represented, or only reported.
    pub fn question(&self) -> Option<String> {
        let texts: Vec<String> = self
            .gaps()
            .filter(|(_, gap)| gap.is_question())
            .map(|(text, _)| format!("\"{text}\""))
            .collect();
        if texts.is_empty() {
            return None;
        }
        Some(format!(
            "I cannot represent {}; the plan ignores it. Go on?",
            texts.join(" and ")
        ))
    }
}

/// Returns the parts that the goal does not say. Words that the instruction does not contain stand for all of it, unless the person
/// has said more than the instruction.
fn marked(world: &World, instruction: &str, goal: &Goal, left_out: &[LeftOut], is_alone: bool) -> Vec<InstructionPart> {
    let place = |own: &LeftOut| {
        let text = own.text.trim();
        let start = instruction.find(text).filter(|_| !text.is_empty());
        let all = is_alone.then_some(0..instruction.len());
        Some((start.map(|start| start..start + text.len()).or(all)?, own.kind))
    };
    let mut missing: Vec<(Range<usize>, Gap)> = left_out.iter().filter_map(place).collect();
    // The goal may have the text of a message after all.
    let known = literal::texts(world, goal);
    missing.retain(|(range, gap)| *gap != Gap::Message || !literal::contain(&known, &instruction[range.clone()]));
    // Of overlapping parts the one with a question stays, and of these the longest: consent is to all of its text.
    missing.sort_by_key(|(range, gap)| (!gap.is_question(), std::cmp::Reverse(range.len()), range.start));
    let mut gaps = Vec::new();
    for (range, gap) in missing {
        enter(&mut gaps, range, CoverageRole::NotRepresented(gap));
    }
    gaps
}

/// Adds a part unless an earlier one overlaps it.
fn enter(parts: &mut Vec<InstructionPart>, range: Range<usize>, role: CoverageRole) {
    let overlaps = |other: &InstructionPart| range.start < other.range.end && other.range.start < range.end;
    if !range.is_empty() && !parts.iter().any(overlaps) {
        parts.push(InstructionPart { range, role });
    }
}

/// Splits a range of the instruction at punctuation; none of the clauses is without a letter or digit.
fn clauses(instruction: &str, range: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let mut found = Vec::new();
    let mut start = range.start;
    let text = &instruction[range.clone()];
    let ends = text
        .char_indices()
        .filter(|(at, character)| ends_clause(text, *at, *character))
        .map(|(at, character)| (range.start + at, range.start + at + character.len_utf8()));
    for (end, next) in ends.chain([(range.end, range.end)]) {
        let clause = &instruction[start..end];
        let trimmed = clause.trim_matches(|character: char| !character.is_alphanumeric());
        if !trimmed.is_empty() {
            let offset = start + (trimmed.as_ptr() as usize - clause.as_ptr() as usize);
            found.push(offset..offset + trimmed.len());
        }
        start = next;
    }
    found.into_iter()
}

/// Returns true for punctuation that is not inside a number.
fn ends_clause(text: &str, at: usize, character: char) -> bool {
    const ENDS: &str = ",.;:!?\u{3001}\u{3002}\u{ff0c}\u{ff01}\u{ff1f}\u{ff1b}\u{60c}\u{61f}\u{964}\u{2026}";
    let before = text[..at].chars().next_back().is_some_and(char::is_numeric);
    let after = text[at + character.len_utf8()..]
        .chars()
        .next()
        .is_some_and(char::is_numeric);
    ENDS.contains(character) && !(before && after)
}

/// Returns a part with the goals and constraints whose entities it names.
fn with_role(world: &World, goal: &Goal, mentions: &FullNames, range: Range<usize>) -> InstructionPart {
    let domain = world.domain();
    let named: Vec<EntityId> = mentions.within(&range).collect();
    let names_one = |entities: &[EntityId]| entities.iter().any(|entity| named.contains(entity));
    let goals = goal.facts.iter().enumerate();
    let goals: Vec<usize> = goals
        .filter(|(_, fact)| names_one(&fact.about(domain)))
        .map(|(index, _)| index)
        .collect();
    let constraints = goal.constraints.iter().enumerate();
    let constraints: Vec<usize> = constraints
        .filter(|(_, constraint)| names_one(&constraint.about(domain)))
        .map(|(index, _)| index)
        .collect();
    let role = match (goals.is_empty(), constraints.is_empty()) {
        (false, _) => CoverageRole::Goals(goals),
        (true, false) => CoverageRole::Constraints(constraints),
        (true, true) => CoverageRole::Background,
    };
    InstructionPart { range, role }
}

/// Gives the goals that no part names to the parts that name nothing: in a language without names in the environment,
/// such a part still asked for the goal.
fn attribute_the_rest(goal: &Goal, parts: &mut [InstructionPart]) {
    let has = |parts: &[InstructionPart], index: usize| {
        parts
            .iter()
            .any(|part| matches!(&part.role, CoverageRole::Goals(goals) if goals.contains(&index)))
    };
    let rest: Vec<usize> = (0..goal.facts.len()).filter(|index| !has(parts, *index)).collect();
    if rest.is_empty() {
        return;
    }
    for part in parts.iter_mut().filter(|part| part.role == CoverageRole::Background) {
        part.role = CoverageRole::Goals(rest.clone());
    }
}

/// Returns the entities of a goal and of its constraints.
fn entities(world: &World, goal: &Goal) -> Vec<EntityId> {
    let domain = world.domain();
    let of_goals = goal.facts.iter().flat_map(|fact| fact.about(domain));
    let of_constraints = goal.constraints.iter();
    let mut all: Vec<EntityId> = of_goals
        .chain(of_constraints.flat_map(|constraint| constraint.about(domain)))
        .chain(goal.groups.iter().flat_map(|part| &part.groups).flat_map(Group::about))
        .collect();
    all.sort_unstable();
    all.dedup();
    all
}
