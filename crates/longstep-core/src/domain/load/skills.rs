//! The robot's skills in `domain.toml`: retries, and parameters.

use super::Loader;
use crate::domain::words::{ActionEntry, SkillEntry};
use crate::model::{SkillParameter, SkillSource, SkillType};

/// The number of times that a failed step is tried again if the domain does not say so.
const RETRIES: u32 = 2;
/// The most retries that a domain may allow.
const MOST: u32 = 100;
/// The origins of values, as `from` writes them.
const SOURCES: [(&str, SkillSource); 2] = [
    ("demonstration", SkillSource::Demonstration),
    ("robot", SkillSource::Robot),
];

impl Loader<'_> {
    pub(super) fn retries(&mut self, entry: &ActionEntry) -> u32 {
        let Some(retries) = &entry.retries else {
            return RETRIES;
        };
        if *retries.get_ref() > MOST {
            self.report(retries, format!("`retries` is a number from 0 to {MOST}"));
        }
        *retries.get_ref()
    }

    pub(super) fn skills(&mut self, entry: &ActionEntry) -> Vec<SkillParameter> {
        let mut skills: Vec<SkillParameter> = Vec::new();
        for skill in &entry.skill {
            let name = skill.name.get_ref().clone();
            let fits = |c: char| c.is_alphanumeric() || c == '_';
            if name.is_empty() || !name.chars().all(fits) {
                self.report(
                    &skill.name,
                    "the name of a skill parameter is letters, digits and underscores",
                );
            }
            if skills.iter().any(|other| other.name == name) {
                self.report(&skill.name, format!("the skill parameter `{name}` is declared twice"));
            }
            if let (Some(kind), Some(from)) = (self.skill_type(skill), self.skill_source(skill)) {
                if let Some(unit) = skill.unit.as_ref().filter(|_| !kind.has_unit()) {
                    self.report(unit, format!("values of the type `{}` have no unit", kind.name()));
                }
                skills.push(SkillParameter {
                    name,
                    kind,
                    unit: skill.unit.as_ref().map(|unit| unit.get_ref().clone()),
                    from,
                });
            }
        }
        skills
    }

    fn skill_type(&mut self, skill: &SkillEntry) -> Option<SkillType> {
        let name = skill.kind.get_ref();
        let kind = SkillType::ALL.into_iter().find(|kind| kind.name() == name);
        if kind.is_none() {
            let known = SkillType::ALL.map(SkillType::name);
            self.report_unknown(&skill.kind, "type of skill parameters", name, known);
        }
        kind
    }

    fn skill_source(&mut self, skill: &SkillEntry) -> Option<SkillSource> {
        let name = skill.from.get_ref();
        let source = SOURCES.iter().find(|(own, _)| own == name);
        if source.is_none() {
            self.report(&skill.from, "`from` is `demonstration` or `robot`");
        }
        source.map(|(_, source)| *source)
    }
}
