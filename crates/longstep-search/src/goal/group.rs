//! Groups of entities in a goal: `all cup where dirty & on_something(table) except mug`.

use super::{GoalError, names};
use longstep_model::call::Call;
use longstep_model::diagnostic::nearest;
use longstep_model::model::{
    Atom, Domain, EntityId, Fact, Literal, Predicate, PredicateId, Term, TypeId, Voice, World, ground, plain_words,
    singular,
};

/// The word before the conditions of a group.
const WHERE: &str = " where ";
/// The word before the exceptions of a group.
const EXCEPT: &str = " except ";
/// The word between conditions of which one is enough.
const OR: &str = " or ";
/// The word before a list of names.
const OF: &str = "of ";
/// The words before a number of members that are left.
const ALL_BUT: &str = "all but ";
/// The word before a negated condition.
const NOT: &str = "not ";
/// The nouns of a group of any entities.
const ANYTHING: [&str; 2] = ["thing", "object"];

/// Maximum number of members that an error lists.
const SHOWN: usize = 6;

/// The number of members for which a goal must hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quantifier {
    /// `all`, `each`: every member.
    All,
    /// `any`: at least one member.
    Any,
    /// `2 of`: at least this many members.
    AtLeast(usize),
    /// `exactly 2 of`: this many members.
    Exactly(usize),
    /// `all but 1 of`: all members but this many, and not these.
    AllBut(usize),
}

impl Quantifier {
    /// Reads the quantifier at the beginning of a text; returns it with the text after it.
    fn read(text: &str) -> Option<(Self, &str)> {
        if let Some((number, rest)) = text.strip_prefix(ALL_BUT).and_then(count) {
            return Some((Self::AllBut(number), rest));
        }
        for (word, quantifier) in [("all ", Self::All), ("each ", Self::All), ("any ", Self::Any)] {
            if let Some(rest) = text.strip_prefix(word) {
                return Some((quantifier, rest.trim_start()));
            }
        }
        let (exactly, text) = match text.strip_prefix("exactly ") {
            Some(rest) => (true, rest.trim_start()),
            None => (false, text),
        };
        let (number, rest) = count(text)?;
        let quantifier = if exactly {
            Self::Exactly(number)
        } else {
            Self::AtLeast(number)
        };
        Some((quantifier, rest))
    }

    fn written(self) -> String {
        match self {
            Self::All => "all".to_owned(),
            Self::Any => "any".to_owned(),
            Self::AtLeast(number) => format!("{number} of"),
            Self::Exactly(number) => format!("exactly {number} of"),
            Self::AllBut(number) => format!("{ALL_BUT}{number} of"),
        }
    }

    /// Returns the quantifier for so many members: that all but one of four are wanted means exactly three.
    fn among(self, members: usize) -> Self {
        match self {
            Self::AllBut(number) => Self::Exactly(members.saturating_sub(number)),
            other => other,
        }
    }

    /// Returns the smallest number of members that satisfies the quantifier.
    pub(super) fn least(self) -> usize {
        match self {
            Self::All | Self::Any | Self::AllBut(_) => 1,
            Self::AtLeast(number) | Self::Exactly(number) => number,
        }
    }
}

/// Reads a number with `of` behind it at the beginning of a text; returns it with the text after it.
fn count(text: &str) -> Option<(usize, &str)> {
    let digits = text.len() - text.trim_start_matches(|letter: char| letter.is_ascii_digit()).len();
    let rest = text[digits..].strip_prefix(" of ")?;
    Some((text[..digits].parse().ok()?, rest.trim_start()))
}

/// The entities that a group is about, before its conditions.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum Noun {
    /// A kind, as it was written.
    Kind(String),
    /// These entities, which were named one by one.
    Named(Vec<EntityId>),
}

/// A condition on the members of a group, evaluated when the goal is read.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Selector {
    /// A state word, a property word, or a predicate in PDDL.
    word: String,
    /// The arguments after the member itself.
    arguments: Vec<EntityId>,
    /// False after `not`.
    holds: bool,
}

/// A group of entities: a quantifier, a kind, conditions and exceptions.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Group {
    /// The number of members for which the goal must hold.
    pub quantifier: Quantifier,
    /// The members in the world in which the goal was read.
    pub members: Vec<EntityId>,
    noun: Noun,
    /// Lists of conditions: a member meets all of one of them. No list, and every entity is a member.
    conditions: Vec<Vec<Selector>>,
    exceptions: Vec<EntityId>,
}

impl Group {
    /// Returns true if a text begins like a group.
    pub(super) fn begins(text: &str) -> bool {
        Quantifier::read(text).is_some()
    }

    /// Returns true if the list of exceptions may continue after the end of this text. A list in parentheses is complete.
    pub(super) fn may_continue(text: &str) -> bool {
        text.split_once(EXCEPT)
            .is_some_and(|(_, exceptions)| !exceptions.trim_start().starts_with('('))
    }

    /// Reads a group and finds its members.
    ///
    /// # Errors
    ///
    /// A kind, a state or a name that does not exist, or a group without a member.
    pub(super) fn read(world: &World, text: &str) -> Result<Self, GoalError> {
        let Some((quantifier, rest)) = Quantifier::read(text) else {
            return Err(GoalError::UnknownKind {
                group: text.to_owned(),
                kind: text.to_owned(),
                near: None,
            });
        };
        if let Some(names) = listed(rest) {
            let mut members = names::entities(world, text, &names, &vec![TypeId::OBJECT; names.len()])?;
            members.sort_unstable();
            members.dedup();
            return Ok(Self {
                quantifier,
                noun: Noun::Named(members.clone()),
                members,
                conditions: Vec::new(),
                exceptions: Vec::new(),
            });
        }
        let rest = without_parentheses(rest);
        let (rest, exceptions) = match rest.split_once(EXCEPT) {
            Some((rest, exceptions)) => (rest, Some(exceptions)),
            None => (rest, None),
        };
        let (kind, conditions) = match rest.split_once(WHERE) {
            Some((kind, conditions)) => (kind.trim(), Some(conditions)),
            None => (rest.trim(), None),
        };
        let kind = without_parentheses(kind);
        let of_kind = of_kind(world, kind);
        if of_kind.is_empty() {
            let names = world.entities().flat_map(|(_, entity)| entity.names.iter());
            let kinds = world.domain().types.names();
            let near = nearest(kind, names.map(String::as_str).chain(kinds));
            return Err(GoalError::UnknownKind {
                group: text.to_owned(),
                kind: kind.to_owned(),
                near: near.map(str::to_owned),
            });
        }
        let conditions = conditions.map_or(Ok(Vec::new()), |any| {
            let lists = any.split(OR).map(|all| Selector::read_all(world, text, all));
            lists.collect::<Result<Vec<_>, GoalError>>()
        })?;
        let exceptions = exceptions.map_or(Ok(Vec::new()), |names| excepted(world, text, names))?;
        let mut members = Vec::new();
        for member in &of_kind {
            if !exceptions.contains(member) && meets(&conditions, world, text, *member)? {
                members.push(*member);
            }
        }
        if members.is_empty() {
            let why = reasons(world, &of_kind, &conditions, &exceptions);
            return Err(GoalError::NoMember {
                group: text.to_owned(),
                why,
            });
        }
        Ok(Self {
            quantifier,
            members,
            noun: Noun::Kind(kind.to_owned()),
            conditions,
            exceptions,
        })
    }

    /// Returns the quantifier for the members that there are.
    pub(super) fn count(&self) -> Quantifier {
        self.quantifier.among(self.members.len())
    }

    /// Returns all entities in the group: its members, those in its conditions, and the exceptions.
    pub fn about(&self) -> Vec<EntityId> {
        let conditions = self.conditions.iter().flatten().flat_map(|own| own.arguments.iter());
        let all = self.members.iter().chain(conditions).chain(&self.exceptions);
        all.copied().collect()
    }

    /// Returns true if the kind is a type of the domain, and no name of entities.
    pub fn is_of_type(&self, domain: &Domain) -> bool {
        matches!(&self.noun, Noun::Kind(kind) if type_of(domain, kind).is_some())
    }

    /// Returns true if its members were named one by one.
    pub(super) fn is_listed(&self) -> bool {
        matches!(self.noun, Noun::Named(_))
    }

    /// Returns the group with a selection of its members.
    pub(super) fn with_members(&self, members: Vec<EntityId>) -> Self {
        Self {
            members,
            ..self.clone()
        }
    }

    /// Writes the group in the goal language; `name` gives the name of each entity.
    pub(super) fn written(&self, name: &dyn Fn(EntityId) -> String) -> String {
        let kind = match &self.noun {
            Noun::Kind(kind) => kind,
            Noun::Named(entities) => return self.listed(entities, name),
        };
        let mut text = format!("{} {kind}", self.quantifier.written());
        let lists = self.conditions.iter();
        let conditions: Vec<String> = lists.map(|all| joined(all, " & ", |own| own.written(name))).collect();
        if !conditions.is_empty() {
            text = format!("{text}{WHERE}{}", conditions.join(OR));
        }
        let exceptions: Vec<String> = self.exceptions.iter().map(|entity| name(*entity)).collect();
        match &exceptions[..] {
            [] => text,
            [one] => format!("{text}{EXCEPT}{one}"),
            // In parentheses, since a comma also separates the arguments of a goal.
            several => format!("{text}{EXCEPT}({})", several.join(", ")),
        }
    }

    /// Writes a group of entities that are named one by one.
    fn listed(&self, entities: &[EntityId], name: &dyn Fn(EntityId) -> String) -> String {
        let names: Vec<String> = entities.iter().map(|entity| name(*entity)).collect();
        let of = match self.quantifier {
            Quantifier::All | Quantifier::Any => OF,
            _ => "",
        };
        format!("{} {of}({})", self.quantifier.written(), names.join(", "))
    }

    /// Writes the group with everyday names.
    pub fn everyday(&self, world: &World) -> String {
        self.written(&|entity| world.entity(entity).name.clone())
    }

    /// Writes the group with the environment's identifiers.
    pub fn exact(&self, world: &World) -> String {
        self.written(&|entity| world.entity(entity).identifier.clone())
    }

    /// Writes the group as a noun phrase: "any clean cup", "each plate (it is on the table)".
    pub fn sentence_in(&self, voice: Voice, world: &World) -> String {
        let kind = match &self.noun {
            Noun::Kind(kind) => kind.clone(),
            Noun::Named(entities) => {
                let names: Vec<String> = entities.iter().map(|entity| voice.name(world, *entity)).collect();
                return format!("{} ({})", self.quantifier.written(), names.join(", "));
            }
        };
        // One list of conditions gives adjectives; of several, each is a sentence.
        let is_adjective = |own: &&Selector| own.holds && own.arguments.is_empty() && self.conditions.len() == 1;
        let (before, after): (Vec<&Selector>, Vec<&Selector>) =
            self.conditions.iter().flatten().partition(is_adjective);
        let before = before.into_iter().map(|own| own.word.to_lowercase().replace('_', " "));
        let noun: Vec<String> = before.chain([kind]).collect();
        let noun = noun.join(" ");
        let mut text = match self.quantifier {
            Quantifier::All => format!("each {noun}"),
            Quantifier::Any => format!("any {noun}"),
            other => format!("{} {noun}", other.written()),
        };
        let sentence = |own: &Selector| own.sentence(voice, world);
        let after = match &self.conditions[..] {
            [] | [_] => joined(after, ", ", sentence),
            several => {
                let lists = several.iter().map(|all| joined(all, ", ", sentence));
                lists.collect::<Vec<_>>().join(OR)
            }
        };
        if !after.is_empty() {
            text = format!("{text} ({after})");
        }
        let exceptions: Vec<String> = self
            .exceptions
            .iter()
            .map(|entity| voice.name(world, *entity))
            .collect();
        if exceptions.is_empty() {
            text
        } else {
            format!("{text} except {}", exceptions.join(", "))
        }
    }

    /// Lists the members: "cup 1, cup 2".
    pub fn members_in(&self, voice: Voice, world: &World) -> String {
        let names: Vec<String> = self.members.iter().map(|member| voice.name(world, *member)).collect();
        names.join(", ")
    }

    /// Maps the group to another world by identifiers; none if an entity is missing there.
    pub(super) fn carried(&self, from: &World, to: &World) -> Option<Self> {
        let there = |entity: &EntityId| to.find(&from.entity(*entity).identifier);
        let lists = self.conditions.iter();
        let conditions = lists.map(|all| all.iter().map(|own| own.carried(from, to)).collect::<Option<Vec<_>>>());
        Some(Self {
            quantifier: self.quantifier,
            members: self.members.iter().map(there).collect::<Option<Vec<_>>>()?,
            noun: match &self.noun {
                Noun::Kind(kind) => Noun::Kind(kind.clone()),
                Noun::Named(entities) => Noun::Named(entities.iter().map(there).collect::<Option<Vec<_>>>()?),
            },
            conditions: conditions.collect::<Option<Vec<_>>>()?,
            exceptions: self.exceptions.iter().map(there).collect::<Option<Vec<_>>>()?,
        })
    }
}

/// Returns the names of a list of entities, in parentheses: `of (book, comic)`; none for a kind.
fn listed(text: &str) -> Option<Vec<&str>> {
    let text = text.strip_prefix(OF).unwrap_or(text).trim();
    let inner = without_parentheses(text);
    // Without a comma, the parentheses enclose a kind.
    let is_list = inner.len() < text.len() && inner.contains(',') && !inner.contains(WHERE) && !inner.contains(EXCEPT);
    is_list.then(|| inner.split(',').map(str::trim).collect())
}

/// Returns true if a member meets all conditions of one of the lists.
fn meets(conditions: &[Vec<Selector>], world: &World, group: &str, member: EntityId) -> Result<bool, GoalError> {
    let mut is_met = conditions.is_empty();
    for all in conditions {
        let mut of_all = true;
        for condition in all {
            // No early exit: a state that only sensing reveals is an error wherever it stands.
            of_all &= condition.is_met(world, group, member)?;
        }
        is_met |= of_all;
    }
    Ok(is_met)
}

/// Returns a text without the parentheses around all of it.
fn without_parentheses(text: &str) -> &str {
    let Some(inner) = text.strip_prefix('(').and_then(|text| text.strip_suffix(')')) else {
        return text;
    };
    let mut depth = 0_i32;
    let closes_early = inner.chars().any(|letter| {
        depth += i32::from(letter == '(') - i32::from(letter == ')');
        depth < 0
    });
    if closes_early {
        text
    } else {
        without_parentheses(inner.trim())
    }
}

/// Returns the words of a name in the singular.
fn singular_words(name: &str) -> Vec<String> {
    plain_words(name).iter().map(|word| singular(word)).collect()
}

/// Returns the type that a kind names, in the singular or the plural. A type comes before an entity with its name.
fn type_of(domain: &Domain, kind: &str) -> Option<TypeId> {
    if let Some(kind) = domain.types.find(kind) {
        return Some(kind);
    }
    let words = singular_words(kind);
    let mut types = domain.types.names();
    let named = types.find(|name| !words.is_empty() && singular_words(name) == words);
    let anything = || ANYTHING.iter().any(|noun| words == [*noun]).then_some(TypeId::OBJECT);
    named.and_then(|name| domain.types.find(name)).or_else(anything)
}

/// Returns the entities of a kind: those of a type, or those with this name. A name of several words belongs to the kind
/// of its last ones: a wine glass is a glass.
fn of_kind(world: &World, kind: &str) -> Vec<EntityId> {
    match type_of(world.domain(), kind) {
        // The hands of a robot, which the domain declares, are not among "all things".
        Some(TypeId::OBJECT) => return world.of_kind(TypeId::OBJECT)[world.domain().constants.len()..].to_vec(),
        Some(kind) => return world.of_kind(kind).to_vec(),
        None => {}
    }
    let wanted = singular_words(kind);
    let is_named = |name: &String| is_of_name(name, &wanted);
    let entities = world
        .entities()
        .filter(|(_, entity)| !wanted.is_empty() && std::iter::once(&entity.name).chain(&entity.names).any(is_named));
    entities.map(|(id, _)| id).collect()
}

/// Returns true if a name ends with the words of a kind.
fn is_of_name(name: &str, kind: &[String]) -> bool {
    let own = singular_words(name);
    let number = own.iter().rev().take_while(|word| is_number(word)).count();
    // A number at the end is a label and no part of the kind: `<mug_2>` is a mug.
    own == kind || own[..own.len() - number].ends_with(kind)
}

fn is_number(word: &str) -> bool {
    word.bytes().all(|byte| byte.is_ascii_digit())
}

/// Reads a list of exceptions: names of entities, or kinds.
fn excepted(world: &World, group: &str, names: &str) -> Result<Vec<EntityId>, GoalError> {
    let names = names.trim();
    let inner = names.strip_prefix('(').and_then(|names| names.strip_suffix(')'));
    let mut excepted = Vec::new();
    for name in inner.unwrap_or(names).split(',').map(str::trim) {
        if type_of(world.domain(), name).is_some() {
            excepted.extend(of_kind(world, name));
            continue;
        }
        // An entity with exactly this name comes before all entities whose names end with it.
        match names::entities(world, group, &[name], &[TypeId::OBJECT]) {
            Ok(found) => excepted.extend(found),
            Err(error) => match of_kind(world, name) {
                several if several.is_empty() => return Err(error),
                several => excepted.extend(several),
            },
        }
    }
    excepted.sort_unstable();
    excepted.dedup();
    Ok(excepted)
}

/// Returns why a kind has no member that meets all conditions, for the first entities of the kind.
fn reasons(world: &World, of_kind: &[EntityId], conditions: &[Vec<Selector>], exceptions: &[EntityId]) -> String {
    let mut reasons = Vec::new();
    for entity in of_kind.iter().take(SHOWN) {
        let fails = |own: &&Selector| !own.is_met(world, "", *entity).unwrap_or(false);
        let why = match conditions.iter().find_map(|all| all.iter().find(fails)) {
            Some(own) => format!("fails `{}`", own.written(&|other| world.entity(other).name.clone())),
            None if exceptions.contains(entity) => "is excepted".to_owned(),
            None => "does not fit".to_owned(),
        };
        reasons.push(format!("{} {why}", world.with_article(*entity)));
    }
    if of_kind.len() > SHOWN {
        reasons.push(format!("and {} more", of_kind.len() - SHOWN));
    }
    reasons.join(", ")
}

fn unknown_state(group: &str, text: &str) -> GoalError {
    GoalError::UnknownState {
        group: group.to_owned(),
        state: text.to_owned(),
    }
}

/// Writes selectors with a word between them.
fn joined<'s>(
    all: impl IntoIterator<Item = &'s Selector>,
    between: &str,
    write: impl Fn(&Selector) -> String,
) -> String {
    all.into_iter().map(write).collect::<Vec<_>>().join(between)
}

impl Selector {
    /// Reads selectors that an entity has to meet together.
    fn read_all(world: &World, group: &str, text: &str) -> Result<Vec<Self>, GoalError> {
        let all = text.split('&');
        all.map(|condition| Self::read(world, group, condition.trim()))
            .collect()
    }

    /// Maps the selector to another world by identifiers; none if an entity is missing there.
    fn carried(&self, from: &World, to: &World) -> Option<Self> {
        let there = |entity: &EntityId| to.find(&from.entity(*entity).identifier);
        Some(Self {
            arguments: self.arguments.iter().map(there).collect::<Option<Vec<_>>>()?,
            ..self.clone()
        })
    }

    fn read(world: &World, group: &str, text: &str) -> Result<Self, GoalError> {
        let (holds, text) = match text.strip_prefix(NOT) {
            Some(text) => (false, text.trim()),
            None => (true, text),
        };
        let call = Call::parse(text).map_err(|_| unknown_state(group, text))?;
        let names: Vec<&str> = call.arguments.iter().map(String::as_str).collect();
        let arguments = names::entities(world, group, &names, &vec![TypeId::OBJECT; names.len()])?;
        let own = Self {
            word: call.name,
            arguments,
            holds,
        };
        if own.literals(world.domain()).is_empty() {
            Err(unknown_state(group, text))
        } else {
            Ok(own)
        }
    }

    /// Returns the facts that the word denotes, over the member and the arguments; empty for an unknown word.
    fn literals(&self, domain: &Domain) -> Vec<Literal> {
        let arity = self.arguments.len();
        let literal = |atom: Atom| Literal { atom, holds: true };
        let mut states = domain.states.iter();
        if let Some(state) = states.find(|state| state.word == self.word && state.parameters.len() == arity) {
            return vec![literal(state.atom.clone())];
        }
        let mut properties = domain.properties.iter().filter(|_| arity == 0);
        if let Some(property) = properties.find(|property| property.word == self.word) {
            return property.literals.clone();
        }
        let is = |predicate: &Predicate| predicate.name == self.word && predicate.parameters.len() == arity + 1;
        let predicate = domain.predicates.iter().position(is).map(PredicateId::new);
        let terms = (0..=arity).map(Term::Variable).collect();
        predicate
            .map(|predicate| literal(Atom { predicate, terms }))
            .into_iter()
            .collect()
    }

    fn facts(&self, domain: &Domain, member: EntityId) -> Vec<(Fact, bool)> {
        let bindings: Vec<EntityId> = [member].into_iter().chain(self.arguments.iter().copied()).collect();
        let literals = self.literals(domain).into_iter();
        literals
            .map(|literal| (ground(&literal.atom, &bindings), literal.holds))
            .collect()
    }

    /// Returns true if a member meets the condition in the state in which the goal is read.
    ///
    /// # Errors
    ///
    /// [`GoalError::NotSensedYet`] if only sensing could reveal it.
    fn is_met(&self, world: &World, group: &str, member: EntityId) -> Result<bool, GoalError> {
        let facts = self.facts(world.domain(), member);
        for (fact, _) in &facts {
            let outcomes = world.domain().outcomes(*fact);
            // An unknown outcome is neither true nor false, and a group has its members before the plan begins.
            if !outcomes.is_empty() && !outcomes.iter().any(|outcome| world.state.holds(*outcome)) {
                return Err(GoalError::NotSensedYet {
                    group: group.to_owned(),
                    fact: Voice::Person.fact(world, *fact, true),
                });
            }
        }
        let met = facts.iter().all(|(fact, holds)| world.state.holds(*fact) == *holds);
        Ok(met == self.holds)
    }

    fn written(&self, name: &dyn Fn(EntityId) -> String) -> String {
        let not = if self.holds { "" } else { NOT };
        let arguments: Vec<String> = self.arguments.iter().map(|entity| name(*entity)).collect();
        if arguments.is_empty() {
            format!("{not}{}", self.word)
        } else {
            format!("{not}{}({})", self.word, arguments.join(", "))
        }
    }

    /// Writes the condition as a sentence about "it".
    fn sentence(&self, voice: Voice, world: &World) -> String {
        let domain = world.domain();
        let mut sentences = Vec::new();
        for literal in self.literals(domain) {
            let words = domain.words(literal.atom.predicate);
            let template = if literal.holds == self.holds {
                &words.says
            } else {
                &words.denies
            };
            sentences.push(template.fill(|place| match literal.atom.terms.get(place) {
                Some(Term::Variable(0)) | None => "it".to_owned(),
                Some(Term::Variable(slot)) => voice.name(world, self.arguments[slot - 1]),
                Some(Term::Constant(entity)) => voice.name(world, *entity),
            }));
        }
        sentences.join(if self.holds { " and " } else { " or " })
    }
}
