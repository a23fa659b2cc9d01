//! Skill parameters: how a robot performs an action, which planning does not depend on.

/// A parameter of the robot's skill for an action.
#[derive(Debug, Clone, PartialEq)]
pub struct SkillParameter {
    /// The name, unique in its action.
    pub name: String,
    /// The type of its values.
    pub kind: SkillType,
    /// The unit of its numbers; none for directions, texts and numbers without a unit.
    pub unit: Option<String>,
    /// The origin of its values.
    pub from: SkillSource,
    /// The part of a demonstration that gives its values; none if they are written by hand.
    pub fit: Option<SkillFit>,
    /// The direction that a demonstration is expected to show, in its frame.
    pub prior: Option<[f64; 3]>,
}

/// The type of the values of a skill parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SkillType {
    /// A position and an orientation as a quaternion: seven numbers.
    Pose,
    /// A position: three numbers.
    Point,
    /// A displacement: three numbers.
    Vector,
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
    pub const ALL: [Self; 10] = [
        Self::Pose,
        Self::Point,
        Self::Vector,
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
            Self::Vector => "vector",
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
            Self::Point | Self::Vector => "three numbers",
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

/// The part of a demonstration that gives the values of a skill parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SkillFit {
    /// The position of the hand at the first frame.
    FirstPosition,
    /// The position of the hand at the last frame.
    LastPosition,
    /// The positions of the hand at all frames.
    Path,
    /// The position of the object.
    ObjectPosition,
    /// The hand: `left` or `right`.
    Hand,
    /// The kind of grasp.
    Grasp,
    /// The direction of the hand towards the object, before the hand closes.
    Approach,
    /// The direction of the hand from the object, after the hand opens.
    Retreat,
    /// The displacement of a straight motion.
    Displacement,
    /// The axis of a rotation.
    Axis,
    /// The centre of a rotation.
    Centre,
    /// The radius of a rotation.
    Radius,
    /// The angle of a rotation.
    Angle,
    /// The normal of a plane.
    Normal,
    /// The direction of the upper arm at the first frame, one of 26.
    UpperArmFirst,
    /// The direction of the upper arm at the last frame.
    UpperArmLast,
    /// The direction of the lower arm at the first frame.
    LowerArmFirst,
    /// The direction of the lower arm at the last frame.
    LowerArmLast,
}

impl SkillFit {
    /// All fits.
    pub const ALL: [Self; 18] = [
        Self::FirstPosition,
        Self::LastPosition,
        Self::Path,
        Self::ObjectPosition,
        Self::Hand,
        Self::Grasp,
        Self::Approach,
        Self::Retreat,
        Self::Displacement,
        Self::Axis,
        Self::Centre,
        Self::Radius,
        Self::Angle,
        Self::Normal,
        Self::UpperArmFirst,
        Self::UpperArmLast,
        Self::LowerArmFirst,
        Self::LowerArmLast,
    ];

    /// The fit in `domain.toml` and `skills.toml`.
    pub fn name(self) -> &'static str {
        match self {
            Self::FirstPosition => "first-position",
            Self::LastPosition => "last-position",
            Self::Path => "path",
            Self::ObjectPosition => "object-position",
            Self::Hand => "hand",
            Self::Grasp => "grasp",
            Self::Approach => "approach",
            Self::Retreat => "retreat",
            Self::Displacement => "displacement",
            Self::Axis => "axis",
            Self::Centre => "centre",
            Self::Radius => "radius",
            Self::Angle => "angle",
            Self::Normal => "normal",
            Self::UpperArmFirst => "upper-arm-first",
            Self::UpperArmLast => "upper-arm-last",
            Self::LowerArmFirst => "lower-arm-first",
            Self::LowerArmLast => "lower-arm-last",
        }
    }

    /// The type of its values.
    pub fn kind(self) -> SkillType {
        match self {
            Self::FirstPosition | Self::LastPosition | Self::ObjectPosition | Self::Centre => SkillType::Point,
            Self::Path => SkillType::Waypoints,
            Self::Grasp => SkillType::Grasp,
            Self::Approach | Self::Retreat | Self::Axis | Self::Normal => SkillType::Direction,
            Self::Displacement => SkillType::Vector,
            Self::Radius => SkillType::Number,
            Self::Angle => SkillType::Angle,
            Self::Hand | Self::UpperArmFirst | Self::UpperArmLast | Self::LowerArmFirst | Self::LowerArmLast => {
                SkillType::Text
            }
        }
    }

    /// The unit that its values have; none for values without a unit.
    pub fn unit(self) -> Option<&'static str> {
        match self.kind() {
            SkillType::Angle => Some("rad"),
            kind => kind.has_unit().then_some("m"),
        }
    }

    /// Returns true if a demonstration can be compared with an expected direction.
    pub fn has_prior(self) -> bool {
        matches!(
            self,
            Self::Approach | Self::Retreat | Self::Displacement | Self::Axis | Self::Normal
        )
    }
}
