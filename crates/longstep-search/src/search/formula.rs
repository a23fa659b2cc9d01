//! Ground conditions.

/// A literal: the number of a fact in the task, and its truth value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Literal {
    pub(crate) fact: u32,
    pub(crate) holds: bool,
}

impl Literal {
    /// Returns the literal with the other truth value.
    pub(crate) fn opposite(self) -> Self {
        Self {
            fact: self.fact,
            holds: !self.holds,
        }
    }
}

/// A ground condition in negation normal form.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Formula {
    /// Conjunction; true if empty.
    And(Vec<Formula>),
    /// Disjunction; false if empty.
    Or(Vec<Formula>),
    Literal(Literal),
}

impl Formula {
    pub(crate) const TRUE: Formula = Formula::And(Vec::new());
    pub(crate) const FALSE: Formula = Formula::Or(Vec::new());

    /// Returns the literal that a fact has a truth value.
    pub(crate) fn literal(fact: u32, holds: bool) -> Self {
        Self::Literal(Literal { fact, holds })
    }

    pub(crate) fn is_true(&self) -> bool {
        *self == Self::TRUE
    }

    pub(crate) fn is_false(&self) -> bool {
        *self == Self::FALSE
    }

    /// Returns the formula that is true where this one is false.
    pub(crate) fn negated(&self) -> Self {
        match self {
            Self::And(parts) => Self::or(parts.iter().map(Self::negated)),
            Self::Or(parts) => Self::and(parts.iter().map(Self::negated)),
            Self::Literal(literal) => Self::Literal(literal.opposite()),
        }
    }

    /// Returns the flattened conjunction.
    pub(crate) fn and(parts: impl IntoIterator<Item = Formula>) -> Self {
        let mut all = Vec::new();
        for part in parts {
            match part {
                Self::And(inner) => all.extend(inner),
                other if other.is_false() => return Self::FALSE,
                other => all.push(other),
            }
        }
        if all.len() == 1 { all.remove(0) } else { Self::And(all) }
    }

    /// Returns the flattened disjunction.
    pub(crate) fn or(parts: impl IntoIterator<Item = Formula>) -> Self {
        let mut any = Vec::new();
        for part in parts {
            match part {
                Self::Or(inner) => any.extend(inner),
                other if other.is_true() => return Self::TRUE,
                other => any.push(other),
            }
        }
        if any.len() == 1 { any.remove(0) } else { Self::Or(any) }
    }

    /// Returns the number of nodes in the formula.
    pub(crate) fn size(&self) -> usize {
        match self {
            Self::And(parts) | Self::Or(parts) => 1 + parts.iter().map(Self::size).sum::<usize>(),
            Self::Literal(_) => 1,
        }
    }

    /// Replaces every literal and simplifies the result.
    pub(crate) fn map(self, literal: &impl Fn(Literal) -> Formula) -> Self {
        match self {
            Self::And(all) => Self::and(all.into_iter().map(|part| part.map(literal))),
            Self::Or(any) => Self::or(any.into_iter().map(|part| part.map(literal))),
            Self::Literal(inner) => literal(inner),
        }
    }

    pub(crate) fn holds(&self, is: &impl Fn(Literal) -> bool) -> bool {
        match self {
            Self::And(all) => all.iter().all(|part| part.holds(is)),
            Self::Or(any) => any.iter().any(|part| part.holds(is)),
            Self::Literal(literal) => is(*literal),
        }
    }

    pub(crate) fn for_each_mut(&mut self, visit: &mut impl FnMut(&mut Literal)) {
        match self {
            Self::And(parts) | Self::Or(parts) => parts.iter_mut().for_each(|part| part.for_each_mut(visit)),
            Self::Literal(literal) => visit(literal),
        }
    }

    pub(crate) fn for_each(&self, visit: &mut impl FnMut(Literal)) {
        match self {
            Self::And(parts) | Self::Or(parts) => parts.iter().for_each(|part| part.for_each(visit)),
            Self::Literal(literal) => visit(*literal),
        }
    }
}
