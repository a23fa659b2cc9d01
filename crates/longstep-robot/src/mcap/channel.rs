//! The topics of a recording, with their schemas.

/// A topic of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Channel {
    Plan,
    Step,
    Observation,
    Assessment,
    World,
    Run,
    Log,
}

impl Channel {
    pub(super) const ALL: [Self; 7] = [
        Self::Plan,
        Self::Step,
        Self::Observation,
        Self::Assessment,
        Self::World,
        Self::Run,
        Self::Log,
    ];

    /// Returns the topic.
    pub(super) fn topic(self) -> &'static str {
        match self {
            Self::Plan => "/longstep/plan",
            Self::Step => "/longstep/step",
            Self::Observation => "/longstep/observation",
            Self::Assessment => "/longstep/assessment",
            Self::World => "/longstep/world",
            Self::Run => "/longstep/run",
            Self::Log => "/longstep/log",
        }
    }

    /// Returns the name of the schema. Viewers know `foxglove.Log` and show it in their log panel.
    pub(super) fn schema_name(self) -> &'static str {
        match self {
            Self::Plan => "longstep.Plan",
            Self::Step => "longstep.Step",
            Self::Observation => "longstep.Observation",
            Self::Assessment => "longstep.Assessment",
            Self::World => "longstep.World",
            Self::Run => "longstep.Run",
            Self::Log => "foxglove.Log",
        }
    }

    /// Returns the JSON schema. It is flat, without references and alternatives, which viewers do not read.
    pub(super) fn schema(self) -> &'static str {
        match self {
            Self::Plan => include_str!("schemas/plan.json"),
            Self::Step => include_str!("schemas/step.json"),
            Self::Observation => include_str!("schemas/observation.json"),
            Self::Assessment => include_str!("schemas/assessment.json"),
            Self::World => include_str!("schemas/world.json"),
            Self::Run => include_str!("schemas/run.json"),
            Self::Log => include_str!("schemas/log.json"),
        }
    }
}
