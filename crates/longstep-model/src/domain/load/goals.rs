//! Rules, goal words, and the costs of repair.

use crate::spanned::Spanned;
use indexmap::IndexMap;

use super::*;
use crate::call::is_goal_keyword;

impl Loader<'_> {
    pub(super) fn report_with_hint<T>(&mut self, place: &Spanned<T>, message: String, hint: String) {
        let position = content_position(self.text, place);
        self.findings
            .push(Diagnostic::at(self.file, position, message).hint(hint));
    }

    /// Reports a word of a goal, a state or a number that the goal language reserves.
    pub(super) fn check_goal_keyword(&mut self, place: &Spanned<String>, word: &str) {
        if is_goal_keyword(word) {
            let message = format!("`{word}` is a word of the goal language");
            self.report_with_hint(place, message, format!("write `is_{word}`"));
        }
    }

    pub(super) fn rule(&mut self, entry: &words::RuleEntry, goal_words: &[GoalWord]) -> Rule {
        let mut condition = self.condition(&entry.condition, &[]);
        let mut variables = Vec::new();
        while let Condition::Forall(_, kind, inner) = condition {
            variables.push(any_parameter_of("", kind));
            condition = *inner;
        }
        // The sentence of the rule uses the names of the quantified variables.
        for (variable, name) in variables.iter_mut().zip(quantified_names(entry.condition.get_ref())) {
            variable.name = name;
        }
        for word in &entry.unless {
            if !goal_words.iter().any(|g| g.word == *word.get_ref()) {
                let known = goal_words.iter().map(|g| g.word.as_str());
                self.report_unknown(word, "goal word", word.get_ref(), known);
            }
        }
        Rule {
            name: entry.name.get_ref().clone(),
            time: match entry.holds {
                TimeEntry::Start => RuleTime::Start,
                TimeEntry::Always => RuleTime::Always,
                TimeEntry::End => RuleTime::End,
                TimeEntry::Tidy => RuleTime::Tidy,
            },
            says: self.template(&entry.says, &variables),
            variables,
            condition,
            unless: entry.unless.iter().map(|word| word.get_ref().clone()).collect(),
        }
    }

    pub(super) fn repair_costs(&mut self, entry: &words::RepairEntry) -> RepairCosts {
        let usual = RepairCosts::default();
        let mut cost = |given: &Option<Spanned<u32>>, usual: u32| match given {
            // Costs up to 1000 add up without overflow for drafts of any length.
            Some(given) if !(1..=1000).contains(given.get_ref()) => {
                let position = Position::of(self.text, given.span().start);
                let message = "a cost is a whole number from 1 to 1000";
                self.findings.push(Diagnostic::at(self.file, position, message));
                usual
            }
            Some(given) => *given.get_ref(),
            None => usual,
        };
        RepairCosts {
            insert: cost(&entry.insert, usual.insert),
            replace: cost(&entry.replace, usual.replace),
            other_actor: cost(&entry.other_actor, usual.other_actor),
            postpone: cost(&entry.postpone, usual.postpone),
            rebind: cost(&entry.rebind, usual.rebind),
            drop_idle: cost(&entry.drop_idle, usual.drop_idle),
            drop_impossible: cost(&entry.drop_impossible, usual.drop_impossible),
            drop: cost(&entry.drop, usual.drop),
            other_relation: cost(&entry.other_relation, usual.other_relation),
            forgo: cost(&entry.forgo, usual.forgo),
            unsettle: cost(&entry.unsettle, usual.unsettle),
        }
    }

    pub(super) fn goal_word(&mut self, entry: &words::GoalEntry) -> Option<GoalWord> {
        let semantics = self.semantics;
        let list = Spanned::new(entry.parameters.span(), format!("({})", entry.parameters.get_ref()));
        let parameters = self.read_with(&list, |reader, expression| {
            Some(reader.variables(expression.list().unwrap_or_default(), &semantics.types))
        })?;
        let text = entry.form.get_ref();
        let mut form = Vec::new();
        let mut rest = text.as_str();
        while let Some(start) = rest.find('{') {
            let Some(length) = rest[start..].find('}') else {
                self.report(&entry.form, "a `{` is not closed");
                return None;
            };
            let name = &rest[start + 1..start + length];
            let Some(index) = parameters.iter().position(|p| p.name == name) else {
                self.report_unknown(
                    &entry.form,
                    "parameter",
                    name,
                    parameters.iter().map(|p| p.name.as_str()),
                );
                return None;
            };
            form.push(FormPiece::Text(rest[..start].to_owned()));
            form.push(FormPiece::Parameter(index));
            rest = &rest[start + length + 1..];
        }
        form.push(FormPiece::Text(rest.to_owned()));
        let word = text.split('(').next().unwrap_or_default().trim().to_owned();
        if word.is_empty() || !text.ends_with(')') {
            self.report(&entry.form, "a goal is written as `word({parameter}, ...)`");
        }
        self.check_goal_keyword(&entry.form, &word);
        Some(GoalWord {
            word,
            form,
            condition: self.condition(&entry.condition, &parameters),
            offered: entry
                .offered
                .as_ref()
                .map_or(Condition::TRUE, |offered| self.condition(offered, &parameters)),
            subject: entry.subject.as_ref().and_then(|s| self.parameter(s, &parameters)),
            exclusive: entry.exclusive.clone(),
            disturbs: entry
                .disturbs
                .iter()
                .filter_map(|d| self.parameter(d, &parameters))
                .collect(),
            says: self.template(&entry.says, &parameters),
            asks: entry.asks.as_ref().map(|asks| self.template(asks, &parameters)),
            means: entry.means.clone(),
            parameters,
        })
    }

    /// Reads stems of words. The single words of an instruction are compared in lower case, so a stem that is not one
    /// lower-case word can never match and is an error.
    pub(super) fn stems(&mut self, texts: &[Spanned<String>]) -> Vec<String> {
        for text in texts {
            let stem = text.get_ref();
            let words = plain_words(stem);
            if words.as_slice() == std::slice::from_ref(stem) {
                continue;
            }
            let position = content_position(self.text, text);
            let message =
                format!("`{stem}` never matches: it is compared with the beginning of single words in lower case");
            let finding = Diagnostic::at(self.file, position, message);
            self.findings.push(match words.first() {
                Some(word) => finding.hint(format!("write `{word}`")),
                None => finding.hint("write the beginning of a word, such as `open`"),
            });
        }
        texts.iter().map(|text| text.get_ref().clone()).collect()
    }

    /// Reads words that imply an object without naming it, by the end of its identifier.
    pub(super) fn implied(
        &mut self,
        entries: &IndexMap<Spanned<String>, Vec<Spanned<String>>>,
    ) -> IndexMap<String, Vec<String>> {
        let mut implied = IndexMap::new();
        for (name, stems) in entries {
            let ending = name.get_ref();
            if *ending != base_name(ending) {
                let position = Position::of(self.text, name.span().start);
                let message = format!(
                    "`{ending}` is the end of no identifier: those are compared in lower case and without their number"
                );
                let finding = Diagnostic::at(self.file, position, message);
                self.findings
                    .push(finding.hint(format!("write `{}`", base_name(ending))));
            }
            implied.insert(ending.clone(), self.stems(stems));
        }
        implied
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::shipped_files;

    /// Loads `household` with `from` replaced in its wording, and checks the diagnostics.
    #[track_caller]
    fn check(from: &str, to: &str, expected: &str) {
        let mut files = shipped_files("household").unwrap();
        assert!(files.words.contains(from), "{from}");
        files.words = files.words.replacen(from, to, 1);
        let findings = load(&files).map(drop).unwrap_err().to_string();
        assert!(findings.contains(expected), "{from} -> {to}\n{findings}");
    }

    #[test]
    fn words_that_a_notation_reserves_are_refused_at_their_place() {
        check(
            r#"form = "opened("#,
            r#"form = "untouched("#,
            "`untouched` is a word of the goal language\n  hint: write `is_untouched`",
        );
        check(
            r#"word = "closed()""#,
            r#"word = "never()""#,
            "`never` is a word of the goal language",
        );
        check(
            r#"call = "grasp_object("#,
            r#"call = "while("#,
            "`while` is a word of the notation of plans\n  hint: write `do_while`",
        );
    }

    #[test]
    fn sentences_lose_their_full_stop() {
        let mut files = shipped_files("household").unwrap();
        files.words = files
            .words
            .replacen("says = \"grasp {item}\"", "says = \"Grasp {item}.\"", 1);
        let domain = load(&files).unwrap();
        let grasp = domain.actions.iter().find(|action| action.name == "grasp").unwrap();
        assert_eq!(grasp.says.fill(|_| "the cup".to_owned()), "Grasp the cup");
    }

    #[test]
    fn domain_load_rejects_goal_words_that_never_match() {
        check(
            r#"bin = ["throw""#,
            r#"bin = ["throw away""#,
            "`throw away` never matches",
        );
        check("bin = [\"throw\"", "Bin_1 = [\"throw\"", "hint: write `bin`");
    }
}
