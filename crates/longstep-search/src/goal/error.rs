//! Why a text is not a goal.

use longstep_model::model::OutOfRange;

/// Maximum number of stages.
// Each stage adds facts and operators to the task of the search.
pub(super) const STAGES: usize = 30;

/// The reason why a text is not a goal.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GoalError {
    /// An empty part between two `&`.
    #[error("the goal has an empty part")]
    Empty,
    /// A word that is not a goal word of the domain.
    #[error("`{part}` is not a goal of this domain; write {forms}")]
    UnknownWord {
        /// The part of the goal.
        part: String,
        /// The notations of the domain's goal words.
        forms: String,
    },
    /// More than thirty stages.
    #[error("the goal has more than {STAGES} stages; give the later ones as another instruction")]
    TooManyStages,
    /// A constraint on a fact that can hold in no state.
    #[error("`{part}` can hold in no state of this world, so a rule about it would forbid nothing")]
    NeverHolds {
        /// The constraint.
        part: String,
    },
    /// A goal in place of a rule.
    #[error("`{part}` is a goal and no rule; write `never {part}` or `always {part}`")]
    NotARule {
        /// The goal.
        part: String,
    },
    /// A name that no entity has.
    #[error("`{name}` in `{part}` is nothing in the environment{}", did_you_mean(near))]
    UnknownName {
        /// The part of the goal.
        part: String,
        /// The name.
        name: String,
        /// Entity names that resemble it: a few of which it is a part, or else the nearest one.
        near: Vec<String>,
    },
    /// A name in place of a value.
    #[error("`{name}` in `{part}` is no {kind}; write {form}")]
    NotAValue {
        /// The part of the goal.
        part: String,
        /// The name.
        name: String,
        /// The type of the values.
        kind: String,
        /// Their notation.
        form: String,
    },
    /// A quantity that is out of range for its type.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
    /// A value that the world does not have, since no text with it was given to
    /// [`World::add_values`](longstep_model::model::World::add_values).
    #[error("`{written}` is a value that was not added to the world")]
    NewValue {
        /// The value.
        written: String,
    },
    /// An amount relative to one that is not known.
    #[error("`{text}` in `{part}` is relative to an amount that is not known")]
    UnknownNow {
        /// The part of the goal.
        part: String,
        /// The amount.
        text: String,
    },
    /// A name that several entities have.
    #[error("`{name}` in `{part}` is the name of several entities: {}; write one of these names", candidates.join(", "))]
    SharedName {
        /// The part of the goal.
        part: String,
        /// The name.
        name: String,
        /// The entities, each with its own name and what distinguishes it.
        candidates: Vec<String>,
    },
    /// A word for the speaker or the robot, in an environment that does not say which entity that is.
    #[error(
        "`{name}` in `{part}` is the {key}, and the environment does not say which entity that is; add `\"{key}\": \"<identifier>\"` to it"
    )]
    NobodyNamed {
        /// The part of the goal.
        part: String,
        /// The name.
        name: String,
        /// The key of the environment.
        key: &'static str,
    },
    /// A condition that no sensing action reveals.
    #[error("`{condition}` is nothing that sensing tells here, so no goal can depend on it{}", if forms.is_empty() { String::new() } else { format!("; write {forms}") })]
    NotSensed {
        /// The condition.
        condition: String,
        /// The facts that sensing actions reveal.
        forms: String,
    },
    /// A kind that no type and no entity has.
    #[error("`{kind}` in `{group}` is no type of the domain and no name in the environment{}", near.as_ref().map_or(String::new(), |n| format!("; did you mean `{n}`?")))]
    UnknownKind {
        /// The group.
        group: String,
        /// The kind.
        kind: String,
        /// A kind that resembles it.
        near: Option<String>,
    },
    /// A condition of a group that is no state, property or predicate.
    #[error(
        "`{state}` in `{group}` is no state; write it as an environment does, for example `dirty` or `on_something(table)`"
    )]
    UnknownState {
        /// The group.
        group: String,
        /// The condition.
        state: String,
    },
    /// A group without members.
    #[error("`{group}` has no member: {why}")]
    NoMember {
        /// The group.
        group: String,
        /// The entities of the kind, with the conditions that they fail.
        why: String,
    },
    /// A group that depends on an outcome of sensing that is not known.
    #[error(
        "the members of `{group}` are not known before sensing reveals whether {fact}; write a goal with `if` instead"
    )]
    NotSensedYet {
        /// The group.
        group: String,
        /// The fact.
        fact: String,
    },
    /// Fewer members than the goal requires.
    #[error("`{part}` requires {wanted} members, and the group has {members}; give a number from 1 to that")]
    TooFewMembers {
        /// The part of the goal.
        part: String,
        /// The number of members that the goal requires.
        wanted: usize,
        /// The number of members.
        members: usize,
    },
    /// Groups with too many combinations of members.
    #[error("`{part}` has more than {limit} combinations of members; add a condition with `where`")]
    TooManyMembers {
        /// The part of the goal.
        part: String,
        /// The limit.
        limit: usize,
    },
    /// A member of `all` that does not fit into the goal.
    #[error("`{name}` belongs to `{part}`, and this goal makes no sense for it; leave it out with `except {name}`")]
    DoesNotFit {
        /// The part of the goal.
        part: String,
        /// The member.
        name: String,
    },
    /// A prohibition of steps ends with nothing.
    #[error(
        "`{part}` forbids steps until a goal holds, which only a prohibition of states can do; write a goal in place of the call"
    )]
    StepsUntil {
        /// The part.
        part: String,
    },
    /// A count in a prohibition of steps.
    #[error("`{part}` counts the members of a group, which only goals can; write `all` or `any`")]
    CountOfSteps {
        /// The part of the goal.
        part: String,
    },
    /// A side of a comparison that is no number of the domain.
    #[error("`{text}` in `{part}` should be {expected}")]
    NotANumber {
        /// The part of the goal.
        part: String,
        /// The side of the comparison.
        text: String,
        /// The expected notation.
        expected: String,
    },
    /// An entity of the wrong type.
    #[error("`{name}` in `{part}` is no {expected}")]
    WrongType {
        /// The part of the goal.
        part: String,
        /// The name.
        name: String,
        /// The expected type.
        expected: String,
    },
}

fn did_you_mean(near: &[String]) -> String {
    match near {
        [] => String::new(),
        near => format!("; did you mean `{}`?", near.join("` or `")),
    }
}
