//! Skill parameters: how a robot performs an action, which planning does not depend on.

/// A parameter of the robot's skill for an action.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SkillParameter {
    /// The name, unique in its action.
    pub name: String,
    /// The type of its values.
    pub kind: SkillType,
    /// The unit of its numbers; none for directions, texts and numbers without a unit.
    pub unit: Option<String>,
    /// The origin of its values.
    pub from: SkillSource,
}

/// The type of the values of a skill parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SkillType {
    /// A position and an orientation as a quaternion: seven numbers.
    Pose,
    /// A position: three numbers.
    Point,
    /// A direction: three numbers, not all of them zero.
    Direction,
    /// An angle.
    Angle,
    /// A force.
    Force,
    /// The name of a kind of grasp.
    Grasp,
    /// Positions in order: a list of points.
    Waypoints,
    /// A number.
    Number,
    /// A text.
    Text,
}

impl SkillType {
    /// All types.
    pub const ALL: [Self; 9] = [
        Self::Pose,
        Self::Point,
        Self::Direction,
        Self::Angle,
        Self::Force,
        Self::Grasp,
        Self::Waypoints,
        Self::Number,
        Self::Text,
    ];

    /// The type in `domain.toml`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pose => "pose",
            Self::Point => "point",
            Self::Direction => "direction",
            Self::Angle => "angle",
            Self::Force => "force",
            Self::Grasp => "grasp",
            Self::Waypoints => "waypoints",
            Self::Number => "number",
            Self::Text => "text",
        }
    }

    /// The form of a value, for messages.
    pub fn form(self) -> &'static str {
        match self {
            Self::Pose => "seven numbers: a position, and an orientation as a quaternion of length 1",
            Self::Point => "three numbers",
            Self::Direction => "three numbers, not all of them zero",
            Self::Angle | Self::Force | Self::Number => "a number",
            Self::Grasp | Self::Text => "a text of 1 to 1,000 characters",
            Self::Waypoints => "1 to 10,000 points of three numbers",
        }
    }

    /// Returns true if values of the type are numbers with a unit.
    pub fn has_unit(self) -> bool {
        !matches!(self, Self::Direction | Self::Grasp | Self::Text)
    }
}

/// The origin of the values of a skill parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SkillSource {
    /// A person taught it; a step without a value is not performed.
    Demonstration,
    /// The robot finds it itself; a value that is given is passed along.
    Robot,
}
