//! Outcomes of sensing actions, and the conditions on them.

use crate::spanned::Spanned;

use super::*;

impl Loader<'_> {
    /// Reads the outcomes of a sensing action.
    pub(super) fn senses(&mut self, entry: &words::ActionEntry, schema: &ActionSchema) -> Vec<Atom> {
        let mut outcomes: Vec<Atom> = Vec::new();
        for text in &entry.senses {
            let Some(literal) = self.literal(text, &schema.parameters) else {
                continue;
            };
            let others = |atom: &Atom| atom.terms != literal.atom.terms || *atom == literal.atom;
            if !literal.holds {
                self.report(text, "an outcome is a fact of its own, not the lack of one");
            } else if outcomes.iter().any(others) {
                self.report(text, "outcomes are different facts about the same things");
            } else {
                outcomes.push(literal.atom);
            }
        }
        if let ([only], [_]) = (entry.senses.as_slice(), outcomes.as_slice()) {
            self.report(
                only,
                "sensing tells which of at least two outcomes holds; add the other one",
            );
        }
        if !outcomes.is_empty() && !schema.effects.is_empty() {
            let message = format!("`{}` senses, so it must not have effects", schema.name);
            self.report(&entry.name, message);
        }
        outcomes
    }

    /// Resolves the event that records that `of` held.
    pub(super) fn past(
        &mut self,
        past: &Spanned<String>,
        of: &Predicate,
        entries: &[words::PredicateEntry],
    ) -> Option<PredicateId> {
        let predicates = &self.semantics.predicates;
        let Some(index) = predicates.iter().position(|p| p.name == *past.get_ref()) else {
            let known = predicates.iter().map(|p| p.name.as_str());
            self.report_unknown(past, "predicate", past.get_ref(), known);
            return None;
        };
        let event = |entry: &words::PredicateEntry| entry.event && entry.name.get_ref() == past.get_ref();
        let same = |(one, other): (&Parameter, &Parameter)| one.kind == other.kind;
        let both = (&of.parameters, &predicates[index].parameters);
        if !entries.iter().any(event) || both.0.len() != both.1.len() || !both.0.iter().zip(both.1).all(same) {
            self.report(past, "`past` names an event about the same things");
        }
        Some(PredicateId::new(index))
    }

    /// Reports negated outcomes in conditions. An unknown outcome does not hold, and neither do its alternatives, so no
    /// condition may require that an outcome does not hold.
    pub(super) fn report_negated_outcomes(&mut self, file: &DomainFile, actions: &[Action], goal_words: &[GoalWord]) {
        let sensed: Vec<PredicateId> = actions
            .iter()
            .flat_map(|a| &a.senses)
            .map(|atom| atom.predicate)
            .collect();
        let negated = |condition: &Condition| {
            let denied = condition.atoms().filter(|(_, holds)| !holds);
            let denied = denied.map(|(atom, _)| atom.predicate);
            denied.filter(|predicate| sensed.contains(predicate)).last()
        };
        let named = |name: &str| file.action.iter().find(|entry| entry.name.get_ref() == name);
        let of_actions = actions.iter().filter_map(|action| {
            let conditions = std::iter::once(&action.precondition).chain(action.effects.iter().map(|e| &e.condition));
            Some((&named(&action.name)?.name, conditions.into_iter().find_map(negated)?))
        });
        let of_goals = goal_words.iter().filter_map(|word| {
            let shown = |entry: &&words::GoalEntry| entry.form.get_ref().starts_with(&word.word);
            Some((&file.goal.iter().find(shown)?.form, negated(&word.condition)?))
        });
        let found: Vec<_> = of_actions.chain(of_goals).collect();
        for (place, predicate) in found {
            let name = &self.semantics.predicates[predicate.index()].name;
            let message =
                format!("this needs that `{name}` does not hold, which is never known: ask for another outcome");
            self.report(place, message);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::shipped_files;

    /// Loads the domain with `from` replaced in one of its files, and checks the diagnostics.
    #[track_caller]
    fn check(from: &str, to: &str, expected: &str) {
        let mut files = shipped_files("household-checks").unwrap();
        let file = if files.words.contains(from) {
            &mut files.words
        } else {
            &mut files.pddl
        };
        assert!(file.contains(from), "{from}");
        *file = file.replacen(from, to, 1);
        let findings = load(&files).map(drop).unwrap_err().to_string();
        assert!(findings.contains(expected), "{from} -> {to}\n{findings}");
    }

    #[test]
    fn domain_load_rejects_invalid_sensing_outcomes() {
        let senses = r#"senses = ["(fresh ?item)", "(expired ?item)"]"#;
        check(senses, r#"senses = ["(fresh ?item)"]"#, "at least two outcomes");
        check(
            senses,
            r#"senses = ["(fresh ?item)", "(not (fresh ?item))"]"#,
            "not the lack of one",
        );
        check(
            senses,
            r#"senses = ["(fresh ?item)", "(fresh ?item)"]"#,
            "different facts about the same things",
        );
        check(senses, r#"senses = ["(fresh ?item)", "(expired ?things)"]"#, "unknown");
        check(
            "name = \"wipe\"\n",
            "name = \"wipe\"\nsenses = [\"(clean ?place)\", \"(dirty ?place)\"]\n",
            "must not have effects",
        );
        check(
            "(:action check-damage\n    :parameters (?item - item)\n    :precondition (and (holding ?item)",
            "(:action check-damage\n    :parameters (?item - item)\n    :precondition (and (holding ?item) (not (broken ?item))",
            "needs that `broken` does not hold",
        );
        check(
            "condition = \"(wiped ?place ?tool)\"",
            "condition = \"(and (wiped ?place ?tool) (not (dirty ?place)))\"",
            "needs that `dirty` does not hold",
        );
    }

    #[test]
    fn past_of_a_fact_has_to_be_an_event_about_its_objects() {
        let past = r#"past = "was-dirty""#;
        check(past, r#"past = "was-durty""#, "did you mean `was-dirty`?");
        check(past, r#"past = "clean""#, "names an event about the same things");
        check(past, r#"past = "adjusted""#, "names an event about the same things");
    }
}
