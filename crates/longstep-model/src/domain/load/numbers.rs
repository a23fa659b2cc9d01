//! Words and ranges of numeric functions.

use crate::spanned::Spanned;

use super::super::bare::{is_changed, plain_function};
use super::*;
use crate::call::is_goal_keyword;
use crate::model::{Application, Arithmetic, Comparison, Function, FunctionId, Number, NumberTest, Term, When};

impl Loader<'_> {
    /// Reads the words of all numeric functions; a function without words gets plain ones.
    pub(super) fn functions(&mut self, entries: &[words::NumberEntry], states: &[StateWord]) -> Vec<Function> {
        let semantics = self.semantics;
        for (index, entry) in entries.iter().enumerate() {
            let name = entry.name.get_ref();
            if !semantics.functions.iter().any(|own| own.name == *name) {
                let known = semantics.functions.iter().map(|own| own.name.as_str());
                self.report_unknown(&entry.name, "numeric function", name, known);
            }
            if entries[..index].iter().any(|earlier| earlier.name.get_ref() == name) {
                self.report(&entry.name, format!("the numeric function `{name}` has words twice"));
            }
        }
        let mut functions: Vec<Function> = Vec::with_capacity(semantics.functions.len());
        for (index, declared) in semantics.functions.iter().enumerate() {
            let mut function = plain_function(declared, is_changed(semantics, index));
            function.says = plain_says(declared);
            let named = |entry: &&words::NumberEntry| *entry.name.get_ref() == declared.name;
            if let Some(entry) = entries.iter().find(named) {
                self.function(entry, &mut function);
            }
            if is_goal_keyword(&function.word) {
                let message = format!(
                    "the word `{}` of a number is a word of the goal language",
                    function.word
                );
                let hint = format!("give `{}` another `word` in domain.toml", function.name);
                let position = semantics.function_positions[index];
                self.findings
                    .push(Diagnostic::at(self.pddl_file, position, message).hint(hint));
            }
            if let Some(other) = functions.iter().find(|other| other.word == function.word) {
                let message = format!("the word `{}` stands for `{}`, too", function.word, other.name);
                self.findings.push(Diagnostic::at(
                    self.pddl_file,
                    semantics.function_positions[index],
                    message,
                ));
            }
            if states.iter().any(|state| state.word == function.word) {
                let message = format!("the word `{}` is a state, too", function.word);
                let hint = format!("give `{}` another `word` in domain.toml", function.name);
                let position = semantics.function_positions[index];
                self.findings
                    .push(Diagnostic::at(self.pddl_file, position, message).hint(hint));
            }
            functions.push(function);
        }
        functions
    }

    fn function(&mut self, entry: &words::NumberEntry, function: &mut Function) {
        if let Some(word) = &entry.word {
            match Call::parse(word.get_ref()) {
                Ok(call) if call.arguments.is_empty() => function.word = call.name,
                _ => self.report(word, "the word of a number is one name, such as `level`"),
            }
        }
        if let Some(says) = &entry.says {
            function.says = self.template(says, &function.parameters);
        }
        function.unit.clone_from(&entry.unit);
        function.min = entry.min.as_ref().and_then(|text| self.decimal(text));
        function.max = entry.max.as_ref().and_then(|text| self.decimal(text));
        if let (Some(min), Some(max)) = (function.min, function.max)
            && min > max
        {
            self.report(&entry.name, format!("`min` is {min}, which is more than `max`, {max}"));
        }
    }

    pub(super) fn decimal(&mut self, text: &Spanned<words::NumberText>) -> Option<Number> {
        let number = Number::parse(&text.get_ref().digits());
        if number.is_none() {
            let position = Position::of(self.text, text.span().start);
            let message = "expected a number with at most six places after the point";
            self.findings.push(Diagnostic::at(self.file, position, message));
        }
        number
    }
}

/// Returns the wording of a function without words: `level(the tank)`.
fn plain_says(function: &Predicate) -> Template {
    let holes: Vec<String> = function
        .parameters
        .iter()
        .map(|own| format!("{{{}}}", own.name))
        .collect();
    let index = |name: &str| function.parameters.iter().position(|own| own.name == name);
    Template::read(&format!("{}({})", function.name, holes.join(", ")), index).unwrap_or_default()
}

/// Adds a rule for each function with a range: in every state, its numbers are within it.
pub(super) fn with_ranges(mut rules: Vec<Rule>, functions: &[Function]) -> Vec<Rule> {
    for (index, function) in functions.iter().enumerate() {
        let Some(range) = function.range() else { continue };
        let value = || {
            Arithmetic::Value(Application {
                function: FunctionId::new(index),
                terms: (0..function.parameters.len()).map(Term::Variable).collect(),
                at: When::Now,
            })
        };
        let is = Condition::Number;
        let bound = |comparison: Comparison| {
            move |number: Number| is(NumberTest::Compare(value(), comparison, Arithmetic::Constant(number)))
        };
        let bounds = function.min.map(bound(Comparison::AtLeast)).into_iter();
        let within = bounds.chain(function.max.map(bound(Comparison::AtMost))).collect();
        let unit = function
            .unit
            .as_ref()
            .map_or_else(String::new, |unit| format!(" {unit}"));
        rules.push(Rule {
            name: format!("range of {}", function.name),
            time: RuleTime::Always,
            variables: function.parameters.clone(),
            condition: Condition::Or(vec![is(NumberTest::Known(value(), false)), Condition::And(within)]),
            says: function
                .says
                .followed_by(&format!(" is outside of its range, {range}{unit}")),
            unless: Vec::new(),
        });
    }
    rules
}
