//! A configuration for a domain: from orders to goals, from results to the ends of steps.

use std::collections::BTreeMap;

use longstep_core::model::Domain;
use serde_json::{Value, json};

use super::configuration::{ActionRule, Configuration};
use super::file::Consequence;
use super::template::{Filter, Hole, HoleValues, Table, at};
use crate::error::RobotError;
use crate::order::Order;
use crate::robot::{Feedback, Progress};
use crate::rosbridge::message::{Goal, GoalStatus, quotation};

/// The holes that every action has, besides its parameters and `skill.NAME`.
pub(super) const ORDER_HOLES: [&str; 6] = ["step", "lane", "action", "arguments", "outcomes", "skills"];

/// The prefix of holes for skill parameters.
pub(super) const SKILL: &str = "skill.";

/// The largest data of a feedback that is passed on, in bytes.
const DATA_LIMIT: usize = 16 << 10;

/// A configuration that fits a domain.
#[derive(Debug, Clone)]
pub(super) struct Mapping {
    pub(super) configuration: Configuration,
    /// The names of the parameters, by action of the domain.
    parameters: BTreeMap<String, Vec<String>>,
}

/// The end of a goal.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct GoalEnd {
    /// None if the bridge did not say.
    pub(super) status: Option<GoalStatus>,
    /// The result of the server, or the reason why there is none.
    pub(super) values: Value,
}

impl Mapping {
    /// Binds a configuration, which was checked against the domain.
    pub(super) fn new(configuration: Configuration, domain: &Domain) -> Self {
        let names = |parameters: &[longstep_core::model::Parameter]| {
            parameters.iter().map(|parameter| parameter.name.clone()).collect()
        };
        let parameters = domain.actions.iter();
        let parameters = parameters.map(|action| (action.name.clone(), names(&action.parameters)));
        Self {
            configuration,
            parameters: parameters.collect(),
        }
    }

    fn rule(&self, action: &str) -> Result<&ActionRule, RobotError> {
        self.configuration.rule(action).ok_or_else(|| RobotError::Unsupported {
            action: action.to_owned(),
        })
    }

    fn scope<'a>(&'a self, order: &'a Order) -> OrderScope<'a> {
        OrderScope {
            order,
            parameters: self.parameters.get(&order.action).map_or(&[], Vec::as_slice),
            tables: &self.configuration.tables,
        }
    }

    /// Returns the goal for an order.
    ///
    /// # Errors
    ///
    /// An action that the robot may not perform, and a hole without a value.
    pub(super) fn goal(&self, order: &Order) -> Result<Goal, RobotError> {
        let rule = self.rule(&order.action)?;
        let fields = rule
            .goal
            .fill(&self.scope(order))
            .map_err(|reason| RobotError::InvalidOrder {
                step: order.step,
                reason,
            })?;
        let server = rule
            .server_of(order.lane.as_deref())
            .ok_or_else(|| RobotError::InvalidOrder {
                step: order.step,
                reason: match &order.lane {
                    Some(lane) => format!("`server` of `{}` has no lane `{lane}`", rule.name.get_ref()),
                    None => format!(
                        "`server` of `{}` is by lane, and the step has none",
                        rule.name.get_ref()
                    ),
                },
            })?;
        Ok(Goal {
            server: server.to_owned(),
            kind: rule.kind.clone(),
            fields,
        })
    }

    /// Returns the feedback of a server.
    pub(super) fn feedback(&self, order: &Order, values: Value) -> Feedback {
        let rule = self.configuration.rule(&order.action);
        let field = |path: Option<&String>| path.and_then(|path| at(&values, path));
        let fraction = field(rule.and_then(|rule| rule.fraction.as_ref())).and_then(Value::as_f64);
        let text = field(rule.and_then(|rule| rule.text.as_ref())).and_then(Value::as_str);
        Feedback {
            fraction: fraction.filter(|own| own.is_finite()).map(|own| own.clamp(0.0, 1.0)),
            text: text.filter(|own| !own.is_empty()).map(quotation),
            data: (values.to_string().len() <= DATA_LIMIT).then_some(values),
        }
    }

    /// Returns the end of the step whose goal has ended.
    ///
    /// # Errors
    ///
    /// A result that stops the robot.
    pub(super) fn end(&self, order: &Order, end: &GoalEnd) -> Result<Progress, RobotError> {
        let rule = self.rule(&order.action)?;
        let step = order.step;
        if let Value::String(reason) = &end.values {
            let reason = quotation(reason);
            // The other texts are mistakes of the bridge, which say nothing about the world.
            return match rule.rejected {
                Consequence::Failed if is_rejection(&reason) => Ok(Progress::Failed {
                    reason: format!("the goal was rejected: {reason}"),
                }),
                _ => Err(RobotError::Rejected { step, reason }),
            };
        }
        let reason = || reason_of(rule, &end.values);
        let (consequence, how) = match end.status {
            Some(GoalStatus::Succeeded) => {
                return if rule.done.holds(&end.values) {
                    self.done(rule, order, &end.values)
                } else {
                    Ok(Progress::Failed { reason: reason() })
                };
            }
            Some(GoalStatus::Aborted) => (rule.aborted, "aborted"),
            Some(GoalStatus::Cancelled) => (rule.cancelled, "cancelled"),
            other => {
                let how = other.map_or("no status".to_owned(), |own| format!("the status {own:?}"));
                let reason = format!("the result of step {step} has {how}");
                return Err(RobotError::Protocol { reason });
            }
        };
        match consequence {
            Consequence::Failed => Ok(Progress::Failed {
                reason: match (end.status, reason()) {
                    (Some(GoalStatus::Cancelled), reason) => format!("it was cancelled: {reason}"),
                    (_, reason) => reason,
                },
            }),
            Consequence::Stop => Err(RobotError::GoalEnded {
                step,
                how,
                reason: reason(),
            }),
        }
    }

    fn done(&self, rule: &ActionRule, order: &Order, values: &Value) -> Result<Progress, RobotError> {
        if order.outcomes.is_empty() {
            return Ok(Progress::Done { outcome: None });
        }
        let unfit = |what: String| RobotError::Protocol {
            reason: format!("its result of step {} does not fit ({what})", order.step),
        };
        let outcome = match &rule.outcome {
            Some(path) => at(values, path).and_then(Value::as_str).map(str::to_owned),
            None => {
                let fitting = rule.outcomes.iter().find(|own| own.when.holds(values));
                let filled = fitting.map(|own| own.fact.fill_text(&self.scope(order)));
                filled.transpose().map_err(&unfit)?
            }
        };
        let outcome = outcome.ok_or_else(|| unfit("a sensing action needs an outcome".to_owned()))?;
        match order.outcomes.iter().position(|own| *own == outcome) {
            Some(place) => Ok(Progress::Done { outcome: Some(place) }),
            None => Err(unfit(format!("`{}` is no outcome of the step", quotation(&outcome)))),
        }
    }
}

/// The reason that a result gives, or the result itself.
fn reason_of(rule: &ActionRule, values: &Value) -> String {
    let text = rule.reason.as_ref().and_then(|path| at(values, path));
    match text {
        Some(Value::String(text)) if !text.is_empty() => quotation(text),
        Some(Value::String(_)) | None => quotation(&format!("the result is {values}")),
        Some(other) => quotation(&other.to_string()),
    }
}

/// The holes of an order.
struct OrderScope<'a> {
    order: &'a Order,
    parameters: &'a [String],
    tables: &'a BTreeMap<String, Table>,
}

impl HoleValues for OrderScope<'_> {
    fn value<'h>(&self, hole: &'h Hole) -> Result<(Value, &'h [Filter]), String> {
        let order = self.order;
        if let Some(place) = self.parameters.iter().position(|own| *own == hole.name) {
            return self.argument(place, hole);
        }
        let value = match hole.name.as_str() {
            "step" => json!(order.step),
            "lane" => json!(order.lane.clone().unwrap_or_default()),
            "action" => json!(order.action),
            "arguments" => json!(order.arguments),
            "outcomes" => json!(order.outcomes),
            "skills" => json!(order.skills),
            name => {
                let skill = name.strip_prefix(SKILL).and_then(|name| order.skills.get(name));
                skill
                    .cloned()
                    .ok_or_else(|| format!("the step has no `{name}`; pass it in the skills file"))?
            }
        };
        Ok((value, &hole.filters))
    }

    fn table(&self, name: &str) -> Option<&Table> {
        self.tables.get(name)
    }
}

impl OrderScope<'_> {
    fn argument<'h>(&self, place: usize, hole: &'h Hole) -> Result<(Value, &'h [Filter]), String> {
        let written = self.order.arguments.get(place);
        let written = written.ok_or_else(|| format!("the step has no argument for `{}`", hole.name))?;
        let value = self.order.values.iter().find(|own| own.argument == place);
        let of_value = match (hole.filters.first(), value) {
            (Some(Filter::Number), value) => value.and_then(|own| own.number).map(|own| json!(own)),
            (Some(Filter::Unit), Some(value)) => Some(json!(value.unit.clone().unwrap_or_default())),
            (Some(Filter::Text), value) => value.and_then(|own| own.text.clone()).map(|own| json!(own)),
            (Some(Filter::Unit), None) => None,
            _ => return Ok((json!(written), &hole.filters)),
        };
        let of_value = of_value.ok_or_else(|| format!("`{written}` has no value for `{}`", hole.written))?;
        Ok((of_value, &hole.filters[1..]))
    }
}

/// Returns true if the text in place of a result says that the server refused the goal.
fn is_rejection(reason: &str) -> bool {
    reason.to_ascii_lowercase().contains("reject")
}

#[cfg(test)]
mod tests {

    use longstep_core::testing;

    use super::*;
    use crate::order::ArgumentValue;

    const ROBOT: &str = r#"name = "arm"
url = "ws://127.0.0.1:9090"
allow = ["grasp", "release", "wipe"]
[table.pose]
"<cup>" = { x = 1.0 }
[[action]]
name = "grasp"
server = "/grasp"
type = "arm_msgs/action/Grasp"
goal = { target = "{item|pose}", speed = "{skill.speed}", limit = 20, lane = "{lane}" }
done = { code = 0 }
reason = "message"
cancelled = "failed"
rejected = "failed"
[[action]]
name = "*"
server = "/execute_step"
type = "longstep_msgs/action/ExecuteStep"
goal = { step = "{step}", action = "{action}", arguments = "{arguments}", skills = "{skills|json}" }
feedback = { fraction = "progress", text = "text" }
outcomes = [{ is = "(fresh {item})", when = { age = { below = 3 } } }, { is = "(expired {item})", when = {} }]
aborted = "stop"
"#;

    fn mapping() -> Mapping {
        let household = testing::domain("household");
        Mapping::new(Configuration::parse("robot.toml", ROBOT).unwrap(), &household)
    }

    #[test]
    fn orders_become_goals() {
        let mut grasp = Order::new(4, "grasp", ["<cup>"]);
        grasp.skills.insert("speed".to_owned(), json!(0.5));
        let goal = mapping().goal(&grasp).unwrap();
        assert_eq!(
            goal.fields,
            json!({"target": {"x": 1.0}, "speed": 0.5, "limit": 20, "lane": ""})
        );
        let wipe = mapping().goal(&Order::new(5, "wipe", ["<sponge>", "<desk>"])).unwrap();
        assert_eq!(
            (wipe.server.as_str(), wipe.kind.as_str()),
            ("/execute_step", "longstep_msgs/action/ExecuteStep")
        );
        let expected = json!({"step": 5, "action": "wipe", "arguments": ["<sponge>", "<desk>"], "skills": "{}"});
        assert_eq!(wipe.fields, expected);
        let mut pen = Order::new(1, "grasp", ["<pen>"]);
        pen.skills = grasp.skills;
        for (order, expected) in [
            (
                Order::new(1, "detach", ["<cup>", "<desk>"]),
                "the robot cannot perform `detach`",
            ),
            (
                Order::new(1, "grasp", ["<cup>"]),
                "step 1 cannot be sent: the step has no `skill.speed`; pass it in the skills file",
            ),
            (pen, "step 1 cannot be sent: the table `pose` has no `<pen>`"),
        ] {
            assert_eq!(mapping().goal(&order).unwrap_err().to_string(), expected);
        }
    }

    #[test]
    fn values_are_written_as_numbers_and_texts() {
        let text = ROBOT.replace("{arguments}", "{tool|number} {tool|unit}: {place|text}");
        let household = testing::domain("household");
        let mapping = Mapping::new(Configuration::parse("robot.toml", &text).unwrap(), &household);
        let mut order = Order::new(1, "wipe", ["180 s", "\"hello\""]);
        assert!(
            mapping
                .goal(&order)
                .unwrap_err()
                .to_string()
                .ends_with("`180 s` has no value for `tool|number`")
        );
        let value = |argument, number, unit: Option<&str>, text: Option<&str>| ArgumentValue {
            argument,
            number,
            unit: unit.map(str::to_owned),
            text: text.map(str::to_owned),
        };
        order.values = vec![
            value(0, Some(180.0), Some("s"), None),
            value(1, None, None, Some("hello")),
        ];
        assert_eq!(mapping.goal(&order).unwrap().fields["arguments"], "180.0 s: hello");
    }

    #[test]
    fn results_end_steps() {
        let mapping = mapping();
        let outcomes = vec!["(expired <milk>)".to_owned(), "(fresh <milk>)".to_owned()];
        let sensing = Order {
            outcomes,
            ..Order::new(2, "release", ["<milk>"])
        };
        let (grasp, release) = (Order::new(1, "grasp", ["<cup>"]), Order::new(2, "release", ["<cup>"]));
        let failed = |reason: &str| {
            Ok(Progress::Failed {
                reason: reason.to_owned(),
            })
        };
        let done = |outcome| Ok(Progress::Done { outcome });
        let stopped = |text: &str| Err(text.to_owned());
        use GoalStatus::{Aborted, Cancelled, Succeeded};
        for (order, status, values, expected) in [
            (&grasp, Some(Succeeded), json!({"code": 0}), done(None)),
            (
                &grasp,
                Some(Succeeded),
                json!({"code": 2, "message": "out of reach"}),
                failed("out of reach"),
            ),
            (&grasp, Some(Succeeded), json!({}), failed("the result is {}")),
            (
                &grasp,
                Some(Aborted),
                json!({"message": "slipped\n"}),
                failed("slipped\\n"),
            ),
            (
                &grasp,
                Some(Cancelled),
                json!({"message": "button"}),
                failed("it was cancelled: button"),
            ),
            (
                &grasp,
                Some(Aborted),
                json!("goal rejected"),
                failed("the goal was rejected: goal rejected"),
            ),
            (
                &grasp,
                Some(GoalStatus::Unknown),
                json!("No action server available"),
                stopped("the robot rejected step 1: No action server available"),
            ),
            (
                &grasp,
                None,
                json!({"code": 0}),
                stopped("the robot broke the protocol: the result of step 1 has no status"),
            ),
            (
                &release,
                Some(Aborted),
                json!("goal rejected"),
                stopped("the robot rejected step 2: goal rejected"),
            ),
            (
                &release,
                Some(Aborted),
                json!({"a": 1}),
                stopped("step 2 was aborted by the robot: the result is {\"a\":1}"),
            ),
            (
                &release,
                Some(Cancelled),
                json!({}),
                stopped("step 2 was cancelled by the robot: the result is {}"),
            ),
            (&release, Some(Succeeded), json!({}), done(None)),
            (&sensing, Some(Succeeded), json!({"age": 2}), done(Some(1))),
            (&sensing, Some(Succeeded), json!({"age": 9}), done(Some(0))),
        ] {
            let end = GoalEnd { status, values };
            let ended = mapping.end(order, &end).map_err(|error| error.to_string());
            assert_eq!(ended, expected, "{end:?}");
        }
    }

    #[test]
    fn feedback_is_read() {
        let feedback = mapping().feedback(
            &Order::new(1, "release", ["<cup>"]),
            json!({"progress": 1.25, "text": "near"}),
        );
        assert_eq!((feedback.fraction, feedback.text.as_deref()), (Some(1.0), Some("near")));
        let other = mapping().feedback(&Order::new(1, "grasp", ["<cup>"]), json!({"progress": 1.25}));
        assert_eq!((other.fraction, other.data), (None, Some(json!({"progress": 1.25}))));
    }
}
