//! Where the solids of a scene are at an instant, and how fast they can approach each other.

use graspcheck_model::{
    Pose,
    cell::Cell,
    object::Object,
    plan::Plan,
    robot::{JointKind, Link, RobotModel},
    shape::Shape,
};
use graspcheck_motion::Trajectory;
use nalgebra::{Matrix3, Vector3};

use super::solid::{Placed, Solid};

/// What carries a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carrier {
    World,
    Link(usize),
    Finger(usize),
}

/// One solid of a body.
pub struct Part {
    pub body: String,
    pub index: usize,
    pub carrier: Carrier,
    /// From the solid's frame to that of the carrier.
    pub place: Frame,
    pub solid: Solid,
    /// For each joint that moves it: how far any point of it can be from the joint's origin, m.
    reaches: Vec<f64>,
}

/// A rotation and an origin.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pub turn: Matrix3<f64>,
    pub origin: Vector3<f64>,
}

impl Frame {
    pub fn of(pose: &Pose) -> Self {
        Self { turn: pose.rotation.to_rotation_matrix().into_inner(), origin: pose.translation.vector }
    }

    fn then(&self, next: &Self) -> Self {
        Self { turn: self.turn * next.turn, origin: self.origin + self.turn * next.origin }
    }

    fn moved(&self, by: Vector3<f64>) -> Self {
        Self { turn: self.turn, origin: self.origin + self.turn * by }
    }
}

/// All solids of a scene in which the object, if there is one, is held by the gripper from beginning to end.
pub struct Bodies<'c> {
    robot: &'c RobotModel,
    plan: &'c Plan,
    pub parts: Vec<Part>,
    base: Frame,
    /// From joint to joint, at position 0.
    steps: Vec<Frame>,
    axes: Vec<Vector3<f64>>,
    fingers: [Frame; 2],
}

/// The places of all carriers at an instant.
pub struct Moment {
    links: Vec<Frame>,
    fingers: [Frame; 2],
}

impl<'c> Bodies<'c> {
    pub fn new(robot: &'c RobotModel, cell: &'c Cell, object: Option<&'c Object>, plan: &'c Plan) -> Self {
        let mut bodies = Self {
            robot,
            plan,
            parts: Vec::new(),
            base: Frame::of(&robot.world_from_base),
            steps: robot.joints.iter().map(|joint| Frame::of(&joint.parent_from_joint)).collect(),
            axes: robot.joints.iter().map(|joint| joint.axis.into_inner()).collect(),
            fingers: [0, 1].map(|finger| Frame::of(&robot.gripper.fingers[finger].link_from_finger)),
        };
        bodies.add_link(&robot.base, Carrier::World, &robot.world_from_base);
        for (index, link) in robot.links.iter().enumerate() {
            bodies.add_link(link, Carrier::Link(index), &Pose::identity());
        }
        for (index, finger) in robot.gripper.fingers.iter().enumerate() {
            bodies.add_link(&finger.link, Carrier::Finger(index), &Pose::identity());
        }
        for body in &cell.bodies {
            bodies.add(&body.name, 0, Carrier::World, &body.world_from_shape, &body.shape);
        }
        if let Some(object) = object {
            let grasp = plan.grasp.as_ref().expect("the object is held");
            let place = robot.link_from_tool * grasp.tool_from_object;
            bodies.add(&object.name, 0, Carrier::Link(robot.dof() - 1), &place, &object.shape);
        }
        bodies
    }

    fn add_link(&mut self, link: &Link, carrier: Carrier, from_link: &Pose) {
        for (index, placed) in link.shapes.iter().enumerate() {
            self.add(&link.name, index, carrier, &(from_link * placed.body_from_shape), &placed.shape);
        }
    }

    fn add(&mut self, body: &str, index: usize, carrier: Carrier, place: &Pose, shape: &Shape) {
        let solid = Solid::of(shape);
        let place = Frame::of(place);
        // From the solid back to each joint: no way is longer than the sum of its steps.
        let mut way = place.origin.norm() + solid.reach();
        let joints = self.joints_of(carrier);
        if let Carrier::Finger(finger) = carrier {
            way += self.fingers[finger].origin.norm() + self.robot.gripper.opening_max;
        }
        let mut reaches = vec![0.0; joints];
        for joint in (0..joints).rev() {
            if self.robot.joints[joint].kind == JointKind::Prismatic {
                way += largest(&self.plan.trajectory, joint);
            }
            reaches[joint] = way;
            way += self.steps[joint].origin.norm();
        }
        self.parts.push(Part { body: body.to_owned(), index, carrier, place, solid, reaches });
    }

    fn joints_of(&self, carrier: Carrier) -> usize {
        match carrier {
            Carrier::World => 0,
            Carrier::Link(link) => link + 1,
            Carrier::Finger(_) => self.robot.dof(),
        }
    }

    pub fn duration(&self) -> f64 {
        self.plan.duration()
    }

    pub fn part(&self, body: &str, index: usize) -> Option<usize> {
        self.parts.iter().position(|part| part.body == body && part.index == index)
    }

    /// Where all carriers are at time `t`, s. At a break of the plan the later side counts.
    pub fn at(&self, t: f64) -> Moment {
        let mut frame = self.base;
        let links = (0..self.robot.dof()).map(|joint| {
            let q = position(&self.plan.trajectory, joint, t);
            frame = frame.then(&self.steps[joint]);
            let axis = &self.axes[joint];
            match self.robot.joints[joint].kind {
                JointKind::Prismatic => frame = frame.moved(axis * q),
                JointKind::Revolute => frame.turn *= rodrigues(axis, q),
            }
            frame
        });
        let links: Vec<Frame> = links.collect();
        let half = 0.5 * position(&self.plan.opening, 0, t);
        let last = links[links.len() - 1];
        let fingers = [0, 1].map(|finger| {
            let axis = self.robot.gripper.fingers[finger].axis.into_inner();
            last.then(&self.fingers[finger]).moved(axis * half)
        });
        Moment { links, fingers }
    }

    pub fn placed<'s>(&'s self, part: usize, moment: &Moment) -> Placed<'s> {
        let Part { carrier, place, solid, .. } = &self.parts[part];
        let Frame { turn, origin } = match carrier {
            Carrier::World => *place,
            Carrier::Link(link) => moment.links[*link].then(place),
            Carrier::Finger(finger) => moment.fingers[*finger].then(place),
        };
        Placed { solid, turn, origin }
    }

    /// How fast the distance of two solids can change at most when the joints are no faster than `speeds` (the last one
    /// is that of the opening), m/s: only the joints between their carriers count.
    pub fn approach(&self, a: usize, b: usize, speeds: &[f64]) -> f64 {
        let joints = [a, b].map(|part| self.joints_of(self.parts[part].carrier));
        let (common, farther) = (joints[0].min(joints[1]), if joints[0] > joints[1] { a } else { b });
        let between = common..joints[0].max(joints[1]);
        let arm: f64 = between
            .map(|joint| match self.robot.joints[joint].kind {
                JointKind::Prismatic => speeds[joint],
                JointKind::Revolute => speeds[joint] * self.parts[farther].reaches[joint],
            })
            .sum();
        let is_finger = |part: usize| matches!(self.parts[part].carrier, Carrier::Finger(_));
        let fingers = f64::from(u8::from(is_finger(a)) + u8::from(is_finger(b)));
        arm + 0.5 * fingers * speeds[speeds.len() - 1]
    }

    /// Bounds on the speeds of all joints and of the opening within `[start, end]`, by that in the middle and the sums of
    /// the magnitudes of the terms of the acceleration.
    pub fn speeds(&self, start: f64, end: f64) -> Vec<f64> {
        let arm = (0..self.robot.dof()).map(|joint| fastest(&self.plan.trajectory, joint, start, end));
        arm.chain([fastest(&self.plan.opening, 0, start, end)]).collect()
    }
}

/// The matrix of a turn by an angle (rad) about an axis of length 1 (Rodrigues).
fn rodrigues(axis: &Vector3<f64>, angle: f64) -> Matrix3<f64> {
    let cross = axis.cross_matrix();
    Matrix3::identity() + cross * angle.sin() + cross * cross * (1.0 - angle.cos())
}

/// A joint's coefficients and the local time at `t`.
fn local(trajectory: &Trajectory, joint: usize, t: f64) -> ([f64; 8], f64) {
    let knots = trajectory.knots();
    let piece = knots[1..knots.len() - 1].iter().take_while(|knot| **knot <= t).count();
    (*trajectory.piece(piece, joint).coefficients(), t - knots[piece])
}

fn position(trajectory: &Trajectory, joint: usize, t: f64) -> f64 {
    let (coefficients, tau) = local(trajectory, joint, t);
    coefficients.iter().enumerate().map(|(power, c)| c * tau.powi(power as i32)).sum()
}

/// A bound on the magnitude of a joint's position over the whole motion.
fn largest(trajectory: &Trajectory, joint: usize) -> f64 {
    let knots = trajectory.knots();
    let piece = |piece: usize| {
        let tau = knots[piece + 1] - knots[piece];
        let coefficients = trajectory.piece(piece, joint).coefficients();
        coefficients.iter().enumerate().map(|(power, c)| c.abs() * tau.powi(power as i32)).sum::<f64>()
    };
    (0..knots.len() - 1).map(piece).fold(0.0, f64::max)
}

fn fastest(trajectory: &Trajectory, joint: usize, start: f64, end: f64) -> f64 {
    let knots = trajectory.knots();
    let mut fastest: f64 = 0.0;
    for piece in 0..knots.len() - 1 {
        let (from, to) = (start.max(knots[piece]) - knots[piece], end.min(knots[piece + 1]) - knots[piece]);
        if from > to {
            continue;
        }
        let middle = 0.5 * (from + to);
        let (mut speed, mut acceleration) = (0.0, 0.0);
        for (power, c) in trajectory.piece(piece, joint).coefficients().iter().enumerate().skip(1) {
            let k = power as f64;
            speed += k * c * middle.powi(power as i32 - 1);
            if power > 1 {
                acceleration += k * (k - 1.0) * c.abs() * to.powi(power as i32 - 2);
            }
        }
        fastest = fastest.max(speed.abs() + acceleration * 0.5 * (to - from));
    }
    fastest
}
