//! What is required of each pair while the object stands, is grasped, held, released: which bodies may
//! touch, why, and how deep.
//!
//! | object | finger – object | palm – object | object – support | object – other cell |
//! |---|---|---|---|---|
//! | stands, gripper far | rules | rules | stands on it | must not overlap |
//! | stands, gripper comes or leaves | [`APPROACH_MARGIN`] | [`APPROACH_MARGIN`] | stands on it | must not overlap |
//! | fingers close or open | may touch | [`APPROACH_MARGIN`] | stands on it | must not overlap |
//! | held, leaves or reaches its support | may touch | [`APPROACH_MARGIN`] | no nearer than where it stands | rules |
//! | held otherwise | may touch | [`APPROACH_MARGIN`] | rules | rules |
//!
//! "Rules" is the clearance that the cell asks for. The gripper comes in the last phase before it closes and
//! leaves in the first after it has opened; the object leaves its support in the first phase that holds it
//! and reaches the next one in the last. Only there may it be nearer to a support than the rules say, and no
//! nearer than it stands at rest: an object that is dragged or carried along just above a bench is found when
//! that phase ends, for then the rules hold. Where fewer than three phases hold the object none of them carries it
//! clear, and nothing is excused.
//!
//! A rule that names the pair replaces [`APPROACH_MARGIN`], for its reason says why; the palm is the last
//! link. What may touch may overlap by [`DEPTH_LIMIT`] when it is executed.
//! The base may stand on the cell and overlap it no more than an object may.
//! All other pairs keep the clearance of the rules at all times.

use graspcheck_model::{
    Pose,
    plan::{Holding, Phase, Plan},
};
use serde::{Deserialize, Serialize};

use crate::{
    bounds::Bounds,
    chain::{Carrier, Mount},
    gap,
    scene::{Kind, PartPair, Scene},
    solid::{Place, Placed},
};

/// How far gripper and object keep apart just before their contact is due and after it has ended, m, unless
/// a rule names the pair: more than a simulated arm's tracking error at rest, less than the free opening of
/// any gripper here.
pub const APPROACH_MARGIN: f64 = 2e-4;

/// How deep bodies that may touch may overlap when they do, m: more than a stiff contact's sink-in, less than
/// anything a user would call a collision.
pub const DEPTH_LIMIT: f64 = 5e-4;

/// A body of the cell below the object supports it where it stands when the two are nearer than this, m:
/// plans put things down up to 1 mm above their support, and that number is rounded.
pub const SUPPORT_REACH: f64 = 1.1e-3;

/// What stands on a support may overlap it, and be nearer to it on its way there, by no more than this, m:
/// twice what a straight move may leave its line.
pub const SUPPORT_OVERLAP: f64 = 2e-5;

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
    /// Least signed distance, m; negative when the pair may touch.
    pub(crate) required: f64,
    pub(crate) contact: Option<Contact>,
    /// The first arm joint that moves the two against each other.
    pub(crate) first_joint: usize,
    /// Whether both stand still in the world.
    pub(crate) fixed: bool,
}

impl Requirement {
    /// Whether the pair counts when the least margin is looked for.
    pub(crate) fn counts(&self) -> bool {
        self.contact.is_none() && !self.fixed
    }
}

/// What a phase is for, as far as contacts go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Occasion {
    pub(crate) holding: Holding,
    /// The phase before has another holding.
    begins: bool,
    /// The phase after has another holding.
    ends: bool,
}

impl Occasion {
    /// Of a phase of the plan, by its index.
    pub(crate) fn of(plan: &Plan, phase: usize) -> Self {
        let holding = plan.phases[phase].holding;
        let differs = |other: Option<usize>| {
            other.and_then(|other| plan.phases.get(other)).is_some_and(|other| other.holding != holding)
        };
        let (mut begins, mut ends) = (differs(phase.checked_sub(1)), differs(Some(phase + 1)));
        if holding == Holding::Held && !carries_between(plan, phase) {
            (begins, ends) = (false, false);
        }
        Self { holding, begins, ends }
    }

    /// Whether the fingers may touch the object.
    fn grips(self) -> bool {
        matches!(self.holding, Holding::Closing | Holding::Held | Holding::Opening)
    }

    /// Whether the gripper is, comes or was just now at the object.
    fn is_at_the_object(self) -> bool {
        self.grips()
            || (self.holding == Holding::AtStart && self.ends)
            || (self.holding == Holding::Placed && self.begins)
    }
}

/// Whether the phases that hold the object around this one are at least three: one takes it off, one sets it
/// down, and at least one between them keeps it clear of everything.
fn carries_between(plan: &Plan, phase: usize) -> bool {
    let is_held = |phase: &&Phase| phase.holding == Holding::Held;
    let before = plan.phases[..phase].iter().rev().take_while(is_held).count();
    let after = plan.phases[phase..].iter().take_while(is_held).count();
    before + after >= 3
}

/// The scene on one [`Occasion`].
#[derive(Clone, Debug)]
pub(crate) struct Stage {
    /// How the object is mounted, if there is one.
    pub(crate) object: Option<Mount>,
    occasion: Occasion,
    /// What carries the object then.
    supports: Vec<Support>,
    /// The pads stop here, m: at the object's width while it is between them, else at 0.
    pub(crate) opening_min: f64,
}

impl Stage {
    /// The scene while the object is held so.
    ///
    /// # Errors
    /// Says in words what the plan lacks.
    pub(crate) fn new(scene: &Scene, plan: &Plan, occasion: Occasion) -> Result<Self, String> {
        let grasp = plan.grasp.as_ref();
        let opening_min = match grasp {
            Some(grasp) if occasion.grips() => grasp.width,
            _ => 0.0,
        };
        let mut stage = Self { object: None, occasion, supports: Vec::new(), opening_min };
        if let (Some(object), Some(part)) = (&scene.object, scene.object_part) {
            let no_grasp = || format!("object {}: the plan moves it but has no grasp", object.name);
            let start = object.world_from_object;
            let placed = grasp.map(|grasp| grasp.world_from_placed);
            let last = Carrier::Link(scene.robot.dof() - 1);
            let (carrier, carrier_from_object) = match occasion.holding {
                Holding::Nothing | Holding::AtStart | Holding::Closing => (Carrier::World, start),
                Holding::Held => {
                    let tool_from_object = grasp.ok_or_else(no_grasp)?.tool_from_object;
                    (last, scene.robot.link_from_tool * tool_from_object)
                }
                Holding::Opening | Holding::Placed => (Carrier::World, placed.ok_or_else(no_grasp)?),
            };
            stage.stand_object(scene, part, carrier, carrier_from_object);
            match occasion.holding {
                Holding::Held => {
                    if occasion.begins {
                        stage.supports.extend(supports_at(scene, part, &start));
                    }
                    if let (true, Some(placed)) = (occasion.ends, placed) {
                        stage.supports.extend(supports_at(scene, part, &placed));
                    }
                }
                _ => stage.supports.extend(supports_at(scene, part, &carrier_from_object)),
            }
        }
        Ok(stage)
    }

    /// Mounts the object; a measured pose can take the place of the planned one.
    pub(crate) fn stand_object(&mut self, scene: &Scene, part: usize, carrier: Carrier, pose: Pose) {
        let part = &scene.parts[part];
        let carrier_from_solid = pose * part.body_from_solid;
        self.object = Some(Mount::new(&scene.robot, &part.solid, carrier, &carrier_from_solid));
    }

    /// What is required of a pair of parts.
    pub(crate) fn requirement(&self, scene: &Scene, pair: &PartPair) -> Requirement {
        let bodies = &scene.body_pairs[pair.bodies];
        let (kind_a, kind_b) = (scene.bodies[bodies.a].kind, scene.bodies[bodies.b].kind);
        let (carrier_a, carrier_b) = (self.mount(scene, pair.a).carrier, self.mount(scene, pair.b).carrier);
        let fixed = carrier_a == Carrier::World && carrier_b == Carrier::World;
        let is_object = kind_a == Kind::Object;
        let touches_gripper = is_object && scene.is_gripper(bodies.b);
        let (required, contact) = match self.stands(bodies.b).filter(|_| is_object) {
            Some(gap) if fixed => (gap.min(0.0) - SUPPORT_OVERLAP, Some(Contact::Support)),
            Some(gap) => (bodies.required.min(gap - SUPPORT_OVERLAP), Some(Contact::Support)),
            // What does not move cannot come nearer; it must not overlap. The base may stand on the cell.
            None if is_object && fixed => (0.0, None),
            None if kind_a == Kind::Base && kind_b == Kind::Cell => (-SUPPORT_OVERLAP, None),
            None if touches_gripper && self.occasion.grips() && matches!(kind_b, Kind::Finger(_)) => {
                (-DEPTH_LIMIT, Some(Contact::Grip))
            }
            None if touches_gripper && self.occasion.is_at_the_object() && !bodies.named => {
                (APPROACH_MARGIN, None)
            }
            None => (bodies.required, None),
        };
        let joints = |carrier: Carrier| carrier.arm_joints(scene.robot.dof());
        let first_joint = joints(carrier_a).min(joints(carrier_b));
        Requirement { required, contact, first_joint, fixed }
    }

    /// How far a body lies below the object that it supports, m; none when it does not. Of two supports that
    /// are one body, where the object stands and where it is put, the nearer counts.
    fn stands(&self, body: usize) -> Option<f64> {
        let below = self.supports.iter().filter(|support| support.body == body).map(|support| support.gap);
        below.min_by(f64::total_cmp)
    }

    /// How a part is mounted during this stage.
    pub(crate) fn mount<'s>(&'s self, scene: &'s Scene, part: usize) -> &'s Mount {
        match &self.object {
            Some(mount) if scene.object_part == Some(part) => mount,
            _ => &scene.parts[part].mount,
        }
    }
}

/// The scene on every occasion that a plan has.
#[derive(Clone, Debug)]
pub(crate) struct Stages {
    stages: Vec<Stage>,
    /// For each phase of the plan, the index of its stage.
    of_phase: Vec<usize>,
}

impl Stages {
    /// # Errors
    /// Says in words what the plan lacks.
    pub(crate) fn new(scene: &Scene, plan: &Plan) -> Result<Self, String> {
        let mut occasions: Vec<Occasion> = Vec::with_capacity(plan.phases.len());
        let mut stages = Vec::with_capacity(plan.phases.len());
        let mut of_phase = Vec::with_capacity(plan.phases.len());
        for phase in 0..plan.phases.len() {
            let occasion = Occasion::of(plan, phase);
            let known = occasions.iter().position(|known| *known == occasion);
            of_phase.push(known.unwrap_or(stages.len()));
            if known.is_none() {
                occasions.push(occasion);
                stages.push(Stage::new(scene, plan, occasion)?);
            }
        }
        Ok(Self { stages, of_phase })
    }

    /// The stage of a phase, by its index in the plan.
    pub(crate) fn of(&self, phase: usize) -> &Stage {
        &self.stages[self.of_phase[phase]]
    }
}

/// A body of the cell on which the object stands.
#[derive(Clone, Copy, Debug)]
struct Support {
    /// Index into [`Scene::bodies`].
    body: usize,
    /// How far it lies below the object, m, to [`gap::GAP_SLACK`].
    gap: f64,
}

/// The bodies of the cell that support the object when it stands at a pose: those that lie below it, along
/// gravity, within [`SUPPORT_REACH`], and overlap it by no more than [`SUPPORT_OVERLAP`]. Without gravity
/// everything that touches it in this way holds it.
fn supports_at(scene: &Scene, part: usize, world_from_object: &Pose) -> Vec<Support> {
    let object = &scene.parts[part];
    let place = Place::from(&(world_from_object * object.body_from_solid));
    let object = Placed { solid: &object.solid, place };
    let mut supports = Vec::new();
    scene.near_obstacles(&Bounds::of(&object), SUPPORT_REACH, |part, _| {
        let Some(known) = gap::separation(&object, &scene.still(part), None, gap::FINEST_TOLERANCE) else {
            return;
        };
        let gap = match scene.cell_gravity.try_normalize(0.0) {
            Some(down) => gap::gap(&object, &scene.still(part), &down) + gap::GAP_SLACK,
            None => known.lower,
        };
        let stands = known.upper <= SUPPORT_REACH && (-SUPPORT_OVERLAP..=SUPPORT_REACH).contains(&gap);
        supports.extend(stands.then_some(Support { body: scene.parts[part].body, gap }));
    });
    supports
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
    /// Least signed distance in the plan, m; negative for bodies that may touch. None for bodies that are not
    /// judged.
    pub required: Option<f64>,
    /// How deep they may overlap when the plan is executed, m; none for bodies that may not touch.
    pub depth: Option<f64>,
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
                    let (a, b) = (name(a), name(b));
                    let pair = RequiredPair { phase: None, a, b, required: None, depth: None, reason };
                    all.extend(pair.reason.is_some().then_some(pair));
                }
            }
        }
        for (index, phase) in plan.phases.iter().enumerate() {
            let Ok(stage) = Stage::new(self, plan, Occasion::of(plan, index)) else { continue };
            let mut last = None;
            for pair in &self.pairs {
                // All parts of two bodies are alike in this.
                if last.replace(pair.bodies) == Some(pair.bodies) {
                    continue;
                }
                let bodies = &self.body_pairs[pair.bodies];
                let requirement = stage.requirement(self, pair);
                all.push(RequiredPair {
                    phase: Some(phase.name.clone()),
                    a: name(bodies.a),
                    b: name(bodies.b),
                    required: Some(requirement.required),
                    depth: requirement.contact.map(|_| DEPTH_LIMIT),
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
            paths: Vec::new(),
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

    /// A scene with the table and one rule.
    fn scene_with_rule(a: &str, b: &str, required: f64) -> Scene {
        use graspcheck_model::cell::PairRule;
        let mut cell = fixtures::cell(0.002, vec![("table", boxed(0.5, 0.5, 0.05), at(0.0, 0.0, -0.05))]);
        let reason = "a test".to_owned();
        cell.clearance.pairs = vec![PairRule { a: a.to_owned(), b: b.to_owned(), required, reason }];
        Scene::new(&gantry(), &cell, Some(&cube())).unwrap()
    }

    #[test]
    fn an_object_pressed_into_its_support_is_found() {
        // 10 µm is what interpolation may do.
        let pressed = |depth: f64| Pick { carry_height: GRASP_HEIGHT - depth, ..GOOD };
        let lift = |depth| violated(&scene(vec![]), &plan(&pressed(depth)));
        assert!(lift(3e-5).contains(&triple("cube", "table", "lift")));
        assert!(!lift(1e-5).contains(&triple("cube", "table", "lift")));
    }

    #[test]
    fn an_object_dragged_along_its_support_or_carried_just_above_it_is_found() {
        for height in [0.0, 1e-4, 1e-3, 1.9e-3] {
            let low = Pick { carry_height: GRASP_HEIGHT + height, ..GOOD };
            let found = violated(&scene(vec![]), &plan(&low));
            assert!(found.contains(&triple("cube", "table", "carry")), "{height}: {found:?}");
        }
        let high = Pick { carry_height: GRASP_HEIGHT + 2.1e-3, ..GOOD };
        assert_eq!(violated(&scene(vec![]), &plan(&high)), vec![]);
    }

    #[test]
    fn where_no_phase_carries_the_object_clear_nothing_excuses_its_support() {
        // As a planner leaves out moves of no length: first the lowering, then the lifting, too.
        let low = Pick { carry_height: GRASP_HEIGHT, ..GOOD };
        let mut dragged = plan(&low);
        for left in ["lower", "lift"] {
            let index = dragged.phases.iter().position(|phase| phase.name == left).unwrap();
            let gone = dragged.phases.remove(index);
            let carry = dragged.phases.iter_mut().find(|phase| phase.name == "carry").unwrap();
            (carry.start, carry.end) = (carry.start.min(gone.start), carry.end.max(gone.end));
            let found = violated(&scene(vec![]), &dragged);
            assert!(found.iter().any(|(a, b, _)| a == "cube" && b == "table"), "{left}: {found:?}");
        }
    }

    #[test]
    fn a_body_inside_the_base_is_found() {
        let mut robot = gantry();
        robot.base = fixtures::link("base", vec![(at(0.0, 0.4, 0.1), boxed(0.05, 0.05, 0.1))]);
        let judge = |top: f64| {
            let table = ("table", boxed(0.5, 0.5, 0.05), at(0.0, 0.0, top - 0.05));
            let scene = Scene::new(&robot, &fixtures::cell(0.002, vec![table]), None).unwrap();
            let still = fixtures::rest_to_rest(&[0.0, 0.0, 0.5], &[0.0, 0.0, 0.4], 1.0);
            violated(&scene, &still)
        };
        assert_eq!(judge(0.0), vec![]);
        assert!(judge(0.001).contains(&triple("base", "table", "move")));
    }

    #[test]
    fn a_rule_holds_for_the_object_and_its_support_wherever_it_can() {
        // Carried 105 mm above the table; while it is lifted and lowered the rule cannot hold.
        assert_eq!(violated(&scene_with_rule("cube", "table", 0.1), &plan(&GOOD)), vec![]);
        let found = violated(&scene_with_rule("cube", "table", 0.11), &plan(&GOOD));
        assert_eq!(found, vec![triple("cube", "table", "carry")]);
    }

    #[test]
    fn a_plate_beside_the_object_is_no_support() {
        // Its face stands at x = 0.22: where the cube's face is when it is placed.
        let plate = |inside: f64| ("plate", boxed(0.01, 0.1, 0.01), at(0.23 - inside, 0.0, 0.011));
        let found = violated(&scene(vec![plate(4e-4)]), &plan(&GOOD));
        assert!(found.contains(&triple("cube", "plate", "lower")), "{found:?}");
        let pairs = scene(vec![plate(4e-4)]).pairs(&plan(&GOOD));
        assert!(pairs.iter().filter(|pair| pair.b == "plate" && pair.a == "cube").all(|p| p.depth.is_none()));
    }

    #[test]
    fn what_stands_inside_the_table_is_not_supported_by_it() {
        let sunk = |depth: f64| {
            let table = ("table", boxed(0.5, 0.5, 0.05), at(0.0, 0.0, -0.05 + depth));
            let scene = Scene::new(&gantry(), &fixtures::cell(0.002, vec![table]), Some(&cube())).unwrap();
            violated(&scene, &plan(&GOOD))
        };
        assert!(sunk(1e-4).contains(&triple("cube", "table", "descend")));
        assert_eq!(sunk(1e-5), vec![]);
    }

    #[test]
    fn the_rules_hold_for_the_gripper_and_the_object_until_the_gripper_comes() {
        // The closed fingers pass 1 mm above the standing cube, of which 2 mm are required.
        let mut low = plan(&GOOD);
        let ramp = |a: f64, b: f64| Polynomial::quintic_hermite([a, 0.0, 0.0], [b, 0.0, 0.0], 0.5);
        let mut knots = low.trajectory.knots().to_vec();
        for knot in &mut knots {
            *knot += 0.5;
        }
        knots.insert(0, 0.0);
        // The tips are 90 mm below the hand's frame.
        let passing = 0.04 + 0.09 + 0.001;
        let swing = [ramp(0.2, 0.0), Polynomial::constant(0.0), ramp(passing, passing)];
        let joints = low.trajectory.dof();
        let mut pieces: Vec<Polynomial> = swing.to_vec();
        pieces.extend([ramp(0.0, 0.0), Polynomial::constant(0.0), ramp(passing, GRASP_HEIGHT)]);
        let pieces_after = (1..low.trajectory.knots().len() - 1).flat_map(|i| low.trajectory.piece_of_all(i));
        pieces.extend(pieces_after.copied());
        low.trajectory = Trajectory::new(joints, knots.clone(), pieces).unwrap();
        let opening: Vec<Polynomial> = std::iter::once(Polynomial::constant(0.0))
            .chain((0..knots.len() - 2).map(|i| low.opening.piece_of_all(i)[0]))
            .collect();
        low.opening = Trajectory::new(1, knots, opening).unwrap();
        for phase in &mut low.phases {
            phase.start += 0.5;
            phase.end += 0.5;
        }
        let approach = Phase { name: "approach".to_owned(), start: 0.0, end: 0.5, holding: Holding::AtStart };
        low.phases.insert(0, approach);
        let found = violated(&scene(vec![]), &low);
        assert!(found.contains(&triple("cube", "finger_left", "approach")), "{found:?}");
        assert!(!found.iter().any(|(_, _, phase)| phase == "descend"), "{found:?}");
    }

    #[test]
    fn neighbours_are_judged_unless_their_contact_is_allowed() {
        let mut robot = gantry();
        // It overlaps the hand when that is at the top.
        robot.links[1] = fixtures::link("carriage", vec![(at(0.0, 0.0, 0.32), boxed(0.01, 0.01, 0.01))]);
        let cell = fixtures::cell(0.002, vec![("table", boxed(0.5, 0.5, 0.05), at(0.0, 0.0, -0.05))]);
        let allowed = Scene::new(&robot, &cell, Some(&cube())).unwrap();
        assert_eq!(violated(&allowed, &plan(&GOOD)), vec![]);
        robot.allowed_contacts.retain(|contact| contact.b != "hand");
        let judged = Scene::new(&robot, &cell, Some(&cube())).unwrap();
        let found = violated(&judged, &plan(&GOOD));
        assert!(found.contains(&triple("carriage", "hand", "descend")), "{found:?}");
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
        assert_eq!(phases, ["lower", "open", "retreat"].map(Some));
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
        let stands = find(Some("descend"), "cube", "table");
        assert_eq!((stands.required, stands.depth), (Some(-SUPPORT_OVERLAP), Some(DEPTH_LIMIT)));
        let carried = find(Some("carry"), "cube", "table");
        assert_eq!((carried.required, carried.depth), (Some(0.002), None));
        assert_eq!(find(Some("carry"), "hand", "table").required, Some(0.002));
        let shared = find(None, "carriage", "hand");
        assert_eq!(shared.reason.as_deref(), Some("a bearing"));
    }
}
