//! A Python callable as a language model.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use longstep::dialogue::{
    ChatRequest, Constraint, ConstraintKind, Counting, EstimatedTokens, Message, Reply, Role, TokenCounter, Usage,
};
use longstep_llm::{ChatModel, ModelError, Watch};
use pyo3::exceptions::{PyRuntimeError, PyTypeError};
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::PyString;
use serde_json::{Value, json};

use crate::argument::class_of;
use crate::interpreter::attach;
use crate::json::object;

/// A callable, with its place among the objects that Python's collector of reference cycles knows.
#[derive(Clone)]
pub(crate) struct Callable(Arc<Mutex<Option<Py<PyAny>>>>);

impl Callable {
    /// Takes a callable.
    pub(crate) fn new(object: &Bound<'_, PyAny>, what: &str) -> PyResult<Self> {
        if !object.is_callable() {
            let class = class_of(object);
            return Err(PyTypeError::new_err(format!("{what} must be callable, not {class}")));
        }
        Ok(Self(Arc::new(Mutex::new(Some(object.clone().unbind())))))
    }

    /// Shows the callable to the collector.
    pub(crate) fn traverse(&self, visit: &PyVisit<'_>) -> Result<(), PyTraverseError> {
        match self.0.try_lock() {
            Ok(callable) => visit.call(callable.as_ref()),
            // It is being taken out, so it is in use.
            Err(_) => Ok(()),
        }
    }

    /// Drops the callable, which is part of a cycle that nothing else refers to.
    pub(crate) fn clear(&self) {
        // Dropped after the lock, because that can run code in Python.
        let callable = self.callable().take();
        drop(callable);
    }

    fn get(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let callable = self.callable().as_ref().map(|own| own.clone_ref(py));
        callable.ok_or_else(|| PyRuntimeError::new_err("the session was collected"))
    }

    /// Locked with the interpreter alone, and for no call: nobody waits for it.
    fn callable(&self) -> MutexGuard<'_, Option<Py<PyAny>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A callable that takes a request as a dict and returns the text of the reply.
pub(crate) struct CallableModel {
    callable: Callable,
    name: String,
    context_tokens: Option<u64>,
    temperature: f64,
    counter: EstimatedTokens,
    /// The exception that the callable raised last.
    raised: Option<PyErr>,
}

impl CallableModel {
    pub(crate) fn new(callable: Callable, name: String, context_tokens: Option<u64>, temperature: f64) -> Self {
        Self {
            callable,
            name,
            context_tokens,
            temperature,
            counter: EstimatedTokens::default(),
            raised: None,
        }
    }

    /// Takes the exception that ended the last call.
    pub(crate) fn take_raised(&mut self) -> Option<PyErr> {
        self.raised.take()
    }

    fn call(&self, request: &ChatRequest) -> PyResult<String> {
        attach(|py| {
            py.check_signals()?;
            let reply = self
                .callable
                .get(py)?
                .bind(py)
                .call1((object(py, &self.body(request))?,))?;
            let text = reply.cast::<PyString>().map_err(|_| {
                let class = class_of(&reply);
                PyTypeError::new_err(format!(
                    "the model must return the text of its reply as a str, not {class}"
                ))
            })?;
            Ok(text.to_str()?.to_owned())
        })
    }

    /// Returns the request with the names of OpenAI's chat completions.
    fn body(&self, request: &ChatRequest) -> Value {
        let messages: Vec<Value> = request
            .messages
            .iter()
            .map(|message| json!({"role": role(message.role), "content": message.text}))
            .collect();
        let mut body = json!({
            "messages": messages,
            "temperature": self.temperature,
            "max_tokens": request.max_tokens,
        });
        if let Constraint::JsonSchema(schema) = &request.constraint {
            body["response_format"] =
                json!({"type": "json_schema", "json_schema": {"name": "answer", "strict": true, "schema": schema}});
        }
        body
    }
}

fn role(role: Role) -> &'static str {
    match role {
        Role::System => "system",
        Role::User => "user",
        Role::Assistant => "assistant",
    }
}

impl TokenCounter for CallableModel {
    fn message_tokens(&mut self, message: &Message) -> u64 {
        self.counter.message_tokens(message)
    }

    fn frame_tokens(&mut self) -> u64 {
        self.counter.frame_tokens()
    }

    fn counting(&self) -> Counting {
        self.counter.counting()
    }
}

impl ChatModel for CallableModel {
    fn name(&self) -> &str {
        &self.name
    }

    fn constraint_kind(&self) -> ConstraintKind {
        ConstraintKind::JsonSchema
    }

    fn chat(&mut self, request: &ChatRequest, _: &mut dyn Watch) -> Result<Reply, ModelError> {
        match self.call(request) {
            Ok(text) => Ok(Reply {
                usage: Usage {
                    calls: 1,
                    ..Usage::default()
                },
                ..Reply::complete(text)
            }),
            Err(raised) => {
                self.raised = Some(raised);
                // The session takes the words back; the exception is raised when it has.
                Err(ModelError::Stopped)
            }
        }
    }

    fn context_tokens(&self) -> Option<u64> {
        self.context_tokens
    }
}
