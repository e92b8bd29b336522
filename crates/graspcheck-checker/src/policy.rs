//! How far two bodies must keep apart in each phase, and how deep those that may touch may overlap.
//!
//! Only the object may touch anything. With respect to it, and where no rule stands below, the clearance
//! that the cell asks for holds:
//!
//! | object | a finger | the palm (last link) | what it stands on | other fixed bodies |
//! |---|---|---|---|---|
//! | stands | | | as near as it stands, or 0 if that is more | 0 |
//! | … and the gripper comes, is there or leaves | [`NEAR_CONTACT`]*, or [`GRIP_DEPTH`] while it grips | [`NEAR_CONTACT`]* | the same | 0 |
//! | is held | [`GRIP_DEPTH`] | [`NEAR_CONTACT`]* | | |
//! | … and leaves or reaches what it stands on | [`GRIP_DEPTH`] | [`NEAR_CONTACT`]* | as near as it stands, or the clearance if that is less | |
//!
//! *unless a rule of the cell names the two, which then holds. Wherever the object stands, [`STAND_DEPTH`] is
//! taken off for rounding of the motion.
//!
//! The gripper comes in the last phase before the fingers close and leaves in the first after they have
//! opened; the object leaves in the first phase that holds it and reaches its place in the last, if at least
//! three hold it. The base may stand on the cell like the object.

use crate::{
    closest::distance,
    documents::{Documents, Holding, Phase},
    scene::{BodyPair, Carrier, Mount, Role, Scene},
    solid::Placed,
    vector::Pose,
};

/// Gripper and object keep this far apart just before they touch and after, m.
const NEAR_CONTACT: f64 = 2e-4;

/// A finger that grips may overlap the object by this, m.
const GRIP_DEPTH: f64 = 5e-4;

/// The object stands on what is below it and nearer than this, m.
const STAND_REACH: f64 = 1.1e-3;

/// … and does not overlap it by more than this, m.
const STAND_DEPTH: f64 = 2e-5;

/// Where the object is in one phase, and what that allows.
pub(crate) struct Stage {
    pub(crate) object: Option<Mount>,
    /// The pads stop at this opening, m: the object's width while it is between them.
    pub(crate) least_opening: f64,
    is_held: bool,
    is_gripped: bool,
    gripper_is_near: bool,
    /// The bodies of the cell that it stands on, leaves or reaches, and how far below it they lie, m: bounds,
    /// which differ only where there is no gravity.
    supports: Vec<(usize, [f64; 2])>,
}

/// A distance that a pair must keep, m: not exact only where there is no gravity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Required {
    pub(crate) least: f64,
    pub(crate) most: f64,
}

impl Required {
    fn exactly(distance: f64) -> Self {
        Self { least: distance, most: distance }
    }
}

impl Stage {
    /// The stage of a phase, by its index; a plan that moves the object has a grasp.
    pub(crate) fn of(scene: &Scene, documents: &Documents, phase: usize) -> Self {
        let Documents { resolved, plan, .. } = documents;
        let holding = plan.phases[phase].holding;
        let differs = |other: usize| plan.phases.get(other).is_some_and(|other| other.holding != holding);
        let is_held = holding == Holding::Held;
        // Two phases that hold the object, or one, do not carry it clear of anything: neither is excused.
        let held = |phase: &&Phase| phase.holding == Holding::Held;
        let held_before = plan.phases[..phase].iter().rev().take_while(held).count();
        let held_from_here = plan.phases[phase..].iter().take_while(held).count();
        let excused = !is_held || held_before + held_from_here >= 3;
        let (begins, ends) = (excused && phase > 0 && differs(phase - 1), excused && differs(phase + 1));
        let is_gripped = is_held || matches!(holding, Holding::Closing | Holding::Opening);
        let comes_or_leaves = (holding == Holding::AtStart && ends) || (holding == Holding::Placed && begins);
        let width = plan.grasp.as_ref().map_or(0.0, |grasp| grasp.width);
        let mut stage = Self {
            object: None,
            least_opening: if is_gripped { width } else { 0.0 },
            is_held,
            is_gripped,
            gripper_is_near: is_gripped || comes_or_leaves,
            supports: Vec::new(),
        };
        let Some(object) = &resolved.object else { return stage };
        let start = object.world_from_object;
        let placed = plan.grasp.as_ref().map(|grasp| grasp.world_from_placed);
        let in_tool = plan.grasp.as_ref().map(|grasp| resolved.robot.link_from_tool * grasp.tool_from_object);
        let is_placed = matches!(holding, Holding::Opening | Holding::Placed);
        let (carrier, pose) = match (in_tool, placed) {
            (Some(in_tool), _) if is_held => (Carrier::Link(resolved.robot.links.len() - 1), in_tool),
            (_, Some(placed)) if is_placed => (Carrier::World, placed),
            _ => (Carrier::World, start),
        };
        stage.object = Some(Mount { carrier, carrier_from_body: pose });
        let stands_at = match (is_held, placed) {
            (false, _) => vec![pose],
            (true, Some(placed)) => {
                [(begins, start), (ends, placed)].iter().filter(|it| it.0).map(|it| it.1).collect()
            }
            (true, None) => vec![],
        };
        for world_from_object in stands_at {
            stage.supports.extend(supports(scene, documents, world_from_object));
        }
        stage
    }

    /// More than any two solids must ever keep apart, m.
    pub(crate) fn most_required(documents: &Documents) -> f64 {
        let clearance = &documents.resolved.cell.clearance;
        let rules = clearance.pairs.iter().map(|rule| rule.required);
        rules.chain([clearance.required, NEAR_CONTACT]).fold(STAND_REACH, f64::max)
    }

    /// What carries a body in this phase, and how.
    pub(crate) fn mount(&self, scene: &Scene, body: usize) -> Mount {
        let body = &scene.bodies[body];
        self.object.filter(|_| body.role == Role::Object).unwrap_or(body.mount)
    }

    /// How far the two bodies of a pair must keep apart, m; negative where they may overlap.
    pub(crate) fn required(&self, scene: &Scene, pair: &BodyPair) -> Required {
        let clearance = Required::exactly(pair.clearance);
        match (scene.bodies[pair.a].role, scene.bodies[pair.b].role) {
            (Role::Object, _) => {}
            (Role::Base, Role::Cell) => return Required::exactly(-STAND_DEPTH),
            _ => return clearance,
        }
        match scene.bodies[pair.b].role {
            Role::Finger(_) if self.is_gripped => Required::exactly(-GRIP_DEPTH),
            _ if scene.is_gripper(pair.b) && self.gripper_is_near && !pair.is_named => {
                Required::exactly(NEAR_CONTACT)
            }
            Role::Base | Role::Cell => {
                let supports = self.supports.iter().filter(|(body, _)| *body == pair.b).map(|(_, gap)| *gap);
                // Of two places on one body the nearer counts.
                match (supports.reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1])]), self.is_held) {
                    (Some(gap), held) => {
                        let near = |gap: f64| {
                            if held {
                                pair.clearance.min(gap - STAND_DEPTH)
                            } else {
                                gap.min(0.0) - STAND_DEPTH
                            }
                        };
                        Required { least: near(gap[0]), most: near(gap[1]) }
                    }
                    (None, true) => clearance,
                    (None, false) => Required::exactly(0.0),
                }
            }
            _ => clearance,
        }
    }
}

/// The bodies of the cell that the object stands on at a pose, and how far below it they lie, m.
fn supports(scene: &Scene, documents: &Documents, world_from_object: Pose) -> Vec<(usize, [f64; 2])> {
    let Some(object) = &documents.resolved.object else { return Vec::new() };
    let object = Placed { solid: &object.shape, world_from_solid: world_from_object };
    let gravity = documents.resolved.cell.gravity;
    let support = |(index, body): (usize, &crate::scene::Body)| {
        let (body_from_solid, solid) = *body.parts.first().filter(|_| body.role == Role::Cell)?;
        let cell = Placed { solid, world_from_solid: body.mount.carrier_from_body * body_from_solid };
        let apart = distance(&object, &cell);
        let below = if gravity.length() > 0.0 {
            let down = gravity * (1.0 / gravity.length());
            [crate::motion::slab(&object, &cell, down); 2]
        } else {
            apart
        };
        let stands = apart[1] <= STAND_REACH && below[1] >= -STAND_DEPTH && below[0] <= STAND_REACH;
        stands.then_some((index, below))
    };
    scene.bodies.iter().enumerate().filter_map(support).collect()
}

#[cfg(test)]
impl Stage {
    pub(crate) fn without_object() -> Self {
        Self {
            object: None,
            least_opening: 0.0,
            is_held: false,
            is_gripped: false,
            gripper_is_near: false,
            supports: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;
    use crate::fixture::{at, boxed, gantry, plan, read};

    /// What the cube must keep in each phase from a body, m.
    fn required_of(resolved: &Value, holdings: &[&str], body: &str) -> Vec<f64> {
        let certificate = read(json!({"schema": 1, "duration": 0.0, "pairs": []}));
        let (resolved, plan) = (read(resolved.clone()), read(plan(holdings)));
        let documents = Documents { resolved, plan, certificate, limits: None };
        let scene = Scene::new(&documents.resolved);
        let is_it =
            |pair: &&BodyPair| scene.bodies[pair.a].name == "cube" && scene.bodies[pair.b].name == body;
        let pair = scene.pairs.iter().find(is_it).expect("the cube is judged against every body");
        let required = |phase| {
            let Required { least, most } = Stage::of(&scene, &documents, phase).required(&scene, pair);
            assert!((most - least).abs() < 1e-8);
            least
        };
        (0..holdings.len()).map(required).collect()
    }

    fn assert_close(found: &[f64], expected: &[f64]) {
        let is_close = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(found.len() == expected.len() && is_close, "{found:?} is not {expected:?}");
    }

    const PICK: [&str; 9] =
        ["at_start", "at_start", "closing", "held", "held", "held", "opening", "placed", "placed"];
    const RULES: f64 = 0.002;

    #[test]
    fn the_gripper_may_touch_while_it_grips_and_comes_near_just_before() {
        let (near, grip) = (NEAR_CONTACT, -GRIP_DEPTH);
        let finger = [RULES, near, grip, grip, grip, grip, grip, near, RULES];
        assert_close(&required_of(&gantry(), &PICK, "left"), &finger);
        let palm = [RULES, near, near, near, near, near, near, near, RULES];
        assert_close(&required_of(&gantry(), &PICK, "hand"), &palm);
        // Another link is none of the gripper.
        assert_close(&required_of(&gantry(), &PICK, "carriage"), &[RULES; 9]);
    }

    #[test]
    fn a_rule_that_names_the_two_replaces_the_approach_but_not_the_grip() {
        let mut resolved = gantry();
        let rule = |a: &str, b: &str, required: f64| json!({"a": a, "b": b, "required": required});
        resolved["cell"]["clearance"]["pairs"] =
            json!([rule("robot", "cube", 0.009), rule("cube", "gripper", 0.006)]);
        let grip = -GRIP_DEPTH;
        let finger = [0.006, 0.006, grip, grip, grip, grip, grip, 0.006, 0.006];
        assert_close(&required_of(&resolved, &PICK, "left"), &finger);
        assert_close(&required_of(&resolved, &PICK, "hand"), &[0.006; 9]);
        assert_close(&required_of(&resolved, &PICK, "bridge"), &[0.009; 9]);
        // A name counts more than a group, and among equals the larger clearance.
        resolved["cell"]["clearance"]["pairs"] =
            json!([rule("cube", "gripper", 0.006), rule("left", "cube", 0.001), rule("cube", "left", 0.0)]);
        assert_close(&required_of(&resolved, &PICK, "left")[..2], &[0.001; 2]);
    }

    #[test]
    fn the_cube_stands_on_the_table_leaves_it_and_comes_down_a_millimetre_above() {
        let stands = -STAND_DEPTH;
        let leaves = [stands, stands, stands, stands, RULES, 0.001 + stands, stands, stands, stands];
        assert_close(&required_of(&gantry(), &PICK, "table"), &leaves);
        // Where no phase carries it clear, none is excused.
        let once = ["closing", "held", "opening"];
        assert_close(&required_of(&gantry(), &once, "table"), &[stands, RULES, stands]);
        let twice = ["closing", "held", "held", "opening"];
        assert_close(&required_of(&gantry(), &twice, "table"), &[stands, RULES, RULES, stands]);
        // A plan that begins with the object in the gripper never leaves anything.
        assert_close(&required_of(&gantry(), &["held", "held"], "table"), &[RULES; 2]);
        assert_close(&required_of(&gantry(), &["nothing"], "table"), &[stands]);
    }

    #[test]
    fn what_is_beside_above_or_deep_below_is_no_support() {
        let with = |shape: Value, place: Value| {
            let mut resolved = gantry();
            let body = json!({"name": "body", "shape": shape, "world_from_shape": place});
            resolved["cell"]["bodies"].as_array_mut().expect("a list").push(body);
            required_of(&resolved, &["at_start", "closing", "held", "held", "held", "opening"], "body")
        };
        let other = [0.0, 0.0, RULES, RULES, RULES, 0.0];
        let plate = || boxed(0.02, 0.02, 0.01);
        // Beside, touching; above; at the table's height but far away; below, but 1.2 mm deep.
        assert_close(&with(plate(), at(-0.04, 0.0, 0.02)), &other);
        assert_close(&with(plate(), at(0.0, 0.0, 0.05)), &other);
        assert_close(&with(plate(), at(0.3, 0.3, -0.01)), &other);
        assert_close(&with(plate(), at(0.0, 0.0, -0.011_2)), &other);
        let high = with(plate(), at(0.0, 0.0, -0.010_5));
        assert_close(&high, &[-STAND_DEPTH, -STAND_DEPTH, 5e-4 - STAND_DEPTH, RULES, RULES, 0.0]);
        // It stands in the table by 0.01 mm, which is allowed, or by 0.03 mm, which is not.
        let deep = |depth: f64| with(plate(), at(0.0, 0.0, -0.01 + depth));
        assert_close(&deep(1e-5)[..1], &[-1e-5 - STAND_DEPTH]);
        assert_close(&deep(3e-5)[..1], &[0.0]);
    }

    #[test]
    fn without_gravity_everything_that_touches_holds() {
        let mut resolved = gantry();
        resolved["cell"]["gravity"] = json!([0.0, 0.0, 0.0]);
        let above = json!({"name": "roof", "shape": boxed(0.1, 0.1, 0.01), "world_from_shape": at(0.0, 0.0, 0.050_5)});
        resolved["cell"]["bodies"].as_array_mut().expect("a list").push(above);
        let required = required_of(&resolved, &["closing", "held", "held", "held", "opening"], "roof");
        let expected = [-STAND_DEPTH, 5e-4 - STAND_DEPTH, RULES, RULES, 0.0];
        assert!(required.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-8), "{required:?}");
    }
}
