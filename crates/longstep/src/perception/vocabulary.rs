//! The state words of a domain that a model may use.

use crate::model::{Domain, StateWord, Term, TypeId};

/// Maximum number of constants that are offered as one argument.
const CONSTANTS: usize = 50;

/// The state words of a domain whose arguments are entities.
#[derive(Debug, Clone)]
pub(super) struct Vocabulary<'a> {
    domain: &'a Domain,
    words: Vec<&'a StateWord>,
}

/// The list of an environment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum List {
    Assets,
    Objects,
}

impl<'a> Vocabulary<'a> {
    /// Selects the words. States with values, such as a temperature, are left out: no list of names has them.
    pub(super) fn of(domain: &'a Domain) -> Self {
        let mut vocabulary = Self {
            domain,
            words: Vec::new(),
        };
        let is_about_entities =
            |word: &&StateWord| (1..=word.parameters.len()).all(|slot| vocabulary.can_be_filled(word, slot));
        vocabulary.words = domain.states.iter().filter(is_about_entities).collect();
        vocabulary
    }

    pub(super) fn words(&self) -> impl Iterator<Item = &'a StateWord> {
        self.words.iter().copied()
    }

    pub(super) fn find(&self, name: &str) -> Option<&'a StateWord> {
        self.words().find(|word| word.word == name)
    }

    pub(super) fn kind_of(&self, list: List) -> TypeId {
        match list {
            List::Assets => self.domain.environment.asset,
            List::Objects => self.domain.environment.object,
        }
    }

    /// Returns the type of a slot of a word: 0 is the entity of the entry.
    pub(super) fn slot_kind(&self, word: &StateWord, slot: usize) -> Option<TypeId> {
        let place = word.atom.terms.iter().position(|term| *term == Term::Variable(slot))?;
        let predicate = self.domain.predicate(word.atom.predicate);
        Some(predicate.parameters.get(place)?.kind)
    }

    /// Returns true if an entity of a list can be in a slot. Its type may become more precise by that.
    pub(super) fn fits(&self, word: &StateWord, slot: usize, list: List) -> bool {
        let types = &self.domain.types;
        let own = self.kind_of(list);
        self.slot_kind(word, slot)
            .is_some_and(|kind| types.is_a(own, kind) || types.is_a(kind, own))
    }

    /// Returns the constants of the domain that can be in a slot.
    pub(super) fn constants(&self, word: &StateWord, slot: usize) -> impl Iterator<Item = &'a str> {
        let kind = self.slot_kind(word, slot);
        let domain = self.domain;
        let fits = move |own: TypeId| kind.is_some_and(|kind| domain.types.is_a(own, kind));
        let all = domain.constants.iter().filter(move |(_, own)| fits(*own));
        all.map(|(name, _)| name.as_str()).take(CONSTANTS)
    }

    /// Returns true for the name of a constant, which no list of an environment has.
    pub(super) fn is_constant(&self, name: &str) -> bool {
        self.domain.constants.iter().any(|(own, _)| own == name)
    }

    fn can_be_filled(&self, word: &StateWord, slot: usize) -> bool {
        let listed = [List::Assets, List::Objects]
            .into_iter()
            .any(|list| self.fits(word, slot, list));
        listed || self.constants(word, slot).next().is_some()
    }

    /// Returns the sentence of a state, with a name for each slot.
    pub(super) fn sentence(&self, word: &StateWord, name: &dyn Fn(usize) -> String) -> String {
        let words = self.domain.words(word.atom.predicate);
        words.says.fill(|place| term(word, place, name, self.domain))
    }

    /// Returns the short form of a state after its first entity, such as "on the shelf".
    pub(super) fn short(&self, word: &StateWord, name: &dyn Fn(usize) -> String) -> Option<String> {
        let words = self.domain.words(word.atom.predicate);
        let short = words.short.as_ref()?;
        Some(short.fill(|place| term(word, place, name, self.domain)))
    }
}

fn term(word: &StateWord, place: usize, name: &dyn Fn(usize) -> String, domain: &Domain) -> String {
    match word.atom.terms.get(place) {
        Some(Term::Variable(slot)) => name(*slot),
        Some(Term::Constant(entity)) => domain
            .constants
            .get(entity.index())
            .map_or(String::new(), |(name, _)| name.clone()),
        None => String::new(),
    }
}
