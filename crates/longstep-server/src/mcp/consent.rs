//! The decision of a person, by a form that the client shows.
//!
//! Only a form that comes back with `approve` set and with the hash that it showed is a yes. Clients that cannot show a
//! form decline by themselves, or accept with an empty form; neither is a decision of a person.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use rmcp::model::{
    ElicitRequest, ElicitRequestParams, ElicitResult, ElicitationAction, ElicitationSchema, InputRequest,
    InputRequests, InputRequiredResult, InputResponses, RequestStateCodec, RequestStateError, SealOptions,
};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::caller::Caller;
use crate::id;
use crate::problem::{Problem, ProblemKind};

/// The time in which nobody reads a form: a refusal that comes earlier is the client's own.
const FASTEST_PERSON: Duration = Duration::from_secs(1);

/// The name of the form among the inputs that a call asks for.
const FORM: &str = "approval";

/// The number of random bytes of the key and of the number of a state.
const KEY_LENGTH: usize = 32;
const NUMBER_LENGTH: usize = 12;

/// A form for a person.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Form {
    /// The text, with all that is decided on.
    pub(super) message: String,
    /// The title of the field for a yes.
    pub(super) yes: &'static str,
    /// The hash of it, which the form has to come back with.
    pub(super) hash: String,
    /// All that the decision is bound to. A decision counts only while it is the same.
    pub(super) binding: Vec<String>,
}

/// The decision on a form.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Decision {
    /// A person approves.
    Approved,
    /// A person says no.
    Declined(&'static str),
    /// The form came back without a decision.
    Void(&'static str),
    /// No person has seen the form.
    NobodyAsked(&'static str),
}

/// The course of a question.
#[derive(Debug)]
pub(super) enum Asked {
    /// It was decided.
    Decided(Decision),
    /// The client is to show the form and to call again.
    Later(Box<InputRequiredResult>),
}

/// The answer that a repeated call brings along.
#[derive(Debug, Clone, Default)]
pub(super) struct Input {
    /// The state that the server gave, as the client sends it back. It proves nothing until it was opened.
    pub(super) state: Option<String>,
    /// The answers.
    pub(super) responses: Option<InputResponses>,
}

/// The content of a state. It is signed, not secret.
#[derive(Debug, Serialize, Deserialize)]
struct Sealed {
    /// A random number, so that a state counts once.
    number: String,
    binding: Vec<String>,
    /// Milliseconds since 1970.
    asked_at: u64,
}

/// Asks people by the forms of clients.
pub(super) struct Consent {
    codec: RequestStateCodec,
    lifetime: Duration,
    /// The numbers of the states that were answered, until they expire.
    answered: Mutex<HashMap<String, Instant>>,
}

impl Consent {
    pub(super) fn new(lifetime: Duration) -> Result<Self, Problem> {
        let key = id::random(KEY_LENGTH)?;
        Ok(Self {
            codec: RequestStateCodec::try_new(key.into_bytes()).map_err(|error| internal(&error))?,
            lifetime,
            answered: Mutex::default(),
        })
    }

    /// Asks a person, or takes the answer that the call brings along.
    ///
    /// # Errors
    ///
    /// The answer belongs to no question of this server, to an answered one, or to something that has changed since.
    pub(super) async fn ask(&self, caller: &Caller, form: &Form, input: &Input) -> Result<Asked, Problem> {
        if let Some(state) = &input.state {
            let elapsed = self.open(caller, form, state)?;
            let answer = answer_in(input.responses.as_ref())?;
            return Ok(Asked::Decided(decision(&answer, elapsed, &form.hash)));
        }
        if input.responses.is_some() {
            return Err(Problem::unreadable("the answer has no requestState")
                .hint("call the tool again without an answer, so that the person is asked"));
        }
        if !caller.shows_forms {
            return Ok(Asked::Decided(Decision::NobodyAsked(
                "this client cannot show forms to a person",
            )));
        }
        if caller.is_asked_directly {
            return Ok(Asked::Decided(self.ask_directly(caller, form).await));
        }
        Ok(Asked::Later(Box::new(self.ask_later(caller, form)?)))
    }

    /// Sends the form to the client and waits.
    async fn ask_directly(&self, caller: &Caller, form: &Form) -> Decision {
        let asked_at = Instant::now();
        let asked = caller
            .peer
            .create_elicitation_with_timeout(parameters(form), Some(self.lifetime));
        tokio::select! {
            answer = asked => match answer {
                Ok(answer) => decision(&answer, asked_at.elapsed(), &form.hash),
                Err(_) if asked_at.elapsed() >= self.lifetime => Decision::NobodyAsked("nobody answered the form in time"),
                Err(_) => Decision::NobodyAsked("the client could not show the form"),
            },
            () = caller.cancelled.cancelled() => Decision::Void("the call was cancelled"),
        }
    }

    /// Makes the question that the client answers with another call.
    fn ask_later(&self, caller: &Caller, form: &Form) -> Result<InputRequiredResult, Problem> {
        let sealed = Sealed {
            number: id::random(NUMBER_LENGTH)?,
            binding: form.binding.clone(),
            asked_at: milliseconds_now(),
        };
        let options = SealOptions::new()
            .associated_data(caller.by.as_bytes())
            .ttl(self.lifetime);
        let state = self.codec.seal_json_with(&sealed, &options);
        let state = state.map_err(|error| internal(&error))?;
        let form = InputRequest::Elicitation(ElicitRequest::new(parameters(form)));
        let requests = InputRequests::from([(FORM.to_owned(), form)]);
        Ok(InputRequiredResult::new(Some(requests), Some(state)))
    }

    /// Opens a state, once; returns the time since the question.
    fn open(&self, caller: &Caller, form: &Form, state: &str) -> Result<Duration, Problem> {
        let opened: Result<Sealed, _> = self.codec.open_json_with(state, caller.by.as_bytes());
        let sealed = opened.map_err(|error| match error {
            RequestStateError::Expired => Problem::conflict("the time to answer the form is over"),
            _ => Problem::new(ProblemKind::Forbidden, "the requestState is not one of this server"),
        });
        let again = "call the tool again without an answer, so that the person is asked again";
        let sealed = sealed.map_err(|problem| problem.hint(again))?;
        if !self.is_first_answer(&sealed.number) {
            return Err(Problem::conflict("this form was answered already").hint(again));
        }
        if sealed.binding != form.binding {
            return Err(changed());
        }
        let elapsed = milliseconds_now().saturating_sub(sealed.asked_at);
        Ok(Duration::from_millis(elapsed))
    }

    fn is_first_answer(&self, number: &str) -> bool {
        let mut answered = self.answered.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        answered.retain(|_, expires| now < *expires);
        // A state cannot be opened after its lifetime; one second covers the difference of the clocks.
        let expires = now + self.lifetime + Duration::from_secs(1);
        answered.insert(number.to_owned(), expires).is_none()
    }
}

/// Returns the refusal of a decision about something that has changed.
pub(super) fn changed() -> Problem {
    Problem::conflict("the plan, the robot or the world has changed since the person was asked")
        .hint("call `explain` to look at the plan again, then `execute_plan` with the new plan_id")
}

fn internal(error: &RequestStateError) -> Problem {
    Problem::new(ProblemKind::Internal, error.to_string())
}

fn milliseconds_now() -> u64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(now.as_millis()).unwrap_or(u64::MAX)
}

fn answer_in(responses: Option<&InputResponses>) -> Result<ElicitResult, Problem> {
    let answer = responses.and_then(|responses| responses.get(FORM)).cloned();
    let answer = answer.and_then(|answer| serde_json::from_value(answer).ok());
    answer.ok_or_else(|| {
        Problem::unreadable("the call has no answer to the form")
            .hint("call the tool again without an answer, so that the person is asked")
    })
}

fn parameters(form: &Form) -> ElicitRequestParams {
    ElicitRequestParams::FormElicitationParams {
        meta: None,
        message: form.message.clone(),
        requested_schema: schema(form.yes, &form.hash),
    }
}

/// Returns the schema of the form: two plain fields, as clients support them.
fn schema(yes: &str, hash: &str) -> ElicitationSchema {
    let schema = json!({
        "type": "object",
        "properties": {
            "approve": {
                "type": "boolean",
                "title": yes,
                "description": "Set this only if you have read the text above and agree.",
                "default": false,
            },
            "plan": {
                "type": "string",
                "title": "Hash",
                "description": "The hash of what you have read above.",
                "default": hash,
            },
        },
        "required": ["approve", "plan"],
    });
    serde_json::from_value(schema).unwrap_or_else(|_| ElicitationSchema::new(Default::default()))
}

/// Decides by the answer, the time since the question, and the hash in the form.
fn decision(answer: &ElicitResult, elapsed: Duration, hash: &str) -> Decision {
    let content = answer.content.as_ref();
    let field = |name: &str| content.and_then(|content| content.get(name));
    match (&answer.action, field("approve"), field("plan")) {
        (ElicitationAction::Accept, Some(Value::Bool(true)), Some(Value::String(plan))) if plan == hash => {
            Decision::Approved
        }
        (ElicitationAction::Accept, Some(Value::Bool(true)), _) => {
            Decision::Void("the form came back with another hash")
        }
        (ElicitationAction::Accept, Some(Value::Bool(false)), _) => Decision::Declined("the person did not approve"),
        (ElicitationAction::Accept, ..) => Decision::Void("the form came back empty, so no person has decided"),
        _ if elapsed < FASTEST_PERSON => {
            Decision::NobodyAsked("the client refused at once, before a person could read the form")
        }
        (ElicitationAction::Decline, ..) => Decision::Declined("the person declined"),
        _ => Decision::Void("the form was closed without a decision"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_form_with_approve_and_its_hash_is_a_yes() {
        let (fast, slow) = (Duration::from_millis(200), Duration::from_secs(3));
        let empty = Decision::Void("the form came back empty, so no person has decided");
        let other = Decision::Void("the form came back with another hash");
        let nobody = Decision::NobodyAsked("the client refused at once, before a person could read the form");
        let accept = |content: Value| json!({"action": "accept", "content": content});
        for (answer, elapsed, expected) in [
            (accept(json!({"approve": true, "plan": "h"})), slow, &Decision::Approved),
            (accept(json!({"approve": true, "plan": "h"})), fast, &Decision::Approved),
            (accept(json!({"approve": true, "plan": "g"})), slow, &other),
            (accept(json!({"approve": true, "plan": ["h"]})), slow, &other),
            (accept(json!({"approve": true})), slow, &other),
            (accept(json!({"approve": "true", "plan": "h"})), slow, &empty),
            (accept(json!({"approve": 1, "plan": "h"})), slow, &empty),
            (accept(json!({"plan": "h"})), slow, &empty),
            (accept(json!({})), slow, &empty),
            (accept(json!(true)), fast, &empty),
            (json!({"action": "accept"}), fast, &empty),
            (
                accept(json!({"approve": false, "plan": "h"})),
                slow,
                &Decision::Declined("the person did not approve"),
            ),
            (
                json!({"action": "decline"}),
                slow,
                &Decision::Declined("the person declined"),
            ),
            (
                json!({"action": "decline", "content": {"approve": true, "plan": "h"}}),
                slow,
                &Decision::Declined("the person declined"),
            ),
            (
                json!({"action": "cancel"}),
                slow,
                &Decision::Void("the form was closed without a decision"),
            ),
            (json!({"action": "decline"}), fast, &nobody),
            (json!({"action": "cancel"}), fast, &nobody),
        ] {
            let read: ElicitResult = serde_json::from_value(answer.clone()).unwrap();
            assert_eq!(&decision(&read, elapsed, "h"), expected, "{answer} after {elapsed:?}");
        }
    }

    #[test]
    fn form_has_two_plain_fields_and_defaults_to_no() {
        let schema = serde_json::to_value(schema("Approve", "abc")).unwrap();
        assert_eq!(schema["properties"]["approve"]["default"], json!(false));
        assert_eq!(schema["properties"]["plan"]["default"], json!("abc"));
        assert_eq!(schema["required"], json!(["approve", "plan"]));
        assert_eq!(schema["properties"].as_object().unwrap().len(), 2);
    }
}
