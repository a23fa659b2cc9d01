//! Lints: probable mistakes in domains that load.
//!
//! [`lint`] sees the domain only, [`lint_environment`] also an environment. They prefer precision: uncertain cases give no
//! finding.

mod effects;
mod environments;
mod explanations;
mod names;
mod never;
mod notation;
mod obsolete;
mod places;
mod reach;
mod reads;
mod synonyms;

#[cfg(test)]
mod tests;

use std::fmt;

pub use self::environments::lint_environment;

use self::places::{Place, Places};
use self::reach::Reach;
use self::reads::Reads;
use longstep::domain::{Domain, Files};
use longstep_core::diagnostic::{Diagnostic, nearest};

macro_rules! lints {
    ($($(#[doc = $doc:literal])+ $variant:ident = $name:literal,)+) => {
        /// The kind of a [`Finding`].
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Lint {
            $($(#[doc = $doc])+ $variant,)+
        }

        impl Lint {
            /// All lints.
            pub const ALL: &[Lint] = &[$(Lint::$variant,)+];

            /// Returns the name in findings and in `[[accept]]`.
            pub fn name(self) -> &'static str {
                match self {
                    $(Lint::$variant => $name,)+
                }
            }
        }
    };
}

lints! {
    /// An action, or a conditional effect of one, whose condition can never hold.
    NeverApplicable = "never-applicable",
    /// A predicate that conditions read and nothing makes true.
    NeverTrue = "never-true",
    /// A goal word that can never be offered or reached, or that no action works towards.
    UnreachableGoal = "unreachable-goal",
    /// A rule that no plan can break.
    VacuousRule = "vacuous-rule",
    /// A fact that blocks an action forever, since no action removes it.
    OneWayState = "one-way-state",
    /// A predicate that actions change and nothing reads.
    UnreadEffect = "unread-effect",
    /// An action whose effects nothing reads.
    UselessAction = "useless-action",
    /// An action that makes one fact both true and false.
    ContradictoryEffect = "contradictory-effect",
    /// Two facts that are both true after an action, although other actions exchange one for the other.
    ConflictingFacts = "conflicting-facts",
    /// An effect with its arguments in another order than in other actions.
    SwappedArguments = "swapped-arguments",
    /// An action after which nothing says where or how an entity is.
    VanishedObject = "vanished-object",
    /// A side effect that no action takes back.
    LostFact = "lost-fact",
    /// A fact that actions only make true, although entities would have to leave it.
    PermanentFact = "permanent-fact",
    /// An effect that the precondition of its action implies.
    IdleEffect = "idle-effect",
    /// An effect on all entities of an action that is about one.
    EffectOnAll = "effect-on-all",
    /// A number that an action changes away from the limit of its precondition.
    WrongDirection = "wrong-direction",
    /// A fact of environments that no action changes and nothing reads.
    DeadState = "dead-state",
    /// A predicate that is never used.
    UnusedPredicate = "unused-predicate",
    /// A type without entities or parameters.
    UnusedType = "unused-type",
    /// Names that a model is likely to confuse.
    ConfusableNames = "confusable-names",
    /// An action, state or goal without an explanation beyond its name.
    MissingExplanation = "missing-explanation",
    /// A sentence that omits a parameter.
    UnnamedParameter = "unnamed-parameter",
    /// Two items with equal explanations.
    SameExplanation = "same-explanation",
    /// A goal word, or the question form, that no few-shot example shows.
    MissingExample = "missing-example",
    /// A file of `prompt/` that cannot be rendered, or an invalid example plan.
    BrokenPrompt = "broken-prompt",
    /// A key that has no effect any more.
    ObsoleteKey = "obsolete-key",
    /// An everyday name that can match no identifier, or that no instruction can contain.
    UnmatchedName = "unmatched-name",
    /// An acceptance that matches no finding or gives no reason.
    StaleAcceptance = "stale-acceptance",
    /// An entity of an environment that no action admits.
    IdleEntity = "idle-entity",
    /// An entity of an environment whose identifier almost matches a derivation.
    NearMiss = "near-miss",
    /// A derivation that matches no entity of an environment.
    IdleDerivation = "idle-derivation",
    /// An entry of `[lexicon]` that matches no entity of an environment.
    IdleName = "idle-name",
    /// A state that an environment does not use and no action makes true.
    UnusedState = "unused-state",
}

impl Lint {
    /// Returns true for a lint that needs an environment.
    fn needs_environment(self) -> bool {
        matches!(
            self,
            Self::IdleEntity | Self::NearMiss | Self::IdleDerivation | Self::IdleName | Self::UnusedState
        )
    }
}

/// A probable mistake.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Finding {
    /// The kind of mistake.
    pub lint: Lint,
    /// Names of the affected items, as in `of` of `[[accept]]`.
    pub of: Vec<String>,
    /// Message, position and hint.
    pub diagnostic: Diagnostic,
}

impl Finding {
    fn new(lint: Lint, of: &[&str], place: Place<'_>, message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self {
            lint,
            of: of.iter().map(|name| (*name).to_owned()).collect(),
            diagnostic: Diagnostic::at(place.file, place.position, message).hint(hint),
        }
    }

    /// Returns the finding with the name of its lint before the message.
    pub fn named(&self) -> Diagnostic {
        let mut named = self.diagnostic.clone();
        named.message = format!("[{}] {}", self.lint.name(), named.message);
        named
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.named().fmt(f)
    }
}

/// Lints a domain; `files` are the files that it was loaded from. Returns the findings that the domain does not accept,
/// sorted by file and position.
///
/// ```
/// use longstep::domain::{load, shipped_files};
/// use longstep_author::lint;
/// let files = shipped_files("household").unwrap();
/// assert_eq!(lint(&load(&files).unwrap(), &files), []);
/// ```
pub fn lint(domain: &Domain, files: &Files) -> Vec<Finding> {
    let Some(places) = Places::read(files) else {
        // The files do not belong to a loaded domain.
        return Vec::new();
    };
    let reach = Reach::of(domain);
    let reads = Reads::of(domain);
    let mut findings = never::findings(domain, &reach, &reads, &places);
    findings.extend(reads::findings(domain, &reads, &places));
    let of_effects = effects::findings(domain, &reach, &places);
    // The finding about the action that causes it says more.
    findings.retain(|own| own.lint != Lint::OneWayState || !of_effects.iter().any(|other| is_cause(other, own)));
    findings.extend(of_effects);
    findings.extend(names::findings(domain, &reach, &places));
    findings.extend(explanations::findings(domain, &reach, &places));
    findings.extend(obsolete::findings(&places));
    findings.extend(synonyms::findings(&places));
    findings.extend(
        longstep::dialogue::broken_parts(domain)
            .into_iter()
            .map(|diagnostic| Finding {
                lint: Lint::BrokenPrompt,
                of: Vec::new(),
                diagnostic,
            }),
    );
    let mut findings = without_accepted(findings, &places);
    findings.sort_by(|left, right| (&left.diagnostic, left.lint).cmp(&(&right.diagnostic, right.lint)));
    findings
}

/// Returns true for the finding about the action that keeps a fact true forever.
fn is_cause(finding: &Finding, one_way: &Finding) -> bool {
    matches!(finding.lint, Lint::PermanentFact | Lint::ConflictingFacts) && finding.of.last() == one_way.of.first()
}

/// Removes the accepted findings about an environment, and sorts the others.
fn without_accepted_of(mut findings: Vec<Finding>, files: &Files) -> Vec<Finding> {
    if let Some(places) = Places::read(files) {
        let accepts = |finding: &Finding| {
            let mut entries = places.words.accept.iter();
            entries.any(|entry| finding.lint.name() == entry.lint.get_ref() && same_names(&finding.of, &entry.of))
        };
        findings.retain(|finding| !accepts(finding));
    }
    findings.sort_by(|left, right| (&left.diagnostic, left.lint).cmp(&(&right.diagnostic, right.lint)));
    findings
}

/// Removes accepted findings. An acceptance that matches none is itself a finding, because its finding may have
/// returned under another name.
fn without_accepted(mut findings: Vec<Finding>, places: &Places<'_>) -> Vec<Finding> {
    let mut stale = Vec::new();
    for entry in &places.words.accept {
        let name = entry.lint.get_ref();
        let of: Vec<&str> = entry.of.iter().map(String::as_str).collect();
        let mut report = |place, message: String, hint: String| {
            stale.push(Finding::new(Lint::StaleAcceptance, &of, place, message, hint));
        };
        let known = Lint::ALL.iter().find(|lint| lint.name() == name);
        let before = findings.len();
        findings.retain(|finding| !(Some(&finding.lint) == known && same_names(&finding.of, &entry.of)));
        if known.is_none() {
            let names = Lint::ALL.iter().map(|lint| lint.name());
            let hint = match nearest(name, names.clone()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("known are {}", names.collect::<Vec<_>>().join(", ")),
            };
            report(places.word(&entry.lint), format!("there is no finding `{name}`"), hint);
        } else if findings.len() == before && !known.is_some_and(|lint| lint.needs_environment()) {
            let message = format!("accepting `{name}` of {} accepts nothing", quoted(&of));
            let hint = "take the acceptance out, or write the names of the finding that it is for in `of`";
            report(places.word(&entry.lint), message, hint.to_owned());
        } else if entry.why.get_ref().trim().is_empty() {
            let message = format!("`{name}` of {} is accepted without a reason", quoted(&of));
            let hint = "say in `why` what makes it right here, for whoever reads the domain next";
            report(places.word(&entry.why), message, hint.to_owned());
        }
    }
    findings.extend(stale);
    findings
}

fn same_names(left: &[String], right: &[String]) -> bool {
    left.len() == right.len() && left.iter().all(|name| right.contains(name))
}

/// Joins names in backticks: `a`, `b` and `c`.
fn quoted(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match &quoted[..] {
        [] => "no names".to_owned(),
        [start @ .., last] if !start.is_empty() => format!("{} and {last}", start.join(", ")),
        _ => quoted.concat(),
    }
}
