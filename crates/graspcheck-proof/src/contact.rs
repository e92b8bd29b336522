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

#[cfg(test)]
mod tests {
    use graspcheck_model::{
        object::Object,
        plan::{Grasp, Phase},
        robot::{JointKind, RobotModel},
    };
    use graspcheck_motion::{Polynomial, Trajectory};
    use nalgebra::Vector3;

    use super::*;
    use crate::{
        certificate::{PairVerdict, ProofOutcome},
        fixtures::{self, at, boxed},
    };

    const WIDTH: f64 = 0.04;
    /// Height of the hand's frame when the tool frame is 15 mm above the middle of a cube on the table.
    const GRASP_HEIGHT: f64 = 0.095;

    /// Three slides along x, y and z with a hand at the end: every pose of it is plain.
    fn gantry() -> RobotModel {
        let slide = |name, axis| fixtures::joint(name, JointKind::Prismatic, Pose::identity(), axis);
        fixtures::robot(
            vec![slide("x", Vector3::x()), slide("y", Vector3::y()), slide("z", Vector3::z())],
            vec![
                fixtures::link("bridge", vec![]),
                fixtures::link("carriage", vec![]),
                fixtures::link("hand", vec![(Pose::identity(), boxed(0.03, 0.06, 0.02))]),
            ],
        )
    }

    fn cube() -> Object {
        Object {
            name: "cube".to_owned(),
            shape: boxed(0.02, 0.02, 0.02),
            mass: 0.1,
            friction: 0.8,
            world_from_object: at(0.0, 0.0, 0.02),
            handles: vec![],
        }
    }

    /// What differs between the plans of these tests.
    struct Pick {
        opening: f64,
        grasp_height: f64,
        carry_height: f64,
        place_height: f64,
        carry_to: f64,
    }

    const GOOD: Pick = Pick {
        opening: 0.05,
        grasp_height: GRASP_HEIGHT,
        carry_height: 0.2,
        place_height: GRASP_HEIGHT,
        carry_to: 0.2,
    };

    fn plan(pick: &Pick) -> Plan {
        let Pick { opening, grasp_height, carry_height, place_height, carry_to } = *pick;
        let squeezed = WIDTH - 0.004;
        let steps = [
            ("descend", Holding::AtStart, [0.0, 0.3], [0.0, grasp_height], [opening, opening]),
            ("close", Holding::Closing, [0.0, grasp_height], [0.0, grasp_height], [opening, squeezed]),
            ("lift", Holding::Held, [0.0, grasp_height], [0.0, carry_height], [squeezed; 2]),
            ("carry", Holding::Held, [0.0, carry_height], [carry_to, carry_height], [squeezed; 2]),
            ("lower", Holding::Held, [carry_to, carry_height], [carry_to, place_height], [squeezed; 2]),
            (
                "open",
                Holding::Opening,
                [carry_to, place_height],
                [carry_to, place_height],
                [squeezed, opening],
            ),
            ("retreat", Holding::Placed, [carry_to, place_height], [carry_to, 0.3], [opening; 2]),
        ];
        let ramp = |a: f64, b: f64| Polynomial::quintic_hermite([a, 0.0, 0.0], [b, 0.0, 0.0], 0.5);
        let knots: Vec<f64> = (0..=steps.len()).map(|i| 0.5 * i as f64).collect();
        let mut arm = Vec::new();
        let mut gripper = Vec::new();
        let mut phases = Vec::new();
        for (i, (name, holding, from, to, opening)) in steps.into_iter().enumerate() {
            arm.extend([ramp(from[0], to[0]), Polynomial::constant(0.0), ramp(from[1], to[1])]);
            gripper.push(ramp(opening[0], opening[1]));
            phases.push(Phase { name: name.to_owned(), start: knots[i], end: knots[i + 1], holding });
        }
        let world_from_tool = gantry().world_from_tool(&[0.0, 0.0, grasp_height]);
        let tool_from_object = world_from_tool.inverse() * cube().world_from_object;
        let world_from_placed = gantry().world_from_tool(&[carry_to, 0.0, place_height]) * tool_from_object;
        Plan {
            trajectory: Trajectory::new(3, knots.clone(), arm).unwrap(),
            opening: Trajectory::new(1, knots, gripper).unwrap(),
            phases,
            grasp: Some(Grasp {
                handle: "top".to_owned(),
                tool_from_object,
                width: WIDTH,
                opening,
                force: 10.0,
                world_from_start: cube().world_from_object,
                world_from_placed,
            }),
        }
    }

    fn scene(bodies: Vec<(&str, graspcheck_model::shape::Shape, Pose)>) -> Scene {
        let table = ("table", boxed(0.5, 0.5, 0.05), at(0.0, 0.0, -0.05));
        let bodies = [vec![table], bodies].concat();
        Scene::new(&gantry(), &fixtures::cell(0.002, bodies), Some(&cube())).unwrap()
    }

    /// The names of the violated pairs and the phase.
    fn violated(scene: &Scene, plan: &Plan) -> Vec<(String, String, String)> {
        let certificate = scene.certify(plan);
        let found = certificate.violations();
        found.map(|(pair, violation)| (pair.a.clone(), pair.b.clone(), violation.phase.clone())).collect()
    }

    fn triple(a: &str, b: &str, phase: &str) -> (String, String, String) {
        (a.to_owned(), b.to_owned(), phase.to_owned())
    }

    #[test]
    fn a_good_pick_is_free_and_its_margin_is_known() {
        let (scene, plan) = (scene(vec![]), plan(&GOOD));
        let certificate = scene.certify(&plan);
        assert_eq!(certificate.outcome(), ProofOutcome::Free, "{certificate:?}");
        // The fingers end 5 mm above the table, of which 2 mm are required, and stand 5 mm beside the cube.
        let least = scene.minimum_margin(&plan, 1e-6).unwrap();
        assert!((least.upper - 0.003).abs() < 1e-6 && (least.lower - 0.003).abs() < 2e-6, "{least:?}");
        assert_eq!(least.b, "table");
    }

    #[test]
    fn an_object_dragged_through_the_table_is_found_by_its_depth() {
        let shallow = Pick { carry_height: GRASP_HEIGHT - 0.000_45, ..GOOD };
        assert_eq!(violated(&scene(vec![]), &plan(&shallow)), vec![]);
        let deep = Pick { carry_height: GRASP_HEIGHT - 0.000_55, ..GOOD };
        assert_eq!(violated(&scene(vec![]), &plan(&deep)), vec![triple("cube", "table", "lift")]);
    }

    #[test]
    fn a_held_object_keeps_clear_of_what_does_not_support_it() {
        // Its foot passes 85 mm above the table, 1 mm above this wall, of which 2 mm are required.
        let wall = || ("wall", boxed(0.005, 0.1, 0.052), at(0.1, 0.0, 0.052));
        let low = Pick { carry_height: 0.18, ..GOOD };
        assert_eq!(violated(&scene(vec![wall()]), &plan(&low))[0], triple("finger_left", "wall", "carry"));
        let wall = ("wall", boxed(0.005, 0.1, 0.0435), at(0.1, 0.0, 0.0435));
        let nearer = Pick { grasp_height: 0.085 + 0.01, carry_height: 0.095 + 0.088, ..GOOD };
        assert_eq!(violated(&scene(vec![wall]), &plan(&nearer)), vec![triple("cube", "wall", "carry")]);
    }

    #[test]
    fn fingers_that_do_not_clear_the_object_on_the_way_down_are_found() {
        let narrow = Pick { opening: WIDTH + 0.000_3, ..GOOD };
        let found = violated(&scene(vec![]), &plan(&narrow));
        assert!(found.contains(&triple("cube", "finger_left", "descend")), "{found:?}");
        let enough = Pick { opening: WIDTH + 0.000_5, ..GOOD };
        assert_eq!(violated(&scene(vec![]), &plan(&enough)), vec![]);
    }

    #[test]
    fn a_rule_that_names_the_pair_replaces_the_margin_of_the_approach() {
        use graspcheck_model::cell::PairRule;
        let table = ("table", boxed(0.5, 0.5, 0.05), at(0.0, 0.0, -0.05));
        let mut cell = fixtures::cell(0.002, vec![table]);
        let rule = |a: &str, b: &str, required| PairRule {
            a: a.to_owned(),
            b: b.to_owned(),
            required,
            reason: "a test".to_owned(),
        };
        cell.clearance.pairs = vec![rule("cube", "gripper", 0.006)];
        let strict = Scene::new(&gantry(), &cell, Some(&cube())).unwrap();
        assert!(violated(&strict, &plan(&GOOD)).contains(&triple("cube", "finger_left", "descend")));
        // A rule that names the finger counts more than one that names the gripper.
        cell.clearance.pairs.push(rule("finger_left", "cube", 0.0));
        cell.clearance.pairs.push(rule("cube", "finger_right", 0.0));
        let loose = Scene::new(&gantry(), &cell, Some(&cube())).unwrap();
        assert_eq!(violated(&loose, &plan(&GOOD)), vec![]);
    }

    #[test]
    fn a_place_one_millimetre_above_a_shelf_is_supported_by_it() {
        let shelf = |top: f64| ("shelf", boxed(0.05, 0.05, 0.01), at(0.2, 0.0, top - 0.01));
        let high = Pick { place_height: GRASP_HEIGHT + 0.021, ..GOOD };
        let good = scene(vec![shelf(0.02)]);
        assert_eq!(violated(&good, &plan(&high)), vec![]);
        let support = |pair: &&RequiredPair| pair.b == "shelf" && pair.reason.is_some();
        let pairs = good.pairs(&plan(&high));
        let phases: Vec<_> = pairs.iter().filter(support).map(|pair| pair.phase.as_deref()).collect();
        assert_eq!(phases, ["lift", "carry", "lower", "open", "retreat"].map(Some));
        // 2 mm above it, it does not stand on it and is too near in the phases that hold it.
        let higher = Pick { place_height: GRASP_HEIGHT + 0.0215, ..GOOD };
        assert_eq!(violated(&good, &plan(&higher)), vec![triple("cube", "shelf", "lower")]);
    }

    #[test]
    fn an_object_put_into_a_wall_is_found() {
        let wall = ("wall", boxed(0.01, 0.1, 0.03), at(0.225, 0.0, 0.03));
        let found = violated(&scene(vec![wall]), &plan(&GOOD));
        assert!(found.contains(&triple("cube", "wall", "lower")), "{found:?}");
    }

    #[test]
    fn a_plan_that_carries_without_a_grasp_is_not_checked() {
        let mut lost = plan(&GOOD);
        lost.grasp = None;
        let certificate = scene(vec![]).certify(&lost);
        assert_eq!(certificate.outcome(), ProofOutcome::NotChecked);
        let PairVerdict::NotChecked { reason } = &certificate.pairs[0].verdict else {
            panic!("{certificate:?}")
        };
        assert_eq!(reason, "object cube: the plan moves it but has no grasp");
    }

    #[test]
    fn pairs_that_may_touch_say_why_and_how_deep() {
        let pairs = scene(vec![]).pairs(&plan(&GOOD));
        let find = |phase: Option<&str>, a: &str, b: &str| {
            pairs.iter().find(|p| p.phase.as_deref() == phase && p.a == a && p.b == b).cloned().unwrap()
        };
        let grip = find(Some("carry"), "cube", "finger_left");
        assert_eq!(grip.required, Some(-DEPTH_LIMIT));
        assert_eq!(grip.reason.as_deref(), Some("the fingers hold the object"));
        assert_eq!(find(Some("descend"), "cube", "finger_left").required, Some(APPROACH_MARGIN));
        assert_eq!(find(Some("descend"), "cube", "table").required, Some(-DEPTH_LIMIT));
        assert_eq!(find(Some("carry"), "hand", "table").required, Some(0.002));
        let shared = find(None, "carriage", "hand");
        assert_eq!(shared.reason.as_deref(), Some("they share the joint z"));
    }
}
