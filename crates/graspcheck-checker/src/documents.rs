//! The three documents of a recording, as far as the proof of clearance rests on them.

use graspcheck_recording::Recording;
use serde::{Deserialize, de::DeserializeOwned};

use crate::{
    CheckerError, LARGEST,
    polynomial::{Coefficients, magnitude},
    solid::Solid,
    vector::{Direction, Pose, Vector},
};

const RESOLVED: &str = "resolved.json";
const PLAN: &str = "plan.json";
const CERTIFICATE: &str = "certificate.json";

/// The form of all three documents that is known.
const SCHEMA: u32 = 1;

/// Times that should be one differ by no more than this, s, for each second of the plan and one more.
const SAME_TIME: f64 = 1e-9;

/// Names in a clearance rule that stand for several bodies.
pub(crate) const GROUPS: [&str; 2] = ["robot", "gripper"];

pub(crate) struct Documents {
    pub(crate) resolved: Resolved,
    pub(crate) plan: Plan,
    pub(crate) certificate: Certificate,
}

#[derive(Deserialize)]
pub(crate) struct Resolved {
    #[serde(rename = "schema")]
    _known: Known,
    pub(crate) robot: Robot,
    pub(crate) cell: Cell,
    pub(crate) object: Option<Object>,
}

#[derive(Deserialize)]
pub(crate) struct Robot {
    pub(crate) world_from_base: Pose,
    pub(crate) base: Link,
    pub(crate) joints: Vec<Joint>,
    pub(crate) links: Vec<Link>,
    pub(crate) link_from_tool: Pose,
    pub(crate) gripper: Gripper,
    pub(crate) allowed_contacts: Vec<AllowedContact>,
}

#[derive(Deserialize)]
pub(crate) struct Link {
    pub(crate) name: String,
    pub(crate) shapes: Vec<PlacedShape>,
}

#[derive(Deserialize)]
pub(crate) struct PlacedShape {
    pub(crate) body_from_shape: Pose,
    pub(crate) shape: Solid,
}

#[derive(Deserialize)]
pub(crate) struct Joint {
    pub(crate) kind: JointKind,
    pub(crate) parent_from_joint: Pose,
    pub(crate) axis: Direction,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum JointKind {
    Revolute,
    Prismatic,
}

#[derive(Deserialize)]
pub(crate) struct Gripper {
    pub(crate) fingers: [Finger; 2],
}

/// It slides along its axis to half of the opening.
#[derive(Deserialize)]
pub(crate) struct Finger {
    pub(crate) link: Link,
    pub(crate) link_from_finger: Pose,
    pub(crate) axis: Direction,
}

#[derive(Deserialize)]
pub(crate) struct AllowedContact {
    pub(crate) a: String,
    pub(crate) b: String,
}

#[derive(Deserialize)]
pub(crate) struct Cell {
    pub(crate) gravity: Vector,
    pub(crate) bodies: Vec<CellBody>,
    pub(crate) clearance: Clearance,
}

#[derive(Deserialize)]
pub(crate) struct CellBody {
    pub(crate) name: String,
    pub(crate) shape: Solid,
    pub(crate) world_from_shape: Pose,
}

#[derive(Deserialize)]
pub(crate) struct Clearance {
    pub(crate) required: f64,
    pub(crate) pairs: Vec<Rule>,
}

#[derive(Deserialize)]
pub(crate) struct Rule {
    pub(crate) a: String,
    pub(crate) b: String,
    pub(crate) required: f64,
}

#[derive(Deserialize)]
pub(crate) struct Object {
    pub(crate) name: String,
    pub(crate) shape: Solid,
    pub(crate) world_from_object: Pose,
}

#[derive(Deserialize)]
pub(crate) struct Plan {
    #[serde(rename = "schema")]
    _known: Known,
    pub(crate) trajectory: Trajectory,
    pub(crate) opening: Trajectory,
    pub(crate) phases: Vec<Phase>,
    pub(crate) grasp: Option<Grasp>,
}

#[derive(Deserialize)]
pub(crate) struct Trajectory {
    pub(crate) knots: Vec<f64>,
    /// `[piece][joint]`, in the time since the piece's first knot.
    pub(crate) coefficients: Vec<Vec<Coefficients>>,
}

#[derive(Deserialize)]
pub(crate) struct Phase {
    pub(crate) name: String,
    pub(crate) start: f64,
    pub(crate) end: f64,
    pub(crate) holding: Holding,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Holding {
    Nothing,
    AtStart,
    Closing,
    Held,
    Opening,
    Placed,
}

#[derive(Deserialize)]
pub(crate) struct Grasp {
    pub(crate) tool_from_object: Pose,
    pub(crate) width: f64,
    pub(crate) world_from_placed: Pose,
}

#[derive(Deserialize)]
pub(crate) struct Certificate {
    #[serde(rename = "schema")]
    _known: Known,
    pub(crate) duration: f64,
    pub(crate) pairs: Vec<PairProof>,
}

#[derive(Deserialize)]
pub(crate) struct PairProof {
    pub(crate) a: String,
    pub(crate) part_a: usize,
    pub(crate) b: String,
    pub(crate) part_b: usize,
    pub(crate) verdict: Verdict,
    pub(crate) leaves: Vec<Leaf>,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Verdict {
    Free { margin: f64 },
    Violated(Violation),
    Unknown {},
    NotChecked {},
}

#[derive(Deserialize)]
pub(crate) struct Violation {
    pub(crate) time: f64,
    pub(crate) phase: String,
    pub(crate) distance: f64,
    pub(crate) required: f64,
    pub(crate) points: [Vector; 2],
}

#[derive(Deserialize)]
pub(crate) struct Leaf {
    pub(crate) start: f64,
    pub(crate) end: f64,
    pub(crate) normal: Vector,
    pub(crate) gap: f64,
    pub(crate) loss: f64,
    pub(crate) required: f64,
}

impl Documents {
    pub(crate) fn read(recording: &Recording) -> Result<Self, CheckerError> {
        let documents = Self {
            resolved: document(recording, RESOLVED)?,
            plan: document(recording, PLAN)?,
            certificate: document(recording, CERTIFICATE)?,
        };
        let Self { resolved, plan, .. } = &documents;
        resolved.check().map_err(|what| CheckerError::Unsound { name: RESOLVED, what })?;
        let has_object = resolved.object.is_some();
        plan.check(resolved.robot.joints.len(), has_object)
            .map_err(|what| CheckerError::Unsound { name: PLAN, what })?;
        Ok(documents)
    }
}

/// The schema of a document, when it is [`SCHEMA`].
#[derive(Deserialize)]
#[serde(try_from = "u32")]
struct Known;

impl TryFrom<u32> for Known {
    type Error = String;

    fn try_from(schema: u32) -> Result<Self, String> {
        if schema == SCHEMA { Ok(Self) } else { Err(format!("schema {schema} is unknown")) }
    }
}

/// A document of the known form. One of another form need not decode: then its number is the reason.
fn document<T: DeserializeOwned>(recording: &Recording, name: &'static str) -> Result<T, CheckerError> {
    #[derive(Deserialize)]
    struct Head {
        schema: u32,
    }
    let data = &recording.attachment(name).ok_or(CheckerError::Missing { name })?.data;
    serde_json::from_slice(data).map_err(|source| match serde_json::from_slice(data) {
        Ok(Head { schema }) if schema != SCHEMA => {
            CheckerError::UnknownSchema { name, found: schema, known: SCHEMA }
        }
        _ => CheckerError::Undecodable { name, source },
    })
}

impl Resolved {
    /// The names of all bodies.
    fn names(&self) -> impl Iterator<Item = &str> {
        let Self { robot, cell, object, .. } = self;
        let links = std::iter::once(&robot.base).chain(&robot.links);
        let links = links.chain(robot.gripper.fingers.iter().map(|finger| &finger.link));
        let links = links.map(|link| link.name.as_str());
        links
            .chain(cell.bodies.iter().map(|body| body.name.as_str()))
            .chain(object.iter().map(|it| it.name.as_str()))
    }

    fn check(&self) -> Result<(), String> {
        let (joints, links) = (self.robot.joints.len(), self.robot.links.len());
        if joints == 0 || joints != links {
            return Err(format!(
                "{joints} joints and {links} moving links must be as many, and at least one"
            ));
        }
        let mut names: Vec<&str> = self.names().collect();
        names.sort_unstable();
        if let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(format!("two bodies are named {}", twice[0]));
        }
        if let Some(group) = GROUPS.iter().find(|group| names.contains(group)) {
            return Err(format!("a body has the name {group}, which stands for several"));
        }
        let rules = self.cell.clearance.pairs.iter();
        let of_rules = rules.clone().flat_map(|rule| [&rule.a, &rule.b]);
        if let Some(unknown) =
            of_rules.map(String::as_str).find(|n| !names.contains(n) && !GROUPS.contains(n))
        {
            return Err(format!("a clearance rule names the unknown body {unknown}"));
        }
        let allowed = self.robot.allowed_contacts.iter().flat_map(|contact| [&contact.a, &contact.b]);
        if let Some(unknown) = allowed.map(String::as_str).find(|name| !names.contains(name)) {
            return Err(format!("an allowed contact names the unknown body {unknown}"));
        }
        let mut required = rules.map(|rule| rule.required).chain([self.cell.clearance.required]);
        match required.find(|required| !(*required >= 0.0 && *required < LARGEST)) {
            Some(required) => Err(format!("a clearance of {required} m is negative or above {LARGEST} m")),
            None => Ok(()),
        }
    }
}

impl Plan {
    /// When the plan ends, s.
    pub(crate) fn duration(&self) -> f64 {
        self.trajectory.duration()
    }

    /// The index of the phase at a time inside of the plan.
    pub(crate) fn phase_at(&self, time: f64) -> usize {
        self.phases.partition_point(|phase| phase.end <= time).min(self.phases.len() - 1)
    }

    fn check(&self, joints: usize, has_object: bool) -> Result<(), String> {
        self.trajectory.check("the trajectory", joints)?;
        self.opening.check("the opening", 1)?;
        let duration = self.duration();
        let same = |a: f64, b: f64| (a - b).abs() <= SAME_TIME * (1.0 + duration);
        if !same(self.opening.duration(), duration) {
            return Err(format!(
                "the opening ends at {} s, the arm at {duration} s",
                self.opening.duration()
            ));
        }
        let mut end = 0.0;
        for Phase { name, start, end: next, holding } in &self.phases {
            if !(same(*start, end) && *next >= end) {
                return Err(format!("phase {name}: {start} s to {next} s does not follow {end} s"));
            }
            let is_moved = !matches!(holding, Holding::Nothing | Holding::AtStart | Holding::Closing);
            if has_object && is_moved && self.grasp.is_none() {
                return Err(format!("phase {name}: the object is {holding:?}, but there is no grasp"));
            }
            end = *next;
        }
        if self.phases.is_empty() || !same(end, duration) {
            return Err(format!("the phases end at {end} s, the arm at {duration} s"));
        }
        match &self.grasp {
            Some(Grasp { width, .. }) if !(*width >= 0.0 && *width < LARGEST) => {
                Err(format!("a grasp of width {width} m is negative or above {LARGEST} m"))
            }
            _ => Ok(()),
        }
    }
}

impl Trajectory {
    pub(crate) fn duration(&self) -> f64 {
        self.knots[self.knots.len() - 1]
    }

    fn check(&self, what: &str, joints: usize) -> Result<(), String> {
        let Self { knots, coefficients } = self;
        if knots.len() < 2 || knots[0] != 0.0 || !knots.is_sorted_by(|a, b| a < b) {
            return Err(format!("{what}: its knots must begin at 0 s and increase"));
        }
        if coefficients.len() + 1 != knots.len() || coefficients.iter().any(|piece| piece.len() != joints) {
            return Err(format!("{what}: each interval of knots needs {joints} polynomials"));
        }
        for (piece, interval) in coefficients.iter().zip(knots.windows(2)) {
            if !piece.iter().all(|joint| magnitude(joint, interval[1] - interval[0]) < LARGEST) {
                return Err(format!(
                    "{what}: after {} s its terms are too large to be computed with",
                    interval[0]
                ));
            }
        }
        Ok(())
    }
}
