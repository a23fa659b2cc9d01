//! Goals with groups as goals about their members.
//!
//! Groups stand wherever a name stands, whatever the goal word. So a text with groups is read once for each combination
//! of members, with identifiers in the places of the groups. `all` gives one goal for each member; the other quantifiers
//! give a [`Choice`].

use super::constraint::{ALWAYS, ANY, NEVER};
use super::{Choice, Constraint, GoalError, GoalFact, Group, Quantifier, fact};
use longstep_model::call::unquoted;
use longstep_model::effort;
use longstep_model::model::{EntityId, World};
use longstep_verify::verify::possibly;

/// Maximum number of combinations of members that are read.
const COMBINATIONS: usize = 10_000;

/// Maximum number of goals, or constraints, for one text.
const GOALS: usize = 300;

/// Maximum number of alternatives in the condition of a choice ([`Choice::size`]).
const ALTERNATIVES: usize = 4_000;

/// Maximum number of ways to read the commas of a text.
// Each group with exceptions may end at any of its commas, so readings multiply.
const READINGS: usize = 16;

/// The group for which `_` stands in a goal that is forbidden.
const ANYTHING: &str = "any thing";

/// A part of a goal, with its groups expanded.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Expansion {
    pub(super) facts: Vec<GoalFact>,
    pub(super) constraints: Vec<Constraint>,
    pub(super) groups: Vec<Group>,
}

impl From<GoalFact> for Expansion {
    fn from(fact: GoalFact) -> Self {
        Self {
            facts: vec![fact],
            ..Self::default()
        }
    }
}

/// Expands a goal without conditions or a constraint.
///
/// # Errors
///
/// The error in the text.
pub(super) fn part(world: &World, text: &str) -> Result<Expansion, GoalError> {
    let is_goal = !text.starts_with(NEVER) && !text.starts_with(ALWAYS) && !Constraint::is_untouched(text);
    let read = expanded(world, text, is_goal);
    // `_` in a call of an action stands for any argument. In a goal it stands for any entity.
    match (read, with_anything(text)) {
        (Err(error), anything) if !is_goal && anything != text => expanded(world, &anything, false).map_err(|_| error),
        (read, _) => read,
    }
}

fn expanded(world: &World, text: &str, is_goal: bool) -> Result<Expansion, GoalError> {
    let readings = readings(world, text);
    if readings.is_empty() {
        return Ok(match Constraint::read(world, text)? {
            Some(constraint) => Expansion {
                constraints: vec![constraint],
                ..Expansion::default()
            },
            None => fact::plain(world, text)?.into(),
        });
    }
    first(readings, |pieces| {
        let places = Places::read(world, pieces)?;
        if is_goal {
            places.goals(world)
        } else {
            places.constraints(world, text)
        }
    })
}

/// Returns a text with a group of any entities in place of each argument `_`.
fn with_anything(text: &str) -> String {
    let mut written = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once(ANY) {
        let begins = before.trim_end().ends_with(['(', ',']);
        let ends = after.trim_start().starts_with([')', ',']);
        written.push_str(before);
        written.push_str(if begins && ends { ANYTHING } else { ANY });
        rest = after;
    }
    written + rest
}

/// Expands a goal without conditions.
///
/// # Errors
///
/// The error in the text.
pub(super) fn goals(world: &World, text: &str) -> Result<Expansion, GoalError> {
    match readings(world, text) {
        readings if readings.is_empty() => Ok(fact::plain(world, text)?.into()),
        readings => first(readings, |pieces| Places::read(world, pieces)?.goals(world)),
    }
}

/// Returns the first reading without an error, else the first error, preferably one in a reading with known names.
fn first(
    readings: Vec<Vec<TextPiece<'_>>>,
    expand: impl Fn(Vec<TextPiece<'_>>) -> Result<Expansion, GoalError>,
) -> Result<Expansion, GoalError> {
    let mut errors = Vec::new();
    for pieces in readings {
        match expand(pieces) {
            Ok(expansion) => return Ok(expansion),
            Err(error) => errors.push(error),
        }
    }
    let known = errors.iter().position(|error| !is_unknown(error));
    Err(errors.swap_remove(known.unwrap_or(0)))
}

/// Returns true for an error about a name that the world does not have.
fn is_unknown(error: &GoalError) -> bool {
    use GoalError::{NotAValue, UnknownName, UnknownWord};
    matches!(error, UnknownName { .. } | NotAValue { .. } | UnknownWord { .. })
}

/// A piece of a text with groups.
#[derive(Debug, Clone, Copy)]
enum TextPiece<'t> {
    Text(&'t str),
    Group(&'t str),
}

/// Returns the ways to divide a text into groups and the text around them; none for a text without groups.
///
/// A comma ends a group, or continues its list of exceptions. The shortest groups come first.
fn readings<'t>(world: &World, text: &'t str) -> Vec<Vec<TextPiece<'t>>> {
    let Some((start, ends)) = first_group(world, text) else {
        return Vec::new();
    };
    let mut all = Vec::new();
    for end in ends {
        let own = [TextPiece::Text(&text[..start]), TextPiece::Group(&text[start..end])];
        let mut rests = readings(world, &text[end..]);
        if rests.is_empty() {
            rests.push(vec![TextPiece::Text(&text[end..])]);
        }
        all.extend(rests.into_iter().map(|rest| [&own[..], &rest].concat()));
        if all.len() >= READINGS {
            break;
        }
    }
    all.truncate(READINGS);
    all
}

/// Returns the start and the possible ends of the first group among the arguments of a text.
fn first_group(world: &World, text: &str) -> Option<(usize, Vec<usize>)> {
    let known = |name: &str| !world.named(name).is_empty();
    let (mut argument, mut before) = (0, ' ');
    let mut named = 0;
    // The rest of a text after a group begins within parentheses.
    let mut inside = text.starts_with([',', ')']);
    for (at, letter) in unquoted(text) {
        if at >= named && inside && matches!(before, '(' | ',' | ' ') && Group::begins(&text[at..]) {
            let ends = ends(text, at);
            let end = ends.first().copied().unwrap_or(text.len());
            // An entity may be called like a group, for example `all purpose cleaner`.
            if !known(text[argument..end].trim()) && !known(text[at..end].trim()) {
                return Some((at, ends));
            }
            named = end;
        }
        if matches!(letter, '(' | ',') {
            (argument, inside) = (at + 1, true);
        }
        before = letter;
    }
    None
}

/// Returns the possible ends of a group that starts at a position.
fn ends(text: &str, start: usize) -> Vec<usize> {
    let mut depth = 0_usize;
    let mut ends = Vec::new();
    for (at, letter) in unquoted(&text[start..]) {
        let at = start + at;
        match letter {
            '(' => depth += 1,
            ')' if depth == 0 => {
                ends.push(at);
                break;
            }
            ')' => depth -= 1,
            ',' if depth == 0 => {
                ends.push(at);
                if !Group::may_continue(&text[start..at]) {
                    break;
                }
            }
            _ => {}
        }
    }
    if ends.is_empty() {
        ends.push(text.len());
    }
    ends
}

/// A text with groups in some places.
struct Places<'t> {
    pieces: Vec<TextPiece<'t>>,
    groups: Vec<Group>,
}

/// The goals for the combinations of members that make sense.
type Leaves<T> = Vec<(Vec<EntityId>, T)>;

impl<'t> Places<'t> {
    fn read(world: &World, pieces: Vec<TextPiece<'t>>) -> Result<Self, GoalError> {
        let groups = pieces.iter().filter_map(|piece| match piece {
            TextPiece::Text(_) => None,
            TextPiece::Group(text) => Some(Group::read(world, text.trim())),
        });
        let groups = groups.collect::<Result<Vec<Group>, GoalError>>()?;
        Ok(Self { pieces, groups })
    }

    /// Returns the text as it was written.
    fn written(&self) -> String {
        let mut written = String::new();
        for TextPiece::Text(text) | TextPiece::Group(text) in &self.pieces {
            written.push_str(text);
        }
        written
    }

    /// Returns the text with the identifiers of members in the places of the groups.
    fn text_of(&self, world: &World, members: &[EntityId]) -> String {
        let mut identifiers = members.iter().map(|member| world.entity(*member).identifier.as_str());
        let mut all = String::new();
        for piece in &self.pieces {
            all.push_str(match piece {
                TextPiece::Text(text) => text,
                TextPiece::Group(_) => identifiers.next().unwrap_or_default(),
            });
        }
        all
    }

    /// Returns all combinations of members, the last group fastest.
    fn combinations(&self) -> Result<Vec<Vec<EntityId>>, GoalError> {
        let sizes = self.groups.iter().map(|group| group.members.len());
        // Refused before the combinations fill the memory.
        if sizes.fold(1, usize::saturating_mul) > COMBINATIONS {
            return Err(self.too_many(COMBINATIONS));
        }
        let mut all = vec![Vec::new()];
        for group in &self.groups {
            let pairs = all
                .iter()
                .flat_map(|own| group.members.iter().map(move |member| (own, *member)));
            all = pairs
                .map(|(own, member): (&Vec<EntityId>, EntityId)| [&own[..], &[member]].concat())
                .collect();
        }
        Ok(all)
    }

    fn too_many(&self, limit: usize) -> GoalError {
        GoalError::TooManyMembers {
            part: self.written(),
            limit,
        }
    }

    /// Reads the text for each combination of members. Leaves out those that make no sense: members of a type that the
    /// place of the group does not take, and combinations with one entity in two places.
    fn leaves<T>(
        &self,
        world: &World,
        read: &dyn Fn(&str) -> Result<T, GoalError>,
        about: &dyn Fn(&T) -> Vec<EntityId>,
        fits: &dyn Fn(&T) -> bool,
    ) -> Result<Leaves<T>, GoalError> {
        let mut leaves = Vec::new();
        let mut misfit = None;
        for members in self.combinations()? {
            if !effort::spend(effort::KEPT) {
                return Err(self.too_many(COMBINATIONS));
            }
            match read(&self.text_of(world, &members)) {
                Ok(leaf) => {
                    let all = about(&leaf);
                    let once = |member: &EntityId| all.iter().filter(|other| *other == member).count() <= 1;
                    if members.iter().all(once) && fits(&leaf) {
                        leaves.push((members, leaf));
                    }
                }
                Err(error) if is_about_a_member(world, &error, &members) => {
                    misfit.get_or_insert(error);
                }
                Err(error) => return Err(error),
            }
        }
        // A check that ran out of budget would leave members out.
        if effort::is_exhausted() {
            return Err(self.too_many(COMBINATIONS));
        }
        if leaves.is_empty() {
            return Err(misfit.unwrap_or_else(|| GoalError::NoMember {
                group: self.written(),
                why: "the goal makes sense for no entity of the kind".to_owned(),
            }));
        }
        Ok(leaves)
    }

    fn goals(self, world: &World) -> Result<Expansion, GoalError> {
        let leaves = self.leaves_of(world, "")?;
        self.require_all(world, &leaves)?;
        let facts = self.nested(leaves)?;
        Ok(Expansion {
            facts,
            groups: self.groups,
            constraints: Vec::new(),
        })
    }

    /// Reads the goals for all combinations; `prefix` precedes the goal in the text.
    fn leaves_of(&self, world: &World, prefix: &str) -> Result<Leaves<GoalFact>, GoalError> {
        let domain = world.domain();
        let read = |text: &str| fact::plain(world, text.strip_prefix(prefix).unwrap_or(text).trim());
        let mut leaves = self.leaves(world, &read, &|fact| fact.about(domain), &|fact| {
            self.makes_sense(world, fact, prefix != NEVER)
        })?;
        // A state word may have the name of a goal word, which takes fewer types.
        let is_word = |(_, fact): &(Vec<EntityId>, GoalFact)| matches!(fact, GoalFact::Word { .. });
        if leaves.iter().any(is_word) {
            leaves.retain(is_word);
        }
        Ok(leaves)
    }

    /// Returns true if the members fit: into the parameters of the predicate, and if `offered`, for members of a whole type,
    /// into the static conditions under which the goal is on offer. A prohibition has no such condition: it must forbid
    /// all that it names.
    fn makes_sense(&self, world: &World, fact: &GoalFact, offered: bool) -> bool {
        let domain = world.domain();
        match fact {
            GoalFact::Plain(fact) => {
                let parameters = &domain.predicate(fact.predicate()).parameters;
                let mut places = domain.arguments(*fact).zip(parameters);
                places.all(|(argument, parameter)| world.is_of_kind(argument, parameter.kind))
            }
            // Entities that were named are meant, whether or not it is possible.
            GoalFact::Word { word, arguments } if offered && self.is_of_type(world) => {
                possibly(world, &domain.goal_word(*word).offered, &mut arguments.clone())
            }
            _ => true,
        }
    }

    /// Returns true if a group has the kind of a type.
    fn is_of_type(&self, world: &World) -> bool {
        self.groups.iter().any(|group| group.is_of_type(world.domain()))
    }

    /// Refuses `all` of a name, and a list of names, if the goal leaves a member out: none may be forgotten.
    fn require_all<T>(&self, world: &World, leaves: &Leaves<T>) -> Result<(), GoalError> {
        let domain = world.domain();
        for (place, group) in self.groups.iter().enumerate() {
            let is_required = group.quantifier == Quantifier::All || group.is_listed();
            if !is_required || group.is_of_type(domain) {
                continue;
            }
            let has_goal = |member: EntityId| leaves.iter().any(|(members, _)| members[place] == member);
            let is_left_out = |member: &&EntityId| !has_goal(**member) && !self.names_outside_groups(world, **member);
            if let Some(left_out) = group.members.iter().find(is_left_out) {
                return Err(GoalError::DoesNotFit {
                    part: self.written(),
                    name: world.entity(*left_out).name.clone(),
                });
            }
        }
        Ok(())
    }

    /// Returns true if the text around the groups names the entity.
    fn names_outside_groups(&self, world: &World, entity: EntityId) -> bool {
        self.pieces.iter().any(|piece| match piece {
            TextPiece::Text(text) => names(world, text, entity),
            TextPiece::Group(_) => false,
        })
    }

    /// Returns a goal for each combination of members of the groups with `all`: a choice over the other groups.
    fn nested(&self, leaves: Leaves<GoalFact>) -> Result<Vec<GoalFact>, GoalError> {
        let is_all = |group: &Group| group.quantifier == Quantifier::All;
        let outer: Vec<bool> = self.groups.iter().map(is_all).collect();
        // The order of the members stays, so that equal texts give equal goals.
        let mut cases: indexmap::IndexMap<Vec<EntityId>, Leaves<GoalFact>> = indexmap::IndexMap::new();
        for (members, fact) in leaves {
            let (outer, inner) = divided(&members, &outer);
            cases.entry(outer).or_default().push((inner, fact));
        }
        if cases.len() > GOALS {
            return Err(self.too_many(GOALS));
        }
        let inner: Vec<&Group> = self
            .groups
            .iter()
            .zip(&outer)
            .filter(|(_, outer)| !**outer)
            .map(|(g, _)| g)
            .collect();
        let mut facts = Vec::new();
        for goals in cases.into_values() {
            if inner.is_empty() {
                facts.extend(goals.into_iter().map(|(_, fact)| fact));
            } else {
                facts.push(GoalFact::Choice(self.choice(&inner, goals)?));
            }
        }
        Ok(facts)
    }

    fn choice(&self, groups: &[&Group], goals: Leaves<GoalFact>) -> Result<Choice, GoalError> {
        let mut own = Vec::new();
        for (place, group) in groups.iter().enumerate() {
            let takes_part = |member: &EntityId| goals.iter().any(|(members, _)| members[place] == *member);
            let members: Vec<EntityId> = group.members.iter().copied().filter(takes_part).collect();
            let group = group.with_members(members);
            let (least, members) = (group.count().least(), group.members.clone());
            if least == 0 || least > members.len() {
                return Err(GoalError::TooFewMembers {
                    part: self.written(),
                    wanted: least,
                    members: members.len(),
                });
            }
            own.push(group);
        }
        let choice = Choice { groups: own, goals };
        if choice.size() > ALTERNATIVES {
            return Err(self.too_many(ALTERNATIVES));
        }
        Ok(choice)
    }

    /// Expands a constraint. A prohibition concerns each member of `all` and of `any`.
    fn constraints(self, world: &World, text: &str) -> Result<Expansion, GoalError> {
        let concerns_each = self.groups.iter().all(|group| match group.quantifier {
            Quantifier::All => true,
            // After `never`, `any` and `all` mean the same: no member.
            Quantifier::Any => !text.starts_with(ALWAYS),
            Quantifier::AtLeast(_) | Quantifier::Exactly(_) | Quantifier::AllBut(_) => false,
        });
        let constraints = if concerns_each {
            self.constraint_leaves(world)?
        } else {
            let (prefix, holds) = match text.strip_prefix(ALWAYS) {
                Some(_) => (ALWAYS, true),
                None => (NEVER, false),
            };
            if !text.starts_with(prefix) || self.forbids_steps(world)? {
                return Err(GoalError::CountOfSteps { part: text.to_owned() });
            }
            let leaves = self.leaves_of(world, prefix)?;
            let facts = self.nested(leaves)?.into_iter();
            facts
                .map(|fact| Constraint::state(world, text, fact, holds))
                .collect::<Result<Vec<_>, GoalError>>()?
        };
        if constraints.len() > GOALS {
            return Err(self.too_many(GOALS));
        }
        Ok(Expansion {
            constraints,
            groups: self.groups,
            facts: Vec::new(),
        })
    }

    /// Reads the constraint for each combination. Those about what can hold in no state are left out, since they constrain
    /// nothing.
    fn constraint_leaves(&self, world: &World) -> Result<Vec<Constraint>, GoalError> {
        let domain = world.domain();
        let typed = self.is_of_type(world);
        let about = |own: &Constraint| own.about(domain);
        let fits = |own: &Constraint| self.constraint_makes_sense(world, own);
        let leaves = self.leaves(
            world,
            &|text| constraint_of_leaf(world, text, typed),
            &|own: &Result<Constraint, GoalError>| own.as_ref().map_or_else(|_| Vec::new(), about),
            &|own: &Result<Constraint, GoalError>| own.as_ref().is_ok_and(fits) || own.is_err(),
        )?;
        let (found, impossible): (Vec<_>, Vec<_>) = leaves.into_iter().map(|(_, own)| own).partition(Result::is_ok);
        let mut constraints: Vec<Constraint> = Vec::new();
        for own in found.into_iter().flatten() {
            if !constraints.contains(&own) {
                constraints.push(own);
            }
        }
        match impossible.into_iter().find_map(Result::err) {
            Some(error) if constraints.is_empty() => Err(error),
            _ => Ok(constraints),
        }
    }

    fn constraint_makes_sense(&self, world: &World, constraint: &Constraint) -> bool {
        let constraint = match constraint {
            Constraint::Until { constraint, .. } => constraint,
            other => other,
        };
        match constraint {
            Constraint::State { fact, .. } => self.makes_sense(world, fact, false),
            _ => true,
        }
    }

    /// Returns true if the text is a prohibition of steps.
    fn forbids_steps(&self, world: &World) -> Result<bool, GoalError> {
        let mut constraints = self.combinations()?.into_iter();
        let read = constraints.find_map(|members| Constraint::read(world, &self.text_of(world, &members)).ok()?);
        Ok(matches!(read, Some(Constraint::Step { .. })))
    }
}

/// Divides members into those of the outer groups and the others.
fn divided(members: &[EntityId], outer: &[bool]) -> (Vec<EntityId>, Vec<EntityId>) {
    let mut divided = (Vec::new(), Vec::new());
    for (member, is_outer) in members.iter().zip(outer) {
        let side = if *is_outer { &mut divided.0 } else { &mut divided.1 };
        side.push(*member);
    }
    divided
}

/// Reads the constraint for one combination of members. The inner error is that of a rule which binds none of them, though it may
/// bind others.
fn constraint_of_leaf(world: &World, text: &str, typed: bool) -> Result<Result<Constraint, GoalError>, GoalError> {
    match Constraint::read(world, text) {
        Err(error @ GoalError::NeverHolds { .. }) if typed || text.starts_with(NEVER) => Ok(Err(error)),
        Ok(Some(constraint)) => Ok(Ok(constraint)),
        Ok(None) => Err(GoalError::NotARule { part: text.to_owned() }),
        Err(error) => Err(error),
    }
}

/// Returns true if a member of the wrong type is the reason of an error.
fn is_about_a_member(world: &World, error: &GoalError, members: &[EntityId]) -> bool {
    match error {
        GoalError::WrongType { name, .. } => members.iter().any(|member| world.entity(*member).identifier == *name),
        _ => false,
    }
}

/// Returns true if an argument in a text is the name of an entity.
fn names(world: &World, text: &str, entity: EntityId) -> bool {
    let entity = world.entity(entity);
    let mut arguments = text.split(['(', ')', ',']).map(str::trim);
    arguments.any(|argument| argument == entity.name || argument == entity.identifier)
}
