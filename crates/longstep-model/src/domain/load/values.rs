//! The value types of a domain: `[value.TYPE]` in `domain.toml`.

use crate::spanned::Spanned;
use indexmap::IndexMap;

use super::super::words::{NumberText, ValueEntry};
use super::{EnvironmentTypes, Loader, TypeId};
use crate::model::{Number, QuantityForm, ValueForm, ValueType};

impl Loader<'_> {
    pub(super) fn values(
        &mut self,
        entries: &IndexMap<Spanned<String>, ValueEntry>,
        environment: &EnvironmentTypes,
    ) -> Vec<ValueType> {
        let mut values: Vec<ValueType> = Vec::new();
        for (name, entry) in entries {
            let types = &self.semantics.types;
            let Some(kind) = types.find(name.get_ref()) else {
                let known = types.names();
                self.report_unknown(name, "type", name.get_ref(), known);
                continue;
            };
            let listed = [environment.asset, environment.object];
            if kind == TypeId::OBJECT || listed.iter().any(|listed| types.is_a(*listed, kind)) {
                self.report(
                    name,
                    "values are no entities of an environment; give them a type of their own",
                );
                continue;
            }
            if let Some(form) = self.value_form(name, entry) {
                self.report_shared_notation(name, &form, &values);
                values.push(ValueType { kind, form });
            }
        }
        values
    }

    fn value_form(&mut self, name: &Spanned<String>, entry: &ValueEntry) -> Option<ValueForm> {
        if entry.text {
            let numeric = entry.unit.is_some() || !entry.units.is_empty() || entry.min.is_some() || entry.max.is_some();
            if numeric {
                self.report(name, "a text has no units and no range");
            }
            return Some(ValueForm::Text);
        }
        let unit = entry.unit.as_ref().map_or("", |unit| unit.get_ref());
        if let Some(place) = entry.unit.as_ref() {
            self.report_unfit_unit(place);
        }
        let mut units = vec![(unit.to_owned(), Number::from(1))];
        for (name, factor) in &entry.units {
            self.report_unfit_unit(name);
            units.push((name.get_ref().clone(), self.decimal(factor)?));
        }
        let bound = |loader: &mut Self, entry: &Option<Spanned<NumberText>>| match entry {
            Some(entry) => loader.decimal(entry),
            None => None,
        };
        let (minimum, maximum) = (bound(self, &entry.min), bound(self, &entry.max));
        if minimum.is_some() && maximum.is_some() && minimum > maximum {
            self.report(name, "`min` is greater than `max`");
        }
        Some(ValueForm::Quantity(QuantityForm {
            unit: unit.to_owned(),
            units,
            minimum,
            maximum,
        }))
    }

    fn report_unfit_unit(&mut self, unit: &Spanned<String>) {
        let text = unit.get_ref();
        let unfit = |c: char| c.is_control() || matches!(c, ',' | '(' | ')' | '&' | '"' | '<' | '>' | '-');
        if text.trim() != text || text.is_empty() || text.contains(unfit) || text.starts_with(char::is_numeric) {
            self.report(
                unit,
                "a unit is a word or a sign such as `degC`, without a digit at its start",
            );
        }
    }

    /// Reports a notation that two types share: a text would not say which of them it means.
    fn report_shared_notation(&mut self, name: &Spanned<String>, form: &ValueForm, earlier: &[ValueType]) {
        for other in earlier {
            let other_name = self.semantics.types.name(other.kind);
            let message = match (form, &other.form) {
                (ValueForm::Text, ValueForm::Text) => format!("`{other_name}` is the type of texts already"),
                (ValueForm::Quantity(own), ValueForm::Quantity(theirs)) => {
                    let shared = own
                        .units
                        .iter()
                        .find(|(unit, _)| theirs.units.iter().any(|(u, _)| u == unit));
                    let Some((unit, _)) = shared else { continue };
                    match unit.as_str() {
                        "" => format!("`{other_name}` is the type of numbers without a unit already"),
                        unit => format!("`{unit}` is a unit of `{other_name}` already"),
                    }
                }
                _ => continue,
            };
            self.report(name, message);
        }
    }
}
