//! Scene files: boxes, hands and tolerances.

use rustc_hash::{FxHashMap, FxHashSet};
use serde::Deserialize;

use super::forms::{Detected, Orientation, QuaternionOrder, Vector, Volume, detections, is_picture, vector};
use crate::diagnostic::{Diagnostic, Diagnostics, Position};
use crate::environment::Words;
use crate::json::{Locator, Path};

/// Maximum number of boxes and hands: every pair of them is compared.
const MOST: usize = 1_000;
/// The largest coordinate and the longest edge, in metres.
const FARTHEST: f64 = 100_000.0;
/// The shortest edge, in metres.
const SHORTEST: f64 = 1e-6;
/// Maximum number of characters of a name.
const CHARACTERS: usize = 100;
/// Maximum number of findings about one file.
const FINDINGS: usize = 100;

/// Named boxes with poses. Lengths are in metres, angles in radians, and z points upwards.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// The boxes.
    #[serde(alias = "objects")]
    pub boxes: Vec<Body>,
    /// The hands of the robot.
    #[serde(default)]
    pub hands: Vec<Hand>,
    /// The tolerances of the relations.
    #[serde(default)]
    pub tolerances: Tolerances,
    /// The order of the numbers in orientations that are lists.
    #[serde(default)]
    pub quaternions: Option<QuaternionOrder>,
}

/// A named box.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "WrittenBody")]
pub struct Body {
    /// The identifier in the environment. Names without brackets that several boxes have are numbered.
    pub name: String,
    /// The centre.
    pub position: Vector,
    /// The orientation; by default the box is parallel to the axes.
    pub orientation: Orientation,
    /// The lengths of the edges along the axes of the box.
    pub size: Vector,
    /// How sure a detector is; nothing depends on it.
    pub score: Option<f64>,
    /// The list of the environment. By default what is on, in or held by something is an object.
    pub kind: Option<Kind>,
    /// The type in the domain, where it is more precise than that of the list.
    pub type_name: Option<String>,
    /// The box of which this one is a part, such as the fridge of a handle.
    pub part_of: Option<String>,
    /// True if nothing can be inside.
    pub solid: bool,
    /// The state of something that opens, where it is known.
    pub open: Option<bool>,
    /// The joint of something that opens; an alternative to `open`.
    pub joint: Option<Joint>,
    /// Properties in the words of the domain.
    pub properties: Vec<String>,
    /// Further states in the words of the domain.
    pub states: Vec<String>,
}

/// A box as a file writes it: with `position` and `size`, or with `bbox`.
#[derive(Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "a box: an object with `name`, `position` and `size`"
)]
struct WrittenBody {
    #[serde(alias = "label", alias = "class_name")]
    name: String,
    #[serde(default, alias = "center", alias = "centre", deserialize_with = "some_vector")]
    position: Option<Vector>,
    #[serde(default)]
    orientation: Option<Orientation>,
    #[serde(default, alias = "dimensions", deserialize_with = "some_vector")]
    size: Option<Vector>,
    #[serde(default)]
    bbox: Option<Volume>,
    #[serde(default, alias = "confidence")]
    score: Option<f64>,
    #[serde(default)]
    kind: Option<Kind>,
    #[serde(default, rename = "type")]
    type_name: Option<String>,
    #[serde(default)]
    part_of: Option<String>,
    #[serde(default)]
    solid: bool,
    #[serde(default)]
    open: Option<bool>,
    #[serde(default)]
    joint: Option<Joint>,
    #[serde(default)]
    properties: Vec<String>,
    #[serde(default)]
    states: Vec<String>,
}

fn some_vector<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Option<Vector>, D::Error> {
    vector(deserializer).map(Some)
}

impl TryFrom<WrittenBody> for Body {
    type Error = &'static str;

    fn try_from(own: WrittenBody) -> Result<Self, Self::Error> {
        let (position, orientation, size) = match (own.position, own.size, own.bbox) {
            (Some(position), Some(size), None) => (position, own.orientation, size),
            (None, None, Some(volume)) => {
                let (position, orientation, size) = volume.parts();
                if orientation.is_some() && own.orientation.is_some() {
                    return Err("`orientation` is given twice, inside and outside of `bbox`");
                }
                (position, orientation.or(own.orientation), size)
            }
            (_, _, Some(_)) => return Err("give `bbox`, or `position` and `size`, not both"),
            (None, _, None) => return Err("missing field `position`"),
            (Some(_), None, None) => return Err("missing field `size`"),
        };
        Ok(Self {
            name: own.name,
            position,
            orientation: orientation.unwrap_or_default(),
            size,
            score: own.score,
            kind: own.kind,
            type_name: own.type_name,
            part_of: own.part_of,
            solid: own.solid,
            open: own.open,
            joint: own.joint,
            properties: own.properties,
            states: own.states,
        })
    }
}

/// The list of an environment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Cannot be manipulated.
    Asset,
    /// Can be manipulated.
    Object,
}

/// The joint of a door, a drawer or a lid.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Joint {
    /// The position: an angle in radians, or a distance in metres.
    pub position: f64,
    /// The position in which it is closed.
    #[serde(default)]
    pub closed: f64,
}

/// A hand of the robot.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hand {
    /// The identifier, for domains with several hands.
    pub name: String,
    /// The point between the fingers.
    #[serde(deserialize_with = "vector")]
    pub position: Vector,
    /// True if the fingers are closed around something.
    pub closed: bool,
}

/// Tolerances of the relations between boxes.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct Tolerances {
    /// The largest gap between touching faces, and the largest depth to which they are in each other, in metres.
    pub contact: f64,
    /// The least share of a footprint over the face on which a box rests.
    pub overlap: f64,
    /// The least share of the volume of a box in its container.
    pub containment: f64,
    /// The largest gap between neighbours, in metres.
    pub neighbour: f64,
    /// The largest distance of a closed hand from the box that it holds, in metres.
    pub grasp: f64,
    /// The largest distance of a joint from its closed position, in radians or metres.
    pub joint: f64,
}

impl Default for Tolerances {
    fn default() -> Self {
        Self {
            contact: 0.02,
            overlap: 0.3,
            containment: 0.5,
            neighbour: 0.05,
            grasp: 0.03,
            joint: 0.02,
        }
    }
}

impl Scene {
    /// Reads a scene file. `file` is its name in diagnostics.
    ///
    /// ```
    /// use longstep_model::geometry::Scene;
    /// let text = r#"{"boxes": [{"name": "<cup>", "position": [0, 0, 0.8], "size": [0.08, 0.08, 0.1]}]}"#;
    /// assert_eq!(Scene::parse("boxes.json", text).unwrap().boxes.len(), 1);
    /// ```
    ///
    /// # Errors
    ///
    /// The first place where the text is not JSON in this form; otherwise all numbers and names that no scene can have.
    pub fn parse(file: &str, text: &str) -> Result<Self, Diagnostics> {
        let is_detections = text.contains("\"detections\"") && !text.contains("\"boxes\"");
        let read = match is_detections {
            true => detections(text).map(|all| Self::of(all.into_iter().map(Body::from).collect())),
            false if text.trim_start().starts_with('[') => serde_json::from_str(text).map(Self::of),
            false => serde_json::from_str(text),
        };
        let mut scene: Self = read.map_err(|error| {
            let (line, column) = (error.line() as u32, error.column().max(1) as u32);
            let full = error.to_string();
            let reason = full
                .strip_suffix(&format!(" at line {line} column {}", error.column()))
                .unwrap_or(&full);
            let (message, hint) = if is_picture(text) { (
                "boxes of a picture, in pixels, have no position and no size in space",
                "give each a `position` and a `size` in metres, from a depth camera for example, or pass the picture itself; see \
                 docs/guide/seeing.md",
            ) } else { (
                reason,
                "a scene is JSON with `boxes`: each has `name`, `position` and `size`; see docs/guide/seeing.md",
            ) };
            Diagnostics(vec![
                Diagnostic::at(file, Position { line, column }, message).hint(hint),
            ])
        })?;
        scene.number_names();
        let mut check = Check {
            file,
            locator: Locator::new(text),
            findings: Vec::new(),
        };
        check.scene(&scene);
        if check.findings.is_empty() {
            Ok(scene.normalized())
        } else {
            Err(Diagnostics::sorted(check.findings))
        }
    }

    fn of(boxes: Vec<Body>) -> Self {
        Self {
            boxes,
            ..Self::default()
        }
    }

    /// Numbers names without brackets that several boxes have: detectors name classes.
    fn number_names(&mut self) {
        let mut counts: FxHashMap<String, (usize, usize)> = FxHashMap::default();
        for body in &self.boxes {
            counts.entry(body.name.clone()).or_default().0 += 1;
        }
        for body in self.boxes.iter_mut().filter(|body| !body.name.starts_with('<')) {
            if let Some((2.., number)) = counts.get_mut(&body.name) {
                *number += 1;
                body.name = format!("{} {number}", body.name);
            }
        }
    }

    /// Returns the scene with orientations of length 1, in the order w, x, y, z.
    fn normalized(mut self) -> Self {
        for body in &mut self.boxes {
            let parts = body.orientation.ordered(self.quaternions).parts;
            let length = length(&parts);
            body.orientation = Orientation::new(parts.map(|part| part / length));
        }
        self
    }
}

impl Body {
    /// A box without a place and a size.
    pub(super) fn named(name: String) -> Self {
        Self {
            name,
            position: [0.0; 3],
            orientation: Orientation::default(),
            size: [0.0; 3],
            score: None,
            kind: None,
            type_name: None,
            part_of: None,
            solid: false,
            open: None,
            joint: None,
            properties: Vec::new(),
            states: Vec::new(),
        }
    }
}

fn length(parts: &[f64]) -> f64 {
    parts.iter().map(|part| part * part).sum::<f64>().sqrt()
}

impl From<Detected> for Body {
    fn from(own: Detected) -> Self {
        Self {
            position: own.position,
            orientation: own.orientation,
            size: own.size,
            ..Self::named(own.name)
        }
    }
}

struct Check<'a> {
    file: &'a str,
    locator: Locator<'a>,
    findings: Vec<Diagnostic>,
}

impl Check<'_> {
    fn report(&mut self, path: &Path, message: impl std::fmt::Display) {
        if self.findings.len() < FINDINGS {
            self.findings.push(Diagnostic {
                position: self.locator.locate(path),
                ..Diagnostic::whole(self.file, format!("{path}: {message}"))
            });
        }
    }

    fn scene(&mut self, scene: &Scene) {
        if scene.boxes.len() + scene.hands.len() > MOST {
            return self.report(&Path::key("boxes"), format!("more than {MOST} boxes and hands"));
        }
        let mut names: FxHashSet<&str> = FxHashSet::default();
        let known: FxHashSet<&str> = scene.boxes.iter().map(|body| body.name.as_str()).collect();
        for (index, body) in scene.boxes.iter().enumerate() {
            let path = Path::key("boxes").index(index);
            self.name(&path.push("name"), &body.name, &mut names);
            self.point(&path.push("position"), body.position);
            if !body.size.iter().all(|edge| (SHORTEST..=FARTHEST).contains(edge)) {
                let message = format!("an edge is {SHORTEST} to {FARTHEST} m long");
                self.report(&path.push("size"), message);
            }
            if !(0.99..=1.01).contains(&length(&body.orientation.parts)) {
                let message = "an orientation is a quaternion of length 1";
                self.report(&path.push("orientation"), message);
            } else if body.orientation.is_listed && scene.quaternions.is_none() {
                let message = "a list does not say which number is w; write {\"w\": 1, \"x\": 0, \"y\": 0, \"z\": 0}, or \
                               \"quaternions\": \"wxyz\" or \"xyzw\" beside `boxes`";
                self.report(&path.push("orientation"), message);
            }
            if let Some(whole) = &body.part_of
                && (whole == &body.name || !known.contains(whole.as_str()))
            {
                self.report(&path.push("part_of"), format!("there is no other box `{whole}`"));
            }
            if body.open.is_some() && body.joint.is_some() {
                self.report(&path.push("joint"), "give `open` or `joint`, not both");
            }
        }
        for (index, hand) in scene.hands.iter().enumerate() {
            let path = Path::key("hands").index(index);
            self.name(&path.push("name"), &hand.name, &mut names);
            self.point(&path.push("position"), hand.position);
        }
        self.tolerances(&scene.tolerances);
    }

    fn name<'n>(&mut self, path: &Path, name: &'n str, names: &mut FxHashSet<&'n str>) {
        if name.trim().is_empty() || name.chars().count() > CHARACTERS {
            self.report(path, format!("a name has 1 to {CHARACTERS} characters"));
        } else if !names.insert(name) {
            self.report(path, format!("`{name}` is listed twice"));
        }
    }

    fn point(&mut self, path: &Path, point: Vector) {
        if !point.iter().all(|coordinate| coordinate.abs() <= FARTHEST) {
            self.report(path, format!("a coordinate is at most {FARTHEST} m"));
        }
    }

    fn tolerances(&mut self, tolerances: &Tolerances) {
        let path = Path::key("tolerances");
        for (key, value, most) in [
            ("contact", tolerances.contact, 1.0),
            ("overlap", tolerances.overlap, 1.0),
            ("containment", tolerances.containment, 1.0),
            ("neighbour", tolerances.neighbour, 10.0),
            ("grasp", tolerances.grasp, 1.0),
            ("joint", tolerances.joint, 1.0),
        ] {
            if !(value > 0.0 && value <= most) {
                self.report(&path.push(key), format!("a tolerance is above 0 and at most {most}"));
            }
        }
    }
}

/// Returns texts as one word or a list.
pub(super) fn words(mut texts: Vec<String>) -> Words {
    match texts.len() {
        1 => Words::One(texts.remove(0)),
        _ => Words::Many(texts),
    }
}
