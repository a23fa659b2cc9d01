//! The reader of `robot.toml`, which checks the file by itself.

use std::collections::BTreeMap;
use std::ops::Range;
use std::time::Duration;

use longstep_core::diagnostic::{Diagnostic, Diagnostics};
use longstep_core::secret;
use longstep_core::spanned::Spanned;
use serde_json::{Map, Value, json};

use super::configuration::{
    ANY, ActionRule, Configuration, Heartbeat, Limits, ObservationRule, Origin, OutcomeRule, SayRule, Service, Serving,
    Source,
};
use super::criterion::Criterion;
use super::file::{ActionEntry, ObservationEntry, RobotFile, SayEntry, Servers, ServiceEntry, Text, TimeoutEntry};
use super::template::{Filter, Table, Template, TemplateError};
use crate::rosbridge::Address;

/// The port of a bridge whose URL has none.
const PORT: u16 = 9090;
/// The most orders at the same time.
const PARALLEL_LIMIT: usize = 64;
/// The longest timeout, in seconds: a day.
const TIMEOUT_LIMIT: f64 = 86_400.0;
/// The longest `robot.toml`.
const LONGEST: usize = 4 << 20;

impl Configuration {
    /// Reads `robot.toml`.
    ///
    /// # Errors
    ///
    /// All mistakes that need no domain to be seen, with their places.
    pub fn parse(file: &str, text: &str) -> Result<Self, Diagnostics> {
        let source = Source {
            file: file.to_owned(),
            text: text.to_owned(),
        };
        if text.len() > LONGEST {
            let message = format!("the file has more than {} MiB", LONGEST >> 20);
            return Err(Diagnostics(vec![Diagnostic::whole(file, message)]));
        }
        let read: RobotFile = toml::from_str(text).map_err(|error| {
            let position = source.position(error.span().map_or(0, |span| span.start));
            let message = error.message().trim().replace('\n', "; ");
            Diagnostics(vec![Diagnostic::at(file, position, message)])
        })?;
        let mut reader = Reader {
            source: &source,
            findings: Vec::new(),
        };
        let parts = reader.configuration(read);
        let findings = reader.findings;
        match parts {
            Some(parts) if findings.is_empty() => Ok(Self { source, ..parts }),
            _ => Err(Diagnostics::sorted(findings)),
        }
    }
}

struct Reader<'a> {
    source: &'a Source,
    findings: Vec<Diagnostic>,
}

impl Reader<'_> {
    fn report(&mut self, span: &Range<usize>, part: &str, message: impl Into<String>) {
        self.findings.push(self.source.finding(span, part, message));
    }

    fn configuration(&mut self, file: RobotFile) -> Option<Configuration> {
        let url = self.url(&file.url);
        let limits = self.limits(&file.timeouts);
        let parallel = match &file.parallel {
            Some(own) if !(1..=PARALLEL_LIMIT).contains(own.get_ref()) => {
                let message = format!("`parallel` is {}, not 1 to {PARALLEL_LIMIT}", own.get_ref());
                self.report(&own.span(), "", message);
                1
            }
            own => own.as_ref().map_or(1, |own| *own.get_ref()),
        };
        let interval = match &file.rate {
            Some(own) if !(*own.get_ref() > 0.0 && *own.get_ref() <= 1_000.0) => {
                self.report(
                    &own.span(),
                    "",
                    "`rate` is the number of orders a second, above 0 and at most 1000",
                );
                Duration::ZERO
            }
            own => Duration::from_secs_f64(1.0 / own.as_ref().map_or(1.0, |own| *own.get_ref())),
        };
        let heartbeat = file.heartbeat.map(|own| Heartbeat {
            topic: self.name(&own.topic, "topic"),
            period: self.seconds(own.period.as_ref(), 0.5),
        });
        let stop = file.stop.map(|own| self.service(&own));
        let tables = file.table.into_iter().map(|(name, rows)| {
            if Filter::NAMES.contains(&name.get_ref().as_str()) {
                let message = format!("`{}` is the name of a filter; name the table otherwise", name.get_ref());
                self.report(&name.span(), name.get_ref(), message);
            }
            (name.into_inner(), rows)
        });
        let tables: BTreeMap<String, Table> = tables.collect();
        if file.action.is_empty() {
            self.findings.push(
                Diagnostic::whole(&self.source.file, "there is no [[action]]")
                    .hint("docs/guide/ros2.md has an example"),
            );
        }
        let mut actions: Vec<ActionRule> = Vec::new();
        for entry in file.action {
            let rule = self.action(entry, &tables);
            if actions.iter().any(|own| own.name.get_ref() == rule.name.get_ref()) {
                let message = format!("the action `{}` has two entries", rule.name.get_ref());
                self.report(&rule.name.span(), rule.name.get_ref(), message);
            }
            actions.push(rule);
        }
        for allowed in &file.allow {
            let is_mapped =
                |rule: &ActionRule| [allowed.get_ref().as_str(), ANY].contains(&rule.name.get_ref().as_str());
            if !actions.iter().any(is_mapped) {
                let message = format!(
                    "`{}` is allowed, but no [[action]] says how it is performed",
                    allowed.get_ref()
                );
                self.report(&allowed.span(), allowed.get_ref(), message);
            }
        }
        let serving = Serving {
            namespace: match &file.serve.namespace {
                Some(namespace) => self.name(namespace, "namespace"),
                None => Serving::default().namespace,
            },
            approve: file.serve.approve,
            services: file.serve.services,
        };
        let observations = file.observation.into_iter();
        let observations: Vec<ObservationRule> = observations
            .filter_map(|entry| self.observation(entry, &tables))
            .collect();
        let configuration = Configuration {
            source: Source {
                file: String::new(),
                text: String::new(),
            },
            name: longstep_core::visible::line(file.name.get_ref()).into_owned(),
            url: url?,
            simulated: file.simulated,
            allow: file.allow,
            parallel,
            interval,
            reports: file.reports,
            limits,
            heartbeat,
            stop,
            tables,
            actions,
            observations,
            serving,
        };
        self.consistent(&configuration);
        Some(configuration)
    }

    /// Reports servers that are named with two types.
    fn consistent(&mut self, configuration: &Configuration) {
        for (index, rule) in configuration.actions.iter().enumerate() {
            let earlier = configuration.actions[..index].iter();
            for server in rule.servers() {
                let differs = |own: &&ActionRule| own.kind != rule.kind && own.servers().any(|own| own == server);
                if let Some(other) = earlier.clone().find(differs) {
                    let message = format!("the server `{server}` has the type `{}` above", other.kind);
                    self.report(&rule.name.span(), &rule.kind, message);
                }
            }
        }
    }

    fn url(&mut self, text: &Text) -> Option<Address> {
        let written = text.get_ref();
        let Some(rest) = written.strip_prefix("ws://") else {
            let message = format!("`{}` is no URL of a bridge", secret::address(written));
            let mut finding = self.source.finding(&text.span(), written, message);
            finding = finding.hint(if written.starts_with("wss://") {
                "encrypted connections are not supported; use `ws://` through a tunnel such as `ssh -L`"
            } else {
                "for example `ws://127.0.0.1:9090`"
            });
            self.findings.push(finding);
            return None;
        };
        let (authority, path) = rest.split_once('/').unwrap_or((rest, ""));
        let (host, port) = match authority.rsplit_once(':') {
            Some((host, port)) if !port.contains(']') => (host, port.parse().ok()),
            _ => (authority, Some(PORT)),
        };
        let is_plain = |letter: char| letter.is_ascii_graphic() && !matches!(letter, '@' | '?' | '#');
        match port {
            Some(port) if !host.is_empty() && rest.chars().all(is_plain) => Some(Address {
                host: host.trim_matches(['[', ']']).to_owned(),
                port,
                written: format!("ws://{host}:{port}/{path}"),
            }),
            _ => {
                let message = if rest.contains('@') {
                    "has a user or a password, which bridges do not know"
                } else {
                    "has no host, or a wrong port"
                };
                let message = format!("`{}` {message}", secret::address(written));
                let finding = self.source.finding(&text.span(), written, message);
                self.findings.push(finding.hint("for example `ws://127.0.0.1:9090`"));
                None
            }
        }
    }

    fn limits(&mut self, entry: &TimeoutEntry) -> Limits {
        Limits {
            connect: self.seconds(entry.connect.as_ref(), 5.0),
            accept: self.seconds(entry.accept.as_ref(), 5.0),
            perform: self.seconds(entry.perform.as_ref(), 60.0),
            observe: self.seconds(entry.observe.as_ref(), 10.0),
            stop: self.seconds(entry.stop.as_ref(), 2.0),
            silence: self.seconds(entry.silence.as_ref(), 5.0),
        }
    }

    fn seconds(&mut self, given: Option<&Spanned<f64>>, default: f64) -> Duration {
        match given {
            Some(own) if !(*own.get_ref() > 0.0 && *own.get_ref() <= TIMEOUT_LIMIT) => {
                self.report(
                    &own.span(),
                    "",
                    "a time is in seconds, above 0 and at most 86400 (a day)",
                );
                Duration::from_secs_f64(default)
            }
            own => Duration::from_secs_f64(own.map_or(default, |own| *own.get_ref())),
        }
    }

    /// Checks a name of the ROS graph: `/arm/grasp`.
    fn name(&mut self, text: &Text, kind: &str) -> String {
        self.check_name(&text.span(), text.get_ref(), kind);
        text.get_ref().clone()
    }

    fn check_name(&mut self, span: &Range<usize>, name: &str, kind: &str) {
        let is_part = |part: &str| {
            let mut letters = part.chars();
            letters
                .next()
                .is_some_and(|first| first.is_ascii_alphabetic() || first == '_')
                && letters.all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
        };
        if !name.strip_prefix('/').is_some_and(|rest| rest.split('/').all(is_part)) {
            let message = format!("`{name}` is no full name of a {kind}");
            let finding = self.source.finding(span, name, message);
            self.findings
                .push(finding.hint("full names begin with `/`, such as `/arm/grasp`"));
        }
    }

    /// Checks the name of an interface: `std_msgs/msg/String`.
    fn kind(&mut self, text: &Text, folder: &str) -> String {
        let name = text.get_ref();
        let parts: Vec<&str> = name.split('/').collect();
        let is_word =
            |word: &&str| !word.is_empty() && word.chars().all(|own| own.is_ascii_alphanumeric() || own == '_');
        if parts.len() != 3 || parts[1] != folder || !parts.iter().all(is_word) {
            let message = format!("`{name}` is no type `package/{folder}/Name`");
            self.report(&text.span(), name, message);
        }
        name.clone()
    }

    fn service(&mut self, entry: &ServiceEntry) -> Service {
        Service {
            name: self.name(&entry.service, "service"),
            kind: self.kind(&entry.kind, "srv"),
            request: Value::Object(entry.request.clone()),
        }
    }

    fn broken(&mut self, span: &Range<usize>, error: &TemplateError) {
        self.report(span, &error.part, format!("`{}` {}", error.part, error.reason));
    }

    /// Reads a template; the tables of its filters must exist.
    fn template(&mut self, span: &Range<usize>, value: &Value, tables: &BTreeMap<String, Table>) -> Template {
        let template = Template::read(value).unwrap_or_else(|error| {
            self.broken(span, &error);
            Template::Constant(json!(null))
        });
        for hole in template.holes() {
            for filter in &hole.filters {
                if let Filter::Table(name) = filter
                    && !tables.contains_key(name)
                {
                    let known = Filter::NAMES.into_iter().chain(tables.keys().map(String::as_str));
                    let mut finding = self.source.unknown(span, "filter or table", name, known);
                    finding.position = Some(self.source.position_of(span, &hole.written));
                    self.findings.push(finding);
                }
            }
        }
        template
    }

    fn criterion(&mut self, fields: Option<&Spanned<Map<String, Value>>>) -> Criterion {
        let Some(fields) = fields else {
            return Criterion::default();
        };
        Criterion::read(fields.get_ref()).unwrap_or_else(|(path, reason)| {
            self.report(&fields.span(), &path, format!("`{path}`: {reason}"));
            Criterion::default()
        })
    }

    fn action(&mut self, entry: ActionEntry, tables: &BTreeMap<String, Table>) -> ActionRule {
        let goal_span = entry.goal.span();
        let outcomes = entry.outcomes.into_iter().map(|own| OutcomeRule {
            fact: self.template(&own.is.span(), &json!(own.is.get_ref()), tables),
            span: own.is.span(),
            when: self.criterion(Some(&own.when)),
        });
        let outcomes: Vec<OutcomeRule> = outcomes.collect();
        if let Some(outcome) = entry.outcome.as_ref().filter(|_| !outcomes.is_empty()) {
            self.report(&outcome.span(), "", "an action has `outcome` or `outcomes`, not both");
        }
        let server_span = entry.server.span();
        let names: Vec<&String> = match entry.server.get_ref() {
            Servers::One(server) => vec![server],
            Servers::ByLane(servers) => servers.values().collect(),
        };
        for name in names {
            self.check_name(&server_span, name, "server");
        }
        ActionRule {
            servers: entry.server.into_inner(),
            server_span,
            kind: self.kind(&entry.kind, "action"),
            goal: self.template(&goal_span, &Value::Object(entry.goal.into_inner()), tables),
            goal_span,
            timeout: entry.timeout.as_ref().map(|own| self.seconds(Some(own), 0.0)),
            done: self.criterion(entry.done.as_ref()),
            reason: entry.reason.map(Spanned::into_inner),
            outcome: entry.outcome.map(Spanned::into_inner),
            outcomes,
            fraction: entry.feedback.fraction.map(Spanned::into_inner),
            text: entry.feedback.text.map(Spanned::into_inner),
            aborted: entry.aborted,
            cancelled: entry.cancelled,
            rejected: entry.rejected,
            name: entry.name,
        }
    }

    fn observation(&mut self, entry: ObservationEntry, tables: &BTreeMap<String, Table>) -> Option<ObservationRule> {
        let span = entry.kind.span();
        let (origin, folder) = match (&entry.topic, &entry.service) {
            (Some(topic), None) => {
                if let Some(request) = &entry.request {
                    self.report(&request.span(), "", "a topic has no `request`");
                }
                let (name, latched) = (self.name(topic, "topic"), entry.latched);
                (Origin::Topic { name, latched }, "msg")
            }
            (None, Some(service)) => {
                let request = entry.request.map_or_else(Map::new, Spanned::into_inner);
                let (name, request) = (self.name(service, "service"), Value::Object(request));
                (Origin::Service { name, request }, "srv")
            }
            _ => {
                self.report(&span, "", "an observation has either a `topic` or a `service`");
                return None;
            }
        };
        let kind = self.kind(&entry.kind, folder);
        let entity = entry
            .entity
            .map(|own| self.template(&own.span(), &json!(own.get_ref()), tables));
        let say: Vec<SayRule> = entry.say.into_iter().filter_map(|own| self.say(own, tables)).collect();
        let describes = entry.states.is_some() || say.iter().any(|own| !own.is_fact);
        if describes && entity.is_none() {
            self.report(
                &span,
                "",
                "`entity` is missing: the identifier that the statements are about",
            );
        }
        if !describes && entity.is_none() && entry.facts.is_none() && say.is_empty() {
            self.report(&span, "", "an observation has `states`, `say` or `facts`");
        }
        Some(ObservationRule {
            origin,
            kind,
            json: entry.json.map(Spanned::into_inner),
            each: entry.each.map(Spanned::into_inner),
            entity,
            states: entry.states.map(Spanned::into_inner),
            say,
            facts: entry.facts.map(Spanned::into_inner),
        })
    }

    fn say(&mut self, entry: SayEntry, tables: &BTreeMap<String, Table>) -> Option<SayRule> {
        let when = self.criterion(entry.when.as_ref());
        let (text, is_fact) = match (&entry.state, &entry.fact) {
            (Some(state), None) => (state, false),
            (None, Some(fact)) => (fact, true),
            (first, _) => {
                let span = first
                    .as_ref()
                    .map(Spanned::span)
                    .or(entry.when.as_ref().map(Spanned::span));
                self.report(&span.unwrap_or_default(), "", "`say` has either `state` or `fact`");
                return None;
            }
        };
        Some(SayRule {
            text: self.template(&text.span(), &json!(text.get_ref()), tables),
            span: text.span(),
            is_fact,
            when,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"name = "arm"
url = "ws://127.0.0.1:9090"
allow = ["grasp"]
[[action]]
name = "grasp"
server = "/grasp"
type = "arm_msgs/action/Grasp"
goal = { target = "{item|bare}" }
[[observation]]
topic = "/seen"
type = "std_msgs/msg/String"
json = "data"
entity = "{name}"
states = "words"
"#;

    #[track_caller]
    fn check(from: &str, to: &str, expected: &str) {
        let text = GOOD.replace(from, to);
        let found = Configuration::parse("robot.toml", &text)
            .err()
            .map(|own| own.to_string());
        assert_eq!(found.unwrap_or_default(), expected);
    }

    #[test]
    fn ros2_configuration_reads_a_valid_file() {
        let read = Configuration::parse("robot.toml", GOOD).unwrap();
        assert_eq!(
            (read.interval, read.limits.accept),
            (Duration::from_secs(1), Duration::from_secs(5))
        );
        assert!(read.rule("grasp").is_some() && read.rule("release").is_none());
        assert_eq!(read.address().to_string(), "ws://127.0.0.1:9090/");
        assert_eq!(*read.serving(), Serving::default());
        let served = GOOD.replace(
            "[[action]]",
            "[serve]\nnamespace = \"/kitchen\"\napprove = true\n[[action]]",
        );
        let read = Configuration::parse("robot.toml", &served).unwrap();
        assert_eq!(
            (read.serving().namespace.as_str(), read.serving().approve),
            ("/kitchen", true)
        );
    }

    #[test]
    fn ros2_configuration_errors_name_their_position() {
        check("", "", "");
        check(
            "ws://127.0.0.1:9090",
            "http://robot",
            "robot.toml:2:8: `http://robot` is no URL of a bridge\n  hint: for example `ws://127.0.0.1:9090`",
        );
        check(
            "ws://",
            "wss://",
            "robot.toml:2:8: `wss://127.0.0.1:9090` is no URL of a bridge\n  hint: encrypted connections are not \
             supported; use `ws://` through a tunnel such as `ssh -L`",
        );
        check(
            "allow = [\"grasp\"]",
            "allow = [\"grasp\", \"release\"]",
            "robot.toml:3:20: `release` is allowed, but no [[action]] says how it is performed",
        );
        check(
            "\"/grasp\"",
            "\"grasp\"",
            "robot.toml:6:11: `grasp` is no full name of a server\n  hint: full names begin with `/`, such as `/arm/grasp`",
        );
        check(
            "arm_msgs/action/Grasp",
            "arm_msgs/Grasp",
            "robot.toml:7:9: `arm_msgs/Grasp` is no type `package/action/Name`",
        );
        check(
            "{item|bare}",
            "{item|bare",
            "robot.toml:8:20: `{item|bare` is not closed",
        );
        check(
            "{item|bare}",
            "{item|bar}",
            "robot.toml:8:21: unknown filter or table `bar`\n  hint: did you mean `bare`?",
        );
        check(
            "topic =",
            "topics =",
            "robot.toml:10:1: unknown field `topics`, expected one of `topic`, `service`, `type`, `request`, `latched`, `json`, `each`, `entity`, `states`, `say`, `facts`",
        );
        check(
            "topic = \"/seen\"\n",
            "",
            "robot.toml:10:8: an observation has either a `topic` or a `service`",
        );
        check(
            "entity = \"{name}\"\n",
            "",
            "robot.toml:11:8: `entity` is missing: the identifier that the statements are about",
        );
        check(
            "[[action]]",
            "[serve]\nnamespace = \"kitchen\"\n[[action]]",
            "robot.toml:5:14: `kitchen` is no full name of a namespace\n  hint: full names begin with `/`, such as `/arm/grasp`",
        );
        check(
            "allow",
            "rate = 0\nallow",
            "robot.toml:3:8: `rate` is the number of orders a second, above 0 and at most 1000",
        );
    }
}
