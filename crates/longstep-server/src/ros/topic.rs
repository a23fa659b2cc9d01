//! The topics and services of a face.

use longstep_robot::ros2::Serving;
use longstep_robot::rosbridge;
use serde_json::{Value, json};

/// The type of all topics.
const TEXT: &str = "std_msgs/msg/String";

/// The type of the services.
const REQUEST: &str = "longstep_msgs/srv/Ask";

/// A topic that shows the state of the server. Its last message is latched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Shown {
    Plan,
    Progress,
    World,
}

impl Shown {
    pub(super) const ALL: [Self; 3] = [Self::Plan, Self::Progress, Self::World];

    fn name(self) -> &'static str {
        match self {
            Self::Plan => "plan",
            Self::Progress => "progress",
            Self::World => "world",
        }
    }
}

/// A kind of request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Asked {
    Say,
    Execute,
}

impl Asked {
    const ALL: [Self; 2] = [Self::Say, Self::Execute];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Say => "say",
            Self::Execute => "execute",
        }
    }
}

/// The recipient of an answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum ReplyTo {
    /// The topic for responses.
    Topic(Asked),
    /// The caller of a service, by the id of the call.
    Call { asked: Asked, id: String },
}

impl ReplyTo {
    pub(super) fn asked(&self) -> Asked {
        match self {
            Self::Topic(asked) | Self::Call { asked, .. } => *asked,
        }
    }
}

/// The names of the topics and services.
#[derive(Debug, Clone)]
pub(super) struct Topics {
    namespace: String,
    has_services: bool,
}

impl Topics {
    pub(super) fn new(serving: &Serving) -> Self {
        Self {
            namespace: serving.namespace.clone(),
            has_services: serving.services,
        }
    }

    fn shown(&self, shown: Shown) -> String {
        format!("{}/{}", self.namespace, shown.name())
    }

    fn service(&self, asked: Asked) -> String {
        format!("{}/{}", self.namespace, asked.name())
    }

    fn request(&self, asked: Asked) -> String {
        format!("{}/request", self.service(asked))
    }

    fn response(&self, asked: Asked) -> String {
        format!("{}/response", self.service(asked))
    }

    /// Returns the messages with which a connection begins.
    pub(super) fn greeting(&self) -> Vec<Value> {
        let mut messages = Vec::new();
        for shown in Shown::ALL {
            let topic = self.shown(shown);
            messages.push(rosbridge::advertise(&topic, &topic, TEXT, true));
        }
        for asked in Asked::ALL {
            let topic = self.response(asked);
            // Latched too: a caller that the bridge has not discovered yet would miss its answer.
            messages.push(rosbridge::advertise(&topic, &topic, TEXT, true));
            if self.has_services {
                messages.push(rosbridge::advertise_service(&self.service(asked), REQUEST));
            }
        }
        // The last: whoever is heard can be answered.
        for asked in Asked::ALL {
            let topic = self.request(asked);
            messages.push(rosbridge::subscribe(&topic, &topic, TEXT));
        }
        messages
    }

    /// Returns a message that shows a state.
    pub(super) fn publication(&self, shown: Shown, text: &str) -> Value {
        rosbridge::publish(&self.shown(shown), &json!({ "data": text }))
    }

    /// Returns the message with an answer.
    pub(super) fn answer(&self, to: &ReplyTo, text: &str) -> Value {
        match to {
            ReplyTo::Topic(asked) => rosbridge::publish(&self.response(*asked), &json!({ "data": text })),
            ReplyTo::Call { asked, id } => rosbridge::respond(id, &self.service(*asked), &json!({ "response": text })),
        }
    }

    /// Returns the kind of requests of a topic.
    pub(super) fn asked_on(&self, topic: &str) -> Option<Asked> {
        Asked::ALL.into_iter().find(|asked| self.request(*asked) == topic)
    }

    /// Returns the kind of requests of a service.
    pub(super) fn asked_of(&self, service: &str) -> Option<Asked> {
        let is_own = |asked: &Asked| self.has_services && self.service(*asked) == service;
        Asked::ALL.into_iter().find(is_own)
    }
}
