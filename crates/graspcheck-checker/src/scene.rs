//! All bodies, what carries them, and the pairs that must be proved.

use crate::{
    documents::{GROUPS, JointKind, Link, PlacedShape, Resolved, Robot},
    solid::Solid,
    vector::{Pose, Vector},
};

/// Axes count as parallel up to this sine of their angle: it moves nothing farther than rounding does.
const PARALLEL: f64 = 1e-12;

pub(crate) struct Scene<'d> {
    pub(crate) robot: &'d Robot,
    pub(crate) bodies: Vec<Body<'d>>,
    /// The convex parts of all bodies, one body after the other.
    pub(crate) solids: Vec<BodySolid<'d>>,
    /// The pairs of bodies that are judged.
    pub(crate) pairs: Vec<BodyPair>,
    /// Whether no revolute joint turns the axis of a joint after it.
    pub(crate) keeps_axes: bool,
}

pub(crate) struct Body<'d> {
    pub(crate) name: &'d str,
    pub(crate) role: Role,
    /// What carries it, and where it is fixed there; the object is carried by different things in turn.
    pub(crate) mount: Mount,
    /// Its convex parts, in its frame.
    pub(crate) parts: Vec<(Pose, &'d Solid)>,
    /// The index of its first part among the solids of the scene.
    pub(crate) first_solid: usize,
}

/// A convex part of a body.
pub(crate) struct BodySolid<'d> {
    pub(crate) body: usize,
    pub(crate) body_from_solid: Pose,
    pub(crate) solid: &'d Solid,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Role {
    Base,
    Link(usize),
    Finger(usize),
    Cell,
    Object,
}

/// What a body is fixed to, and how.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mount {
    pub(crate) carrier: Carrier,
    pub(crate) carrier_from_body: Pose,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Carrier {
    World,
    Link(usize),
    Finger(usize),
}

/// Two bodies, by index, that must keep apart.
pub(crate) struct BodyPair {
    pub(crate) a: usize,
    pub(crate) b: usize,
    /// The clearance that the rules of the cell ask for, m.
    pub(crate) clearance: f64,
    /// Whether a rule names the two, so that it is not the one for all.
    pub(crate) is_named: bool,
}

impl<'d> Scene<'d> {
    pub(crate) fn new(resolved: &'d Resolved) -> Self {
        let robot = &resolved.robot;
        let fixed = |carrier_from_body| Mount { carrier: Carrier::World, carrier_from_body };
        let moving = |carrier| Mount { carrier, carrier_from_body: Pose::IDENTITY };
        let link = |link: &'d Link, role, mount| {
            let part = |PlacedShape { body_from_shape, shape }: &'d PlacedShape| (*body_from_shape, shape);
            let parts = link.shapes.iter().map(part).collect();
            Body { name: &link.name, role, mount, parts, first_solid: 0 }
        };
        let whole = |name, role, mount, solid| {
            let parts = vec![(Pose::IDENTITY, solid)];
            Body { name, role, mount, parts, first_solid: 0 }
        };
        let mut bodies = vec![link(&robot.base, Role::Base, fixed(robot.world_from_base))];
        for (i, moved) in robot.links.iter().enumerate() {
            bodies.push(link(moved, Role::Link(i), moving(Carrier::Link(i))));
        }
        for (i, finger) in robot.gripper.fingers.iter().enumerate() {
            bodies.push(link(&finger.link, Role::Finger(i), moving(Carrier::Finger(i))));
        }
        for body in &resolved.cell.bodies {
            bodies.push(whole(&body.name, Role::Cell, fixed(body.world_from_shape), &body.shape));
        }
        if let Some(object) = &resolved.object {
            bodies.push(whole(&object.name, Role::Object, fixed(object.world_from_object), &object.shape));
        }
        let mut solids = Vec::new();
        for (index, body) in bodies.iter_mut().enumerate() {
            body.first_solid = solids.len();
            solids.extend(body.parts.iter().map(|&(body_from_solid, solid)| BodySolid {
                body: index,
                body_from_solid,
                solid,
            }));
        }
        let mut scene = Self { robot, bodies, solids, pairs: Vec::new(), keeps_axes: keeps_axes(robot) };
        scene.pairs = scene.judged_pairs(resolved);
        scene
    }

    /// The pairs that are judged: the robot with the cell and with itself, the object with everything; what
    /// `allowed_contacts` lists of the robot may touch.
    fn judged_pairs(&self, resolved: &Resolved) -> Vec<BodyPair> {
        let mut pairs = Vec::new();
        for (a, first) in self.bodies.iter().enumerate() {
            for (b, second) in self.bodies.iter().enumerate() {
                let is_judged = match (first.role, second.role) {
                    (Role::Object, Role::Object) => false,
                    (Role::Object, _) => true,
                    (Role::Cell, _) | (_, Role::Object) => false,
                    (_, Role::Cell) => true,
                    _ => {
                        a < b
                            && !resolved.robot.allowed_contacts.iter().any(|allowed| {
                                let names = [allowed.a.as_str(), allowed.b.as_str()];
                                names == [first.name, second.name] || names == [second.name, first.name]
                            })
                    }
                };
                if is_judged {
                    let rule = self.rule(a, b, resolved);
                    let (clearance, is_named) =
                        (rule.unwrap_or(resolved.cell.clearance.required), rule.is_some());
                    pairs.push(BodyPair { a, b, clearance, is_named });
                }
            }
        }
        pairs
    }

    /// The clearance of the rule that fits two bodies most closely, the largest among equals. A name fits
    /// more closely than `gripper`, and that more than `robot`.
    fn rule(&self, a: usize, b: usize, resolved: &Resolved) -> Option<f64> {
        let closeness = |body: usize, name: &str| match GROUPS.iter().position(|group| *group == name) {
            None if self.bodies[body].name == name => Some(2),
            Some(1) if self.is_gripper(body) => Some(1),
            Some(0) if !matches!(self.bodies[body].role, Role::Cell | Role::Object) => Some(0),
            _ => None,
        };
        let fits = |a, b, names: [&str; 2]| Some(closeness(a, names[0])? + closeness(b, names[1])?);
        let fitting = resolved.cell.clearance.pairs.iter().filter_map(|rule| {
            let names = [rule.a.as_str(), rule.b.as_str()];
            Some((fits(a, b, names).max(fits(b, a, names))?, rule.required))
        });
        let closest = fitting.max_by(|x, y| x.0.cmp(&y.0).then(x.1.total_cmp(&y.1)));
        closest.map(|(_, required)| required)
    }

    /// The indices of the solids of a body.
    pub(crate) fn solids_of(&self, body: usize) -> std::ops::Range<usize> {
        let Body { first_solid, parts, .. } = &self.bodies[body];
        *first_solid..first_solid + parts.len()
    }

    /// Whether a body is the last link, which carries the fingers, or a finger.
    pub(crate) fn is_gripper(&self, body: usize) -> bool {
        match self.bodies[body].role {
            Role::Link(link) => link + 1 == self.robot.links.len(),
            Role::Finger(_) => true,
            Role::Base | Role::Cell | Role::Object => false,
        }
    }

    /// How many joints, counted from the base, move what is fixed there.
    pub(crate) fn joints_of(&self, carrier: Carrier) -> usize {
        match carrier {
            Carrier::World => 0,
            Carrier::Link(link) => link + 1,
            Carrier::Finger(_) => self.robot.joints.len(),
        }
    }
}

/// Whether all axes after the first revolute one are parallel to it, in one posture and so in all.
fn keeps_axes(robot: &Robot) -> bool {
    let mut base_from_joint = Pose::IDENTITY;
    let mut turning: Option<Vector> = None;
    robot.joints.iter().all(|joint| {
        base_from_joint = base_from_joint * joint.parent_from_joint;
        let axis = base_from_joint.vector(joint.axis.0);
        if turning.is_none() && joint.kind == JointKind::Revolute {
            turning = Some(axis);
        }
        turning.is_none_or(|turning| turning.cross(axis).length() <= PARALLEL)
    })
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::fixture::{gantry, read};

    fn names(resolved: &Resolved) -> Vec<String> {
        let scene = Scene::new(resolved);
        let name = |pair: &BodyPair| format!("{} - {}", scene.bodies[pair.a].name, scene.bodies[pair.b].name);
        scene.pairs.iter().map(name).collect()
    }

    #[test]
    fn the_arm_is_judged_with_the_cell_and_itself_and_the_object_with_everything() {
        let all = names(&read(gantry()));
        // Base, three links and two fingers: 15 pairs of the robot, 6 with the table, 7 of the cube.
        assert_eq!(all.len(), 15 + 6 + 7, "{all:?}");
        for pair in [
            "left - right",
            "bridge - carriage",
            "hand - table",
            "cube - table",
            "cube - base",
            "base - table",
        ] {
            assert!(all.iter().any(|name| name == pair), "{pair} is not in {all:?}");
        }
    }

    #[test]
    fn an_allowed_contact_excuses_one_pair_of_the_robot_and_nothing_else() {
        let mut document = gantry();
        document["robot"]["allowed_contacts"] =
            json!([{"a": "hand", "b": "carriage"}, {"a": "hand", "b": "table"}, {"a": "cube", "b": "hand"}]);
        let excused = names(&read(document));
        assert_eq!(excused.len(), 27);
        assert!(!excused.iter().any(|name| name == "carriage - hand"), "{excused:?}");
    }

    #[test]
    fn axes_are_kept_unless_a_turn_lies_before_another_direction() {
        let mut document = gantry();
        assert!(Scene::new(&read(document.clone())).keeps_axes, "slides turn nothing");
        document["robot"]["joints"][1]["kind"] = json!("revolute");
        assert!(!Scene::new(&read(document.clone())).keeps_axes);
        document["robot"]["joints"][2]["axis"] = json!([0.0, -1.0, 0.0]);
        assert!(Scene::new(&read(document)).keeps_axes);
    }
}
