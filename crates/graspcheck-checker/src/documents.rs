//! The documents of a recording, as far as the proofs rest on them.

use graspcheck_recording::Recording;
use serde::{Deserialize, de::DeserializeOwned};

use crate::{
    CheckerError, LARGEST, LimitQuantity,
    polynomial::{Coefficients, magnitude},
    solid::Solid,
    vector::{Direction, Pose, Vector},
};

const RESOLVED: &str = "resolved.json";
const PLAN: &str = "plan.json";
const CERTIFICATE: &str = "certificate.json";
const LIMITS: &str = "limits.json";

/// The newest form of a certificate that is known. From the second on it may have sweeps, and the proofs of
/// limits stand beside it.
const CERTIFICATE_SCHEMA: u32 = 2;

/// Times that should be one differ by no more than this, s, for each second of the plan and one more.
const SAME_TIME: f64 = 1e-9;

/// Names in a clearance rule that stand for several bodies.
pub(crate) const GROUPS: [&str; 2] = ["robot", "gripper"];

/// The documents of a recording, decoded.
pub struct Documents {
    pub(crate) resolved: Resolved,
    pub(crate) plan: Plan,
    pub(crate) certificate: Certificate,
    /// None in logs that are older than these proofs.
    pub(crate) limits: Option<Limits>,
}

#[derive(Deserialize)]
pub(crate) struct Resolved {
    #[serde(rename = "schema")]
    _known: Known<1>,
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
    pub(crate) name: String,
    pub(crate) kind: JointKind,
    pub(crate) limits: JointLimits,
    pub(crate) parent_from_joint: Pose,
    pub(crate) axis: Direction,
}

/// SI units and radians.
#[derive(Deserialize)]
pub(crate) struct JointLimits {
    pub(crate) position_min: f64,
    pub(crate) position_max: f64,
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
    pub(crate) jerk: f64,
    pub(crate) effort: f64,
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
    _known: Known<1>,
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
    schema: Known<CERTIFICATE_SCHEMA>,
    pub(crate) duration: f64,
    /// How many pairs there are, with those that sweeps prove alone.
    pub(crate) pair_count: Option<usize>,
    pub(crate) pairs: Vec<PairProof>,
    #[serde(default)]
    pub(crate) sweeps: Vec<Sweep>,
}

/// A box that holds all of a solid for a while.
#[derive(Deserialize)]
pub(crate) struct Sweep {
    pub(crate) start: f64,
    pub(crate) end: f64,
    pub(crate) body: String,
    pub(crate) part: usize,
    pub(crate) min: Vector,
    pub(crate) max: Vector,
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

/// The proofs of the joints' limits.
#[derive(Deserialize)]
pub(crate) struct Limits {
    #[serde(rename = "schema")]
    _known: Known<1>,
    pub(crate) duration: f64,
    pub(crate) limits: Vec<LimitProof>,
    pub(crate) breaks: Vec<BreakClaim>,
    /// Why nothing is claimed of efforts.
    pub(crate) effort_unproved: Option<String>,
}

/// What is claimed of one quantity of one joint.
#[derive(Deserialize)]
pub(crate) struct LimitProof {
    pub(crate) joint: String,
    pub(crate) quantity: LimitQuantity,
    pub(crate) limit: f64,
    /// It is never beyond this.
    pub(crate) bound: f64,
    /// It is this …
    pub(crate) peak: f64,
    /// … then, s.
    pub(crate) time: f64,
}

/// A jump of a derivative of one joint.
#[derive(Deserialize)]
pub(crate) struct BreakClaim {
    pub(crate) joint: String,
    /// 0 position, 1 velocity, 2 acceleration.
    pub(crate) order: usize,
    pub(crate) time: f64,
    /// After less before.
    pub(crate) size: f64,
}

impl Documents {
    /// Decodes the documents of a recording and sees to it that they fit each other.
    ///
    /// # Errors
    /// When one is missing, cannot be decoded, has another form than this version knows, or contradicts
    /// itself or the others.
    pub fn read(recording: &Recording) -> Result<Self, CheckerError> {
        let certificate: Certificate = document(recording, CERTIFICATE, CERTIFICATE_SCHEMA)?;
        let is_older = certificate.schema.0 < CERTIFICATE_SCHEMA;
        let limits = match document(recording, LIMITS, 1) {
            Err(CheckerError::Missing { .. }) if is_older => None,
            limits => Some(limits?),
        };
        let documents = Self {
            resolved: document(recording, RESOLVED, 1)?,
            plan: document(recording, PLAN, 1)?,
            certificate,
            limits,
        };
        let Self { resolved, plan, .. } = &documents;
        resolved.check().map_err(|what| CheckerError::Unsound { name: RESOLVED, what })?;
        let has_object = resolved.object.is_some();
        plan.check(resolved.robot.joints.len(), has_object)
            .map_err(|what| CheckerError::Unsound { name: PLAN, what })?;
        Ok(documents)
    }
}

/// The schema of a document, from 1 to the newest that is known.
#[derive(Clone, Copy, Deserialize)]
#[serde(try_from = "u32")]
struct Known<const NEWEST: u32>(u32);

impl<const NEWEST: u32> TryFrom<u32> for Known<NEWEST> {
    type Error = String;

    fn try_from(schema: u32) -> Result<Self, String> {
        if (1..=NEWEST).contains(&schema) {
            Ok(Self(schema))
        } else {
            Err(format!("schema {schema} is unknown"))
        }
    }
}

/// A document of a known form. One of another form need not decode: then its number is the reason.
fn document<T: DeserializeOwned>(
    recording: &Recording,
    name: &'static str,
    known: u32,
) -> Result<T, CheckerError> {
    #[derive(Deserialize)]
    struct Head {
        schema: u32,
    }
    let data = &recording.attachment(name).ok_or(CheckerError::Missing { name })?.data;
    serde_json::from_slice(data).map_err(|source| match serde_json::from_slice(data) {
        Ok(Head { schema }) if !(1..=known).contains(&schema) => {
            CheckerError::UnknownSchema { name, found: schema, known }
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
        let mut joints: Vec<&str> = self.robot.joints.iter().map(|joint| joint.name.as_str()).collect();
        joints.sort_unstable();
        if let Some(twice) = joints.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(format!("two joints are named {}", twice[0]));
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
    fn phase_at(&self, time: f64) -> usize {
        self.phases.partition_point(|phase| phase.end <= time).min(self.phases.len() - 1)
    }

    /// The phase in the middle of an interval, and from when to when it lasts, s: from the end of the one
    /// before, and the last to the end of the plan.
    pub(crate) fn phase(&self, [start, end]: [f64; 2]) -> (usize, [f64; 2]) {
        let phase = self.phase_at(0.5 * (start + end));
        let from = if phase == 0 { 0.0 } else { self.phases[phase - 1].end };
        let until = if phase + 1 == self.phases.len() { self.duration() } else { self.phases[phase].end };
        (phase, [from, until])
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
