//! Everything that can collide, as convex solids, and the pairs that are judged.

use graspcheck_model::{
    Pose,
    cell::{Cell, ClearanceRule},
    object::Object,
    robot::{Finger, Link, RobotModel},
    shape::{PlacedShape, Shape},
};
use nalgebra::{Translation3, Vector3};

use crate::{
    bounds::Bounds,
    chain::{Carrier, Hinge, Mount, has_steady_axes},
    contact::{APPROACH_MARGIN, Stage},
    error::SceneError,
    gap::GAP_SLACK,
    solid::{LARGEST_COORDINATE, Place, Placed, Solid},
    tree::Tree,
};

/// The name that stands for the last link and both fingers in a clearance rule.
pub const GRIPPER: &str = "gripper";
/// The name that stands for the base, all links and both fingers in a clearance rule.
pub const ROBOT: &str = "robot";

/// Robot, cell and object as convex solids with precomputed bounds, and the list of pairs that are judged.
#[derive(Clone, Debug)]
pub struct Scene {
    pub(crate) robot: RobotModel,
    pub(crate) object: Option<Object>,
    pub(crate) bodies: Vec<Body>,
    pub(crate) parts: Vec<Part>,
    /// Gravity in the world frame, m/s².
    pub(crate) cell_gravity: Vector3<f64>,
    /// Whether no joint of the arm turns the axis of another.
    pub(crate) steady_axes: bool,
    /// Of the robot's base.
    pub(crate) world_from_base: Place,
    /// The joints of the arm, from the base on.
    pub(crate) hinges: Vec<Hinge>,
    /// The closed fingers in the frame of the last link.
    pub(crate) fingers: [Slide; 2],
    /// The object's only part.
    pub(crate) object_part: Option<usize>,
    /// From this one on the parts are those of the cell, which stand still; before it stand those of the robot
    /// and the object.
    pub(crate) first_cell_part: usize,
    /// The bounds of the cell's parts.
    obstacles: Tree,
    /// Parts of the cell that have no bounds: they are near to everything.
    unbounded: Vec<usize>,
    /// Pairs of parts of which none is of the cell.
    pub(crate) pairs_without_cell: Vec<usize>,
    /// The largest distance that any pair must keep, m.
    widest_required: f64,
    /// For each part of the robot or the object, one after the other, and each part of the cell: the index
    /// of their pair.
    pair_with_cell: Vec<u32>,
    /// Pairs of parts that are judged, in order of their body pairs.
    pub(crate) pairs: Vec<PartPair>,
    /// Body pairs, in the order robot–cell, robot–robot, object–cell, object–robot.
    pub(crate) body_pairs: Vec<BodyPair>,
}

/// A body of the scene.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) name: String,
    pub(crate) kind: Kind,
    /// Its parts: a range of [`Scene::parts`].
    pub(crate) first_part: usize,
    pub(crate) end_part: usize,
}

/// What a body is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Base,
    Link(usize),
    Finger(usize),
    Object,
    Cell,
}

/// One convex solid of a body.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) solid: Solid,
    /// Index into [`Scene::bodies`].
    pub(crate) body: usize,
    /// From the solid's frame to the body's: the object is carried by different things in turn.
    pub(crate) body_from_solid: Pose,
    /// How it is mounted; the object stands at its start.
    pub(crate) mount: Mount,
}

/// A finger when it is closed, and which way it opens, both in the frame of the last link.
#[derive(Clone, Debug)]
pub(crate) struct Slide {
    pub(crate) place: Place,
    /// In the frame of the finger.
    pub(crate) axis: Vector3<f64>,
}

/// Two bodies that are judged against each other.
#[derive(Clone, Debug)]
pub(crate) struct BodyPair {
    pub(crate) a: usize,
    pub(crate) b: usize,
    /// The clearance that the rules ask for, m.
    pub(crate) required: f64,
    /// Whether a rule names this pair, so that `required` is not the one for all pairs.
    pub(crate) named: bool,
}

/// Two parts that are judged against each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartPair {
    pub(crate) a: usize,
    pub(crate) b: usize,
    /// Index into [`Scene::body_pairs`].
    pub(crate) bodies: usize,
}

impl Scene {
    /// The scene of a robot in a cell, with the object of the task.
    ///
    /// # Errors
    /// When the robot has no joint or not one moving link for each, a shape has no usable extent, a pose is
    /// not finite, two bodies have the same name or one has the name of a group, or a clearance rule or an
    /// allowed contact names an unknown body or asks for a negative clearance.
    pub fn new(robot: &RobotModel, cell: &Cell, object: Option<&Object>) -> Result<Self, SceneError> {
        if robot.joints.is_empty() || robot.joints.len() != robot.links.len() {
            return Err(SceneError::JointsAndLinks {
                robot: robot.name.clone(),
                joints: robot.joints.len(),
                links: robot.links.len(),
            });
        }
        check_chain(robot)?;
        let slide = |finger: &Finger| Slide {
            place: Place::from(&finger.link_from_finger),
            axis: finger.axis.into_inner(),
        };
        let mut scene = Self {
            robot: robot.clone(),
            object: object.cloned(),
            bodies: Vec::new(),
            parts: Vec::new(),
            cell_gravity: cell.gravity,
            steady_axes: has_steady_axes(robot),
            world_from_base: Place::from(&robot.world_from_base),
            hinges: robot.joints.iter().map(Hinge::new).collect(),
            fingers: robot.gripper.fingers.each_ref().map(slide),
            object_part: None,
            first_cell_part: 0,
            obstacles: Tree::default(),
            unbounded: Vec::new(),
            pairs_without_cell: Vec::new(),
            widest_required: 0.0,
            pair_with_cell: Vec::new(),
            pairs: Vec::new(),
            body_pairs: Vec::new(),
        };
        scene.add_bodies(cell)?;
        scene.check_names(&cell.clearance)?;
        scene.add_pairs(&cell.clearance);
        Ok(scene)
    }

    /// The number of convex solids.
    #[must_use]
    pub fn solid_count(&self) -> usize {
        self.parts.len()
    }

    /// The number of pairs of convex solids that are judged.
    #[must_use]
    pub fn pair_count(&self) -> usize {
        self.pairs.len()
    }

    fn add_bodies(&mut self, cell: &Cell) -> Result<(), SceneError> {
        let robot = self.robot.clone();
        let add_link = |scene: &mut Self, link: &Link, kind, carrier, carrier_from_body: Pose| {
            let shapes =
                link.shapes.iter().map(|PlacedShape { body_from_shape, shape }| (shape, *body_from_shape));
            scene.add_body(&link.name, kind, carrier, carrier_from_body, shapes)
        };
        add_link(self, &robot.base, Kind::Base, Carrier::World, robot.world_from_base)?;
        for (index, link) in robot.links.iter().enumerate() {
            add_link(self, link, Kind::Link(index), Carrier::Link(index), Pose::identity())?;
        }
        for (index, finger) in robot.gripper.fingers.iter().enumerate() {
            add_link(self, &finger.link, Kind::Finger(index), Carrier::Finger(index), Pose::identity())?;
        }
        if let Some(object) = self.object.clone() {
            let shape = [(&object.shape, Pose::identity())].into_iter();
            self.object_part = Some(self.parts.len());
            self.add_body(&object.name, Kind::Object, Carrier::World, object.world_from_object, shape)?;
        }
        self.first_cell_part = self.parts.len();
        for body in &cell.bodies {
            let shape = [(&body.shape, Pose::identity())].into_iter();
            self.add_body(&body.name, Kind::Cell, Carrier::World, body.world_from_shape, shape)?;
        }
        let cell = self.first_cell_part..self.parts.len();
        let (bounded, unbounded) = cell.partition(|&part| self.still(part).is_near());
        self.unbounded = unbounded;
        let bounds = |part: usize| (Bounds::of(&self.still(part)), part);
        self.obstacles = Tree::new(Vec::into_iter(bounded).map(bounds).collect());
        Ok(())
    }

    fn add_body<'s>(
        &mut self,
        name: &str,
        kind: Kind,
        carrier: Carrier,
        carrier_from_body: Pose,
        shapes: impl Iterator<Item = (&'s Shape, Pose)>,
    ) -> Result<(), SceneError> {
        let first_part = self.parts.len();
        for (shape, (solid, body_from_shape)) in shapes.enumerate() {
            let (solid, origin) = Solid::from_shape(solid).map_err(|fault| SceneError::Shape {
                body: name.to_owned(),
                shape,
                fault,
            })?;
            let body_from_solid = body_from_shape * Translation3::from(origin);
            let carrier_from_solid = carrier_from_body * body_from_solid;
            if !is_finite(&carrier_from_solid) {
                return Err(SceneError::NotFinite { body: name.to_owned() });
            }
            let mount = Mount::new(&self.robot, &solid, carrier, &carrier_from_solid);
            self.parts.push(Part { solid, body: self.bodies.len(), body_from_solid, mount });
        }
        self.bodies.push(Body { name: name.to_owned(), kind, first_part, end_part: self.parts.len() });
        Ok(())
    }

    fn check_names(&self, rules: &ClearanceRule) -> Result<(), SceneError> {
        for (index, body) in self.bodies.iter().enumerate() {
            let body_name = || body.name.clone();
            if self.bodies[..index].iter().any(|other| other.name == body.name) {
                return Err(SceneError::NameTwice { body: body_name() });
            }
            if [GRIPPER, ROBOT].contains(&body.name.as_str()) {
                return Err(SceneError::NameOfGroup { body: body_name() });
            }
        }
        let known = |place: String, name: &str, groups: &[&str]| {
            if groups.contains(&name) || self.bodies.iter().any(|body| body.name == name) {
                return Ok(());
            }
            let names: Vec<&str> = self.bodies.iter().map(|body| body.name.as_str()).collect();
            Err(SceneError::UnknownBody { place, name: name.to_owned(), known: names.join(", ") })
        };
        for contact in &self.robot.allowed_contacts {
            let place = || format!("allowed contact {} - {}", contact.a, contact.b);
            known(place(), &contact.a, &[])?;
            known(place(), &contact.b, &[])?;
        }
        let valid = |place: String, required: f64| {
            if required.is_finite() && required >= 0.0 {
                Ok(())
            } else {
                Err(SceneError::Required { place, required })
            }
        };
        valid("clearance of all pairs".to_owned(), rules.required)?;
        for rule in &rules.pairs {
            let place = || format!("clearance rule {} - {}", rule.a, rule.b);
            known(place(), &rule.a, &[GRIPPER, ROBOT])?;
            known(place(), &rule.b, &[GRIPPER, ROBOT])?;
            valid(place(), rule.required)?;
        }
        Ok(())
    }

    fn add_pairs(&mut self, rules: &ClearanceRule) {
        let is_robot = |body: usize| !matches!(self.bodies[body].kind, Kind::Object | Kind::Cell);
        let is = |body: usize, kind| self.bodies[body].kind == kind;
        let all = || 0..self.bodies.len();
        let mut candidates: Vec<(usize, usize)> = Vec::new();
        let robot_cell = all().flat_map(|a| all().map(move |b| (a, b)));
        candidates.extend(robot_cell.filter(|&(a, b)| is_robot(a) && is(b, Kind::Cell)));
        let robot_robot = all().flat_map(|a| (a + 1..self.bodies.len()).map(move |b| (a, b)));
        candidates
            .extend(robot_robot.filter(|&(a, b)| is_robot(a) && is_robot(b) && self.excuse(a, b).is_none()));
        for object in all().filter(|&body| is(body, Kind::Object)) {
            candidates.extend(all().filter(|&b| is(b, Kind::Cell)).map(|b| (object, b)));
            candidates.extend(all().filter(|&b| is_robot(b)).map(|b| (object, b)));
        }
        for (a, b) in candidates {
            let (required, named) = match self.rule_for(a, b, rules) {
                Some(required) => (required, true),
                None => (rules.required, false),
            };
            let bodies = self.body_pairs.len();
            self.body_pairs.push(BodyPair { a, b, required, named });
            for part_a in self.bodies[a].first_part..self.bodies[a].end_part {
                for part_b in self.bodies[b].first_part..self.bodies[b].end_part {
                    self.pairs.push(PartPair { a: part_a, b: part_b, bodies });
                }
            }
        }
        let obstacles = self.parts.len() - self.first_cell_part;
        self.pair_with_cell = vec![0; self.first_cell_part * obstacles];
        for (index, pair) in (0_u32..).zip(&self.pairs) {
            if pair.b >= self.first_cell_part {
                self.pair_with_cell[pair.a * obstacles + pair.b - self.first_cell_part] = index;
            } else {
                self.pairs_without_cell.push(index as usize);
            }
        }
        let required = self.body_pairs.iter().map(|bodies| bodies.required);
        self.widest_required = required.fold(APPROACH_MARGIN, f64::max);
    }

    /// The index of the pair of a part of the robot or the object and one of the cell.
    pub(crate) fn pair_with_cell(&self, part: usize, obstacle: usize) -> usize {
        let obstacles = self.parts.len() - self.first_cell_part;
        self.pair_with_cell[part * obstacles + obstacle - self.first_cell_part] as usize
    }

    /// Calls with every pair of a part of the robot or the object that a box around it does not prove: with a
    /// part of the cell that may be nearer to the box than required and [`GAP_SLACK`], or than that and `more`
    /// (m). Also gives how much more than required and the slack the boxes are apart, m, minus infinity where
    /// they touch or a number is NaN.
    pub(crate) fn near_to_sweep(
        &self,
        stage: &Stage,
        part: usize,
        sweep: &Bounds,
        more: f64,
        mut found: impl FnMut(usize, f64),
    ) {
        let is_known = sweep.low.iter().chain(&sweep.high).all(|x| x.abs() < LARGEST_COORDINATE);
        let nowhere = Bounds { low: Vector3::repeat(f64::NAN), high: Vector3::repeat(f64::NAN) };
        let sweep = if is_known { sweep } else { &nowhere };
        self.near_obstacles(sweep, self.widest_required + GAP_SLACK + more, |obstacle, apart| {
            let pair = self.pair_with_cell(part, obstacle);
            let required = stage.requirement(self, &self.pairs[pair]).required.max(0.0);
            let room = if apart > 0.0 { apart - required - GAP_SLACK } else { f64::NEG_INFINITY };
            if room <= more {
                found(pair, room);
            }
        });
    }

    /// A part that stands still in the world.
    pub(crate) fn still(&self, part: usize) -> Placed<'_> {
        Placed { solid: &self.parts[part].solid, place: self.parts[part].mount.place }
    }

    /// Calls with every part of the cell that may be nearer to a box than `distance` (m), and with how far
    /// apart their bounds are, m, or 0.
    pub(crate) fn near_obstacles(&self, bounds: &Bounds, distance: f64, mut found: impl FnMut(usize, f64)) {
        self.unbounded.iter().for_each(|&part| found(part, 0.0));
        self.obstacles.near(bounds, distance, found);
    }

    /// Why two bodies of the robot are never judged against each other, if they are not: the reason of their
    /// allowed contact. Nothing else excuses a pair, not even a joint that they share.
    pub(crate) fn excuse(&self, a: usize, b: usize) -> Option<String> {
        let (name_a, name_b) = (&self.bodies[a].name, &self.bodies[b].name);
        let allowed = self.robot.allowed_contacts.iter().find(|contact| {
            (contact.a == *name_a && contact.b == *name_b) || (contact.a == *name_b && contact.b == *name_a)
        });
        allowed.map(|contact| contact.reason.clone())
    }

    /// The clearance of the most specific rule for two bodies, m: a rule that names a body counts more than
    /// one that names the gripper, and that more than one that names the robot; among equals the largest.
    fn rule_for(&self, a: usize, b: usize, rules: &ClearanceRule) -> Option<f64> {
        let found = rules.pairs.iter().filter_map(|rule| {
            let fit = |x, y| Some(self.specificity(x, &rule.a)? + self.specificity(y, &rule.b)?);
            Some((fit(a, b).max(fit(b, a))?, rule.required))
        });
        found.max_by(|x, y| x.0.cmp(&y.0).then(x.1.total_cmp(&y.1))).map(|(_, required)| required)
    }

    /// How specifically a name means a body; none when it does not.
    fn specificity(&self, body: usize, name: &str) -> Option<u8> {
        let Body { name: own, kind, .. } = &self.bodies[body];
        let is_robot = !matches!(kind, Kind::Object | Kind::Cell);
        match name {
            _ if name == own => Some(2),
            GRIPPER if self.is_gripper(body) => Some(1),
            ROBOT if is_robot => Some(0),
            _ => None,
        }
    }

    /// Whether the body is the last link or a finger.
    pub(crate) fn is_gripper(&self, body: usize) -> bool {
        match self.bodies[body].kind {
            Kind::Link(link) => link + 1 == self.robot.dof(),
            Kind::Finger(_) => true,
            Kind::Base | Kind::Object | Kind::Cell => false,
        }
    }
}

/// Whether every number of a pose is finite.
pub(crate) fn is_finite(pose: &Pose) -> bool {
    pose.to_homogeneous().iter().all(|x| x.is_finite())
}

fn check_chain(robot: &RobotModel) -> Result<(), SceneError> {
    let not_finite = |body: &str| Err(SceneError::NotFinite { body: body.to_owned() });
    if !is_finite(&robot.world_from_base) {
        return not_finite(&robot.base.name);
    }
    for (joint, link) in robot.joints.iter().zip(&robot.links) {
        if !(is_finite(&joint.parent_from_joint) && joint.axis.iter().all(|x| x.is_finite())) {
            return not_finite(&link.name);
        }
    }
    for finger in &robot.gripper.fingers {
        if !(is_finite(&finger.link_from_finger) && finger.axis.iter().all(|x| x.is_finite())) {
            return not_finite(&finger.link.name);
        }
    }
    if !is_finite(&robot.link_from_tool) {
        return not_finite(&robot.links[robot.links.len() - 1].name);
    }
    Ok(())
}
