//! The robot's skills in `domain.toml`: retries, and parameters.

use super::{Loader, SkillsSource};
use crate::domain::words::{ActionEntry, SkillEntry};
use crate::model::{SkillFit, SkillParameter, SkillSource, SkillType};

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

    /// The skill parameters of an action: those of `domain.toml`, then those of `skills.toml`.
    pub(super) fn skills(&mut self, entry: &ActionEntry) -> Vec<SkillParameter> {
        let mut skills = self.parameters(Vec::new(), &entry.skill);
        let Some(file) = self.skills else {
            return skills;
        };
        let mut loader = self.of_skills(file);
        for more in file
            .words
            .action
            .iter()
            .filter(|more| more.name.get_ref() == entry.name.get_ref())
        {
            skills = loader.parameters(skills, &more.skill);
        }
        skills
    }

    /// Reports entries of `skills.toml` for actions that `domain.toml` does not name.
    pub(super) fn check_skills(&mut self, actions: &[ActionEntry]) {
        let Some(file) = self.skills else {
            return;
        };
        let names = || actions.iter().map(|action| action.name.get_ref().as_str());
        let mut loader = self.of_skills(file);
        for (index, entry) in file.words.action.iter().enumerate() {
            let name = entry.name.get_ref();
            if !names().any(|own| own == name) {
                loader.report_unknown(&entry.name, "action", name, names());
            }
            let before = &file.words.action[..index];
            if before.iter().any(|other| other.name.get_ref() == name) {
                loader.report(&entry.name, format!("the action `{name}` has a second entry"));
            }
        }
    }

    /// A loader that reports in `skills.toml`.
    fn of_skills<'b>(&'b mut self, file: &'b SkillsSource<'b>) -> Loader<'b> {
        Loader {
            file: file.path,
            text: file.text,
            skills: None,
            pddl_file: self.pddl_file,
            semantics: self.semantics,
            findings: self.findings,
        }
    }

    fn parameters(&mut self, mut skills: Vec<SkillParameter>, entries: &[SkillEntry]) -> Vec<SkillParameter> {
        for skill in entries {
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
                let fit = self.fit(skill, kind, from);
                skills.push(SkillParameter {
                    name,
                    kind,
                    unit: skill.unit.as_ref().map(|unit| unit.get_ref().clone()),
                    from,
                    fit,
                    prior: self.prior(skill, fit),
                });
            }
        }
        skills
    }

    fn fit(&mut self, skill: &SkillEntry, kind: SkillType, from: SkillSource) -> Option<SkillFit> {
        let entry = skill.fit.as_ref()?;
        let name = entry.get_ref();
        let Some(fit) = SkillFit::ALL.into_iter().find(|fit| fit.name() == name) else {
            self.report_unknown(entry, "fit", name, SkillFit::ALL.map(SkillFit::name));
            return None;
        };
        if from != SkillSource::Demonstration {
            self.report(entry, "only a parameter with `from = \"demonstration\"` has a `fit`");
        }
        if fit.kind() != kind {
            let message = format!("the fit `{name}` gives values of the type `{}`", fit.kind().name());
            self.report(&skill.kind, message);
        }
        let unit = skill.unit.as_ref().map(|unit| unit.get_ref().as_str());
        if let Some(expected) = fit.unit().filter(|expected| unit != Some(*expected)) {
            self.report(entry, format!("the fit `{name}` needs `unit = \"{expected}\"`"));
        }
        Some(fit)
    }

    fn prior(&mut self, skill: &SkillEntry, fit: Option<SkillFit>) -> Option<[f64; 3]> {
        let entry = skill.prior.as_ref()?;
        if !fit.is_some_and(SkillFit::has_prior) {
            self.report(entry, "only fits of a direction or a displacement have a `prior`");
        }
        let prior: Option<[f64; 3]> = entry.get_ref().as_slice().try_into().ok();
        let length = |prior: &[f64; 3]| prior.iter().map(|part| part * part).sum::<f64>();
        let prior = prior.filter(|prior| (1e-9..1e9).contains(&length(prior)));
        if prior.is_none() {
            self.report(entry, "`prior` is a direction: three numbers, not all of them zero");
        }
        prior
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
