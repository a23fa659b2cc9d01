//! Coverage: the role of every part of an instruction, and the parts that the goal does not represent.
//!
//! A verified plan for a part of what a person said looks like a plan for all of it. [`Coverage`] accounts for the whole
//! text: each part belongs to a goal or a constraint, is background, or is a [`Gap`]. Most gaps are a question to the
//! person before the plan counts as an answer.
//!
//! Gaps have two sources. A model marks parts ([`Mark`]): in the answer of a server, or in a request of its own
//! ([`ScreeningDialogue`](crate::dialogue::ScreeningDialogue)). The others are facts about the text that need no
//! language (`literal`, `names`): numbers and quotations that no goal contains, and entities that the text names in
//! full and that no goal concerns.

mod literal;
mod names;
#[cfg(test)]
mod tests;

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::environment::{EntityId, World};
use crate::goal::{Goal, GoalFact, Group};
use crate::verify::VerifiedPlan;
use names::Mentions;

/// The kind of a part that the goal does not represent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Gap {
    /// Something that must not be done.
    Prohibition,
    /// A number, an amount, a duration or a time.
    Quantity,
    /// A case in which alone something is to be done.
    Condition,
    /// An order in which things are to be done.
    Order,
    /// A quotation.
    Quotation,
    /// An entity of the environment.
    Name,
    /// Anything else.
    Other,
}

impl Gap {
    /// All kinds.
    pub const ALL: [Self; 7] = [
        Self::Prohibition,
        Self::Quantity,
        Self::Condition,
        Self::Order,
        Self::Quotation,
        Self::Name,
        Self::Other,
    ];

    /// Returns the name in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Prohibition => "prohibition",
            Self::Quantity => "quantity",
            Self::Condition => "condition",
            Self::Order => "order",
            Self::Quotation => "quotation",
            Self::Name => "name",
            Self::Other => "other",
        }
    }

    /// Returns true if a plan with this gap is a question to the person; otherwise the gap is only reported.
    pub fn is_question(self) -> bool {
        !matches!(self, Self::Order | Self::Other)
    }
}

/// A part of an instruction that a model marks, as bytes of the instruction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mark {
    /// The part.
    pub range: Range<usize>,
    /// The content of the part beside the wish that something be done.
    pub gap: Gap,
}

impl Mark {
    /// Returns the mark of a whole instruction.
    pub(crate) fn whole(instruction: &str, gap: Gap) -> Self {
        Self {
            range: 0..instruction.len(),
            gap,
        }
    }

    /// Returns the marked text of the instruction. A message has no full stop.
    pub(crate) fn text<'i>(&self, instruction: &'i str) -> &'i str {
        let text = &instruction[self.range.clone()];
        match self.gap {
            Gap::Quotation => text.trim_end_matches(['.', '\u{3002}']),
            _ => text,
        }
    }

    /// Returns true if the mark says that the whole instruction is a prohibition.
    pub(crate) fn is_prohibition_of_all(&self, instruction: &str) -> bool {
        let rest = [&instruction[..self.range.start], &instruction[self.range.end..]].concat();
        self.gap == Gap::Prohibition && !rest.contains(char::is_alphanumeric)
    }

    /// Returns the mark of a quotation from the instruction; none if the instruction does not contain the text.
    pub fn of(instruction: &str, quotation: &str, gap: Gap) -> Option<Self> {
        let text = quotation.trim();
        let start = instruction.find(text).filter(|_| !text.is_empty())?;
        Some(Self {
            range: start..start + text.len(),
            gap,
        })
    }
}

/// The role of a part.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Role {
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
pub struct Part {
    /// The part.
    pub range: Range<usize>,
    /// Its role.
    pub role: Role,
}

/// The parts of an instruction in the order of the text. They do not overlap; what lies between them is space and
/// punctuation.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Coverage {
    instruction: String,
    parts: Vec<Part>,
}

impl Coverage {
    /// Accounts for an instruction: `goal` is what was understood, `marks` are the parts that a model marked, and `plan`
    /// is the plan for the goal. Whatever the plan uses is not missing from the goal.
    ///
    /// ```
    /// use longstep::coverage::{Coverage, Gap};
    /// let planner = longstep::Planner::shipped("household")?;
    /// let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>", "<ruler>"],
    ///     "object_states": {"<pen>": "on_something(<desk>)", "<ruler>": "on_something(<shelf>)"}}"#)?;
    /// let goal = longstep::goal::parse(&world, "put(pen, shelf)").unwrap();
    /// let coverage = Coverage::new(&world, "Put the pen on the shelf in 5 minutes", &goal, &[], None);
    /// let gaps: Vec<(&str, Gap)> = coverage.gaps().collect();
    /// assert_eq!(gaps, [("5", Gap::Quantity)]);
    /// # Ok::<(), longstep::Error>(())
    /// ```
    pub fn new(world: &World, instruction: &str, goal: &Goal, marks: &[Mark], plan: Option<&VerifiedPlan>) -> Self {
        let mentions = Mentions::of(world, instruction);
        let mut gaps = marked(world, instruction, goal, marks);
        for (range, gap) in literal::gaps(world, instruction, goal, &mentions) {
            enter(&mut gaps, range, Role::NotRepresented(gap));
        }
        let said = literal::said(world, instruction, goal);
        let in_message = |range: &Range<usize>| said.iter().any(|own| own.start <= range.start && range.end <= own.end);
        let names = names::gaps(world, instruction, goal, &mentions, plan);
        for range in names.into_iter().filter(|range| !in_message(range)) {
            enter(&mut gaps, range, Role::NotRepresented(Gap::Name));
        }
        Self::with_gaps(world, instruction, goal, &mentions, gaps)
    }

    /// Accounts for an instruction by the parts alone that a model marked.
    pub(crate) fn of_marks(world: &World, instruction: &str, goal: &Goal, marks: &[Mark]) -> Self {
        let mentions = Mentions::of(world, instruction);
        let gaps = marked(world, instruction, goal, marks);
        Self::with_gaps(world, instruction, goal, &mentions, gaps)
    }

    fn with_gaps(world: &World, instruction: &str, goal: &Goal, mentions: &Mentions, mut gaps: Vec<Part>) -> Self {
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
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Returns the text of a part.
    pub fn text(&self, part: &Part) -> &str {
        &self.instruction[part.range.clone()]
    }

    /// Returns the parts that are not represented, as texts with their kinds.
    pub fn gaps(&self) -> impl Iterator<Item = (&str, Gap)> {
        self.parts.iter().filter_map(|part| match part.role {
            Role::NotRepresented(gap) => Some((self.text(part), gap)),
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

/// Returns what an instruction forbids, by its marks, and the rest of it.
pub(crate) fn without_prohibitions(instruction: &str, marks: &[Mark]) -> (String, String) {
    let mut ranges: Vec<Range<usize>> = Vec::new();
    for mark in marks.iter().filter(|mark| mark.gap == Gap::Prohibition) {
        ranges.push(mark.range.clone());
    }
    ranges.sort_by_key(|range| (range.start, range.end));
    let (mut forbidden, mut rest, mut at) = (Vec::new(), String::new(), 0);
    for range in ranges {
        forbidden.push(&instruction[range.clone()]);
        rest.push_str(instruction.get(at..range.start).unwrap_or_default());
        at = at.max(range.end);
    }
    rest.push_str(&instruction[at..]);
    (forbidden.join(" "), rest.trim().to_owned())
}

/// Returns the entities that a text names in full.
pub(crate) fn named(world: &World, text: &str) -> Vec<EntityId> {
    Mentions::of(world, text).within(&(0..text.len())).collect()
}

/// Returns the entities of each name in a text that stands for several.
pub(crate) fn shared_names(world: &World, text: &str) -> Vec<Vec<EntityId>> {
    Mentions::of(world, text).shared().map(<[EntityId]>::to_vec).collect()
}

/// Returns true if a text names an entity in full.
pub(crate) fn names_entity(world: &World, text: &str) -> bool {
    !named(world, text).is_empty()
}

/// Returns the marks that the goal does not represent.
pub(crate) fn missing<'m>(
    world: &World,
    instruction: &str,
    goal: &Goal,
    marks: &'m [Mark],
) -> impl Iterator<Item = &'m Mark> {
    marks
        .iter()
        .filter(move |mark| !is_represented(world, instruction, goal, mark))
}

/// Returns the marked parts that the goal does not represent.
fn marked(world: &World, instruction: &str, goal: &Goal, marks: &[Mark]) -> Vec<Part> {
    let mut missing: Vec<&Mark> = missing(world, instruction, goal, marks).collect();
    // Of overlapping marks the one with a question stays, and of these the longest: consent is to all of its text.
    missing.sort_by_key(|mark| {
        (
            !mark.gap.is_question(),
            std::cmp::Reverse(mark.range.len()),
            mark.range.start,
        )
    });
    let mut gaps = Vec::new();
    for mark in missing {
        enter(&mut gaps, mark.range.clone(), Role::NotRepresented(mark.gap));
    }
    gaps
}

/// Adds a part unless an earlier one overlaps it.
fn enter(parts: &mut Vec<Part>, range: Range<usize>, role: Role) {
    let overlaps = |other: &Part| range.start < other.range.end && other.range.start < range.end;
    if !range.is_empty() && !parts.iter().any(overlaps) {
        parts.push(Part { range, role });
    }
}

/// Returns true if the goal represents what a mark says.
fn is_represented(world: &World, instruction: &str, goal: &Goal, mark: &Mark) -> bool {
    match mark.gap {
        Gap::Prohibition => !goal.constraints.is_empty(),
        Gap::Condition => goal.facts.iter().any(|fact| matches!(fact, GoalFact::If(_))),
        // One goal has no order.
        Gap::Order => !goal.stages.is_empty() || goal.facts.len() < 2,
        Gap::Quantity => literal::is_represented(world, instruction, &mark.range, goal),
        Gap::Quotation => literal::contain(&literal::texts(world, goal), mark.text(instruction)),
        Gap::Name | Gap::Other => false,
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
fn with_role(world: &World, goal: &Goal, mentions: &Mentions, range: Range<usize>) -> Part {
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
        (false, _) => Role::Goals(goals),
        (true, false) => Role::Constraints(constraints),
        (true, true) => Role::Background,
    };
    Part { range, role }
}

/// Gives the goals that no part names to the parts that name nothing: in a language without names in the environment,
/// such a part still asked for the goal.
fn attribute_the_rest(goal: &Goal, parts: &mut [Part]) {
    let has = |parts: &[Part], index: usize| {
        parts
            .iter()
            .any(|part| matches!(&part.role, Role::Goals(goals) if goals.contains(&index)))
    };
    let rest: Vec<usize> = (0..goal.facts.len()).filter(|index| !has(parts, *index)).collect();
    if rest.is_empty() {
        return;
    }
    for part in parts.iter_mut().filter(|part| part.role == Role::Background) {
        part.role = Role::Goals(rest.clone());
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
