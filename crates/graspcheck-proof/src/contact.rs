//! What is required of each pair while the object stands, is grasped, held, released: which bodies may
//! touch, why, and how deep.
//!
//! | object | finger – object | palm – object | object – support | object – other cell |
//! |---|---|---|---|---|
//! | stands, fingers open | [`APPROACH_MARGIN`] | [`APPROACH_MARGIN`] | may touch | must not overlap |
//! | fingers close or open | may touch | [`APPROACH_MARGIN`] | may touch | must not overlap |
//! | held | may touch | [`APPROACH_MARGIN`] | may touch | clearance of the rules |
//!
//! A rule that names the pair replaces [`APPROACH_MARGIN`]; the palm is the last link. What may touch may
//! overlap by [`DEPTH_LIMIT`] and no more, and that is proved like a clearance: dragging the object through
//! the table is found. All other pairs keep the clearance of the rules at all times.

use graspcheck_model::{
    Pose,
    plan::{Holding, Plan},
};
use serde::{Deserialize, Serialize};

use crate::{
    chain::{Carrier, Mount},
    gap,
    scene::{Kind, Scene},
    solid::{Place, Placed},
};

/// How far gripper and object keep apart until their contact is due, m, unless a rule names the pair: more
/// than a simulated arm's tracking error at rest, less than the free opening of any gripper here.
pub const APPROACH_MARGIN: f64 = 2e-4;

/// How deep bodies that may touch may overlap in the plan, m: more than poses of a planner that interpolates
/// to 10 µm and a stiff contact's sink-in, less than anything a user would call a collision.
pub const DEPTH_LIMIT: f64 = 5e-4;

/// A body of the cell supports the object where it stands when the two are nearer than this, m: plans put
/// things down up to 1 mm above their support, and that number is rounded. Overlapping counts as near.
pub const SUPPORT_REACH: f64 = 1.1e-3;

/// Why two bodies may touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Contact {
    /// The object stands on a body of the cell at the start or where it is put down.
    Support,
    /// The fingers hold the object.
    Grip,
}

impl Contact {
    /// The reason as part of a sentence: `cube - table: the object stands on it`.
    #[must_use]
    pub fn reason(self) -> &'static str {
        match self {
            Self::Support => "the object stands on it at the start or at its place",
            Self::Grip => "the fingers hold the object",
        }
    }
}

/// What is required of a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Requirement {
    /// Least signed distance, m; `-DEPTH_LIMIT` when the pair may touch.
    pub(crate) required: f64,
    pub(crate) contact: Option<Contact>,
    /// The first arm joint that moves the two against each other.
    pub(crate) first_joint: usize,
    /// Whether both stand still in the world.
    pub(crate) fixed: bool,
}

/// The scene during one kind of [`Holding`].
#[derive(Clone, Debug)]
pub(crate) struct Stage {
    /// How the object is mounted, if there is one.
    pub(crate) object: Option<Mount>,
    /// Its place, if it stands.
    pub(crate) object_place: Option<Place>,
    /// For each of [`Scene::pairs`].
    pub(crate) requirements: Vec<Requirement>,
    /// The pads stop here, m: at the object's width while it is between them, else at 0.
    pub(crate) opening_min: f64,
}

impl Stage {
    /// The scene while the object is held so.
    ///
    /// # Errors
    /// Says in words what the plan lacks.
    pub(crate) fn new(scene: &Scene, plan: &Plan, holding: Holding) -> Result<Self, String> {
        let grasp = plan.grasp.as_ref();
        let due = matches!(holding, Holding::Closing | Holding::Held | Holding::Opening);
        let opening_min = match grasp {
            Some(grasp) if due => grasp.width,
            _ => 0.0,
        };
        let mut stage = Self { object: None, object_place: None, requirements: Vec::new(), opening_min };
        let mut supports = Vec::new();
        if let (Some(object), Some(part)) = (&scene.object, scene.object_part) {
            let no_grasp = || format!("object {}: the plan moves it but has no grasp", object.name);
            let start = object.world_from_object;
            let placed = grasp.map(|grasp| grasp.world_from_placed);
            let last = Carrier::Link(scene.robot.dof() - 1);
            let (carrier, carrier_from_object) = match holding {
                Holding::Nothing | Holding::AtStart | Holding::Closing => (Carrier::World, start),
                Holding::Held => {
                    let tool_from_object = grasp.ok_or_else(no_grasp)?.tool_from_object;
                    (last, scene.robot.link_from_tool * tool_from_object)
                }
                Holding::Opening | Holding::Placed => (Carrier::World, placed.ok_or_else(no_grasp)?),
            };
            stage.stand_object(scene, part, carrier, carrier_from_object);
            supports = match holding {
                Holding::Nothing | Holding::AtStart | Holding::Closing => supports_at(scene, part, &start),
                Holding::Opening | Holding::Placed => supports_at(scene, part, &carrier_from_object),
                Holding::Held => {
                    let mut both = supports_at(scene, part, &start);
                    both.extend(placed.map(|pose| supports_at(scene, part, &pose)).unwrap_or_default());
                    both
                }
            };
        }
        stage.require(scene, holding, &supports);
        Ok(stage)
    }

    /// Mounts the object; a measured pose can take the place of the planned one.
    pub(crate) fn stand_object(&mut self, scene: &Scene, part: usize, carrier: Carrier, pose: Pose) {
        let part = &scene.parts[part];
        let carrier_from_solid = pose * part.body_from_solid;
        self.object_place = (carrier == Carrier::World).then(|| Place::from(&carrier_from_solid));
        self.object = Some(Mount::new(&scene.robot, &part.solid, carrier, carrier_from_solid));
    }

    fn require(&mut self, scene: &Scene, holding: Holding, supports: &[usize]) {
        let due = matches!(holding, Holding::Closing | Holding::Held | Holding::Opening);
        self.requirements.reserve_exact(scene.pairs.len());
        for pair in &scene.pairs {
            let bodies = &scene.body_pairs[pair.bodies];
            let (kind_a, kind_b) = (scene.bodies[bodies.a].kind, scene.bodies[bodies.b].kind);
            let (carrier_a, carrier_b) =
                (self.mount(scene, pair.a).carrier, self.mount(scene, pair.b).carrier);
            let fixed = carrier_a == Carrier::World && carrier_b == Carrier::World;
            let (required, contact) = match (kind_a, kind_b) {
                (Kind::Object, Kind::Cell) if supports.contains(&bodies.b) => {
                    (-DEPTH_LIMIT, Some(Contact::Support))
                }
                // What does not move cannot come nearer; it must not overlap.
                (Kind::Object, _) if fixed => (0.0, None),
                (Kind::Object, Kind::Finger(_)) if due => (-DEPTH_LIMIT, Some(Contact::Grip)),
                (Kind::Object, _)
                    if scene.is_gripper(bodies.b) && holding != Holding::Nothing && !bodies.named =>
                {
                    (APPROACH_MARGIN, None)
                }
                _ => (bodies.required, None),
            };
            let joints = |carrier: Carrier| carrier.arm_joints(scene.robot.dof());
            let first_joint = joints(carrier_a).min(joints(carrier_b));
            self.requirements.push(Requirement { required, contact, first_joint, fixed });
        }
    }

    /// How a part is mounted during this stage.
    pub(crate) fn mount<'s>(&'s self, scene: &'s Scene, part: usize) -> &'s Mount {
        match &self.object {
            Some(mount) if scene.object_part == Some(part) => mount,
            _ => &scene.parts[part].mount,
        }
    }
}

/// The bodies of the cell that support the object when it stands at a pose.
fn supports_at(scene: &Scene, part: usize, world_from_object: &Pose) -> Vec<usize> {
    let object = &scene.parts[part];
    let place = Place::from(&(world_from_object * object.body_from_solid));
    let object = Placed { solid: &object.solid, place };
    let is_near = |body: &usize| {
        let part = &scene.parts[scene.bodies[*body].first_part];
        let Some(place) = part.place else { return false };
        let cell = Placed { solid: &part.solid, place };
        let reach = object.solid.bounding_radius() + cell.solid.bounding_radius() + SUPPORT_REACH;
        (object.place.center - cell.place.center).norm() <= reach
            && gap::separation(&object, &cell, None, gap::FINEST_TOLERANCE)
                .is_some_and(|known| known.upper <= SUPPORT_REACH)
    };
    (0..scene.bodies.len()).filter(|&body| scene.bodies[body].kind == Kind::Cell).filter(is_near).collect()
}

/// What is required of two bodies during one phase, or why nothing is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RequiredPair {
    /// Name of the phase; none for pairs of the robot that are never judged.
    pub phase: Option<String>,
    /// Name of one body.
    pub a: String,
    /// Name of the other.
    pub b: String,
    /// Least signed distance, m: negative, the deepest overlap, for bodies that may touch. None for bodies
    /// that are not judged.
    pub required: Option<f64>,
    /// Why they may touch or are not judged; none for ordinary pairs.
    pub reason: Option<String>,
}

impl Scene {
    /// What is required of every pair of bodies in every phase of a plan, and which pairs of the robot are
    /// not judged. A phase for which the plan lacks data is left out; [`Scene::certify`] says so.
    #[must_use]
    pub fn pairs(&self, plan: &Plan) -> Vec<RequiredPair> {
        let mut all = Vec::new();
        let name = |body: usize| self.bodies[body].name.clone();
        for a in 0..self.bodies.len() {
            for b in a + 1..self.bodies.len() {
                let of_robot = |body: usize| !matches!(self.bodies[body].kind, Kind::Object | Kind::Cell);
                if of_robot(a) && of_robot(b) {
                    let reason = self.excuse(a, b);
                    let pair = RequiredPair { phase: None, a: name(a), b: name(b), required: None, reason };
                    all.extend(pair.reason.is_some().then_some(pair));
                }
            }
        }
        for phase in &plan.phases {
            let Ok(stage) = Stage::new(self, plan, phase.holding) else { continue };
            let mut last = None;
            for (pair, requirement) in self.pairs.iter().zip(&stage.requirements) {
                // All parts of two bodies are alike in this.
                if last.replace(pair.bodies) == Some(pair.bodies) {
                    continue;
                }
                let bodies = &self.body_pairs[pair.bodies];
                all.push(RequiredPair {
                    phase: Some(phase.name.clone()),
                    a: name(bodies.a),
                    b: name(bodies.b),
                    required: Some(requirement.required),
                    reason: requirement.contact.map(|contact| contact.reason().to_owned()),
                });
            }
        }
        all
    }
}
