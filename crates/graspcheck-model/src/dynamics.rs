//! Inverse dynamics of a serial arm: the torques that a motion takes.
//!
//! Recursive Newton–Euler in the links' own frames (Craig, *Introduction to Robotics*, section 6.5;
//! Siciliano et al., *Robotics: Modelling, Planning and Control*, 7.5.2). Gravity enters as an upward
//! acceleration of the base. A rotor adds its reflected inertia at its own joint; its gyroscopic effect on
//! other joints is neglected, as usual for geared drives.
//!
//! Symbols: `q qd qdd` are joint positions, velocities, accelerations, SI units and radians; `tau` are
//! torques and forces, N·m or N.
//!
//! The recursion is written once for every [`Scalar`]. With floats it gives the torques of an instant; with
//! [`Interval`](graspcheck_motion::Interval) bounds on the torques of every state in a box, rounding included;
//! with [`Dual`](graspcheck_motion::Dual) numbers their rates as well. [`TorqueBounds`](crate::torque_bounds)
//! bounds them over a stretch of time.
//!
//! ```
//! use graspcheck_model::{dynamics::{Dynamics, Workspace}, example};
//! use graspcheck_motion::Interval;
//! use nalgebra::Vector3;
//!
//! // The planar arm held out level against gravity: 20 kg at 2 m, 15 kg at 5.5 m, 3 kg at 7.5 m.
//! let mut dynamics = Dynamics::new(&example::planar(), Vector3::new(0.0, -9.81, 0.0));
//! let (rest, mut tau) = ([0.0; 3], [0.0; 3]);
//! dynamics.inverse(&rest, &rest, &rest, &mut tau);
//! assert!((tau[0] - 9.81 * (20.0 * 2.0 + 15.0 * 5.5 + 3.0 * 7.5)).abs() < 1e-10);
//!
//! // tau = M(q) qdd + V(q, qd) + G(q): a unit acceleration of the shoulder adds the first column of M.
//! let mut moving = [0.0; 3];
//! dynamics.inverse(&rest, &rest, &[1.0, 0.0, 0.0], &mut moving);
//! assert!((moving[1] - tau[1] - dynamics.mass_matrix(&rest)[(1, 0)]).abs() < 1e-10);
//!
//! // The same recursion over a box of positions bounds the torque of every pose in it.
//! let still = [Interval::ZERO; 3];
//! let mut bounds = still;
//! let near = [0.0; 3].map(|q: f64| Interval::between(q - 0.01, q + 0.01));
//! dynamics.inverse_of(&near, &still, &still, &mut Workspace::new(3), &mut bounds);
//! assert!(bounds[0].contains(tau[0]) && bounds[0].width() < 10.0);
//! ```

use graspcheck_motion::{Scalar, Signed};
use nalgebra::{DMatrix, Matrix3, Vector3};

use crate::{
    hinge::Hinge,
    inertia::Inertial,
    robot::{Gripper, JointKind, RobotModel},
    spatial::{Frame, Rotation, Vector},
};

/// The inverse dynamics of one arm, with what it holds. Owned and preallocated; evaluating it allocates
/// nothing (the mass matrix excepted).
#[derive(Clone, Debug)]
pub struct Dynamics {
    bodies: Vec<Body>,
    /// The last link without fingers and load, and the gripper: what `set_load` puts together.
    last_link: Inertial,
    gripper: Gripper,
    /// Minus gravity, in the base frame, m/s².
    upward: Vector3<f64>,
    workspace: Workspace<f64>,
    unit: Vec<f64>,
    zero: Vec<f64>,
    column: Vec<f64>,
}

/// Room for one evaluation of the recursion.
#[derive(Clone, Debug)]
pub struct Workspace<S> {
    motions: Vec<Motion<S>>,
}

impl<S: Scalar> Workspace<S> {
    /// Room for an arm of `dof` joints.
    #[must_use]
    pub fn new(dof: usize) -> Self {
        let at_rest = Motion {
            parent_from_link: Frame {
                rotation: Rotation::constant(&Matrix3::identity()),
                origin: Vector::zero(),
            },
            force: Vector::zero(),
            moment: Vector::zero(),
        };
        Self { motions: vec![at_rest; dof] }
    }
}

/// A link and the joint that moves it.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) hinge: Hinge,
    pub(crate) mass: f64,
    /// In the link's frame, m.
    pub(crate) center: Vector3<f64>,
    /// About the centre, kg·m².
    pub(crate) tensor: Matrix3<f64>,
    pub(crate) rotor_inertia: f64,
    pub(crate) damping: f64,
    pub(crate) friction: f64,
}

/// Motion of and force on one link, in its own frame.
#[derive(Clone, Copy, Debug)]
struct Motion<S> {
    parent_from_link: Frame<S>,
    /// Inertial force on the link, N.
    force: Vector<S>,
    /// Inertial moment on the link about its frame's origin, N·m.
    moment: Vector<S>,
}

impl Dynamics {
    /// The inverse dynamics of `robot` in a gravity given in the world frame (m/s²). The gripper is closed
    /// and empty until [`Dynamics::set_load`] says otherwise.
    #[must_use]
    pub fn new(robot: &RobotModel, gravity_world: Vector3<f64>) -> Self {
        let dof = robot.dof();
        let bodies = robot.joints.iter().zip(&robot.links).map(|(joint, link)| Body {
            hinge: Hinge::new(joint),
            mass: link.inertial.mass,
            center: link.inertial.center.coords,
            tensor: link.inertial.tensor,
            rotor_inertia: joint.rotor_inertia,
            damping: joint.damping,
            friction: joint.friction,
        });
        let mut dynamics = Self {
            bodies: bodies.collect(),
            last_link: robot.links.last().map_or(Inertial::massless(), |link| link.inertial.clone()),
            gripper: robot.gripper.clone(),
            upward: -(robot.world_from_base.rotation.inverse() * gravity_world),
            workspace: Workspace::new(dof),
            unit: vec![0.0; dof],
            zero: vec![0.0; dof],
            column: vec![0.0; dof],
        };
        dynamics.set_load(0.0, None);
        dynamics
    }

    /// The number of joints.
    #[must_use]
    pub fn dof(&self) -> usize {
        self.bodies.len()
    }

    /// The links with their joints, from base to tool.
    pub(crate) fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Minus gravity, in the base frame, m/s².
    pub(crate) fn upward(&self) -> Vector3<f64> {
        self.upward
    }

    /// From now on the gripper stands at `opening` (m, between the pads) and the last link carries `load`,
    /// whose mass properties are given in the frame of the last link.
    pub fn set_load(&mut self, opening: f64, load: Option<&Inertial>) {
        let gripper = &self.gripper;
        let fingers = [0, 1].map(|finger| {
            gripper.fingers[finger].link.inertial.transformed(&gripper.link_from_finger_at(finger, opening))
        });
        let [left, right] = fingers;
        let load = load.cloned().unwrap_or(Inertial::massless());
        let whole = Inertial::combine(&[self.last_link.clone(), left, right, load]);
        if let Some(body) = self.bodies.last_mut() {
            body.mass = whole.mass;
            body.center = whole.center.coords;
            body.tensor = whole.tensor;
        }
    }

    /// The torques and forces (N·m, N) that give the arm accelerations `qdd` at positions `q` and
    /// velocities `qd`: `tau = M(q) qdd + V(q, qd) + G(q)`, rotor inertia included, friction not.
    ///
    /// # Panics
    /// When a slice has another length than the arm has joints.
    pub fn inverse(&mut self, q: &[f64], qd: &[f64], qdd: &[f64], tau: &mut [f64]) {
        recursive_newton_euler(&self.bodies, self.upward, q, qd, qdd, &mut self.workspace, tau);
    }

    /// As [`Dynamics::inverse`] with any [`Scalar`]: intervals give the torques of every state in a box, what
    /// floats compute for it included; dual numbers the torques and their rates. Allocates nothing.
    ///
    /// # Panics
    /// When a slice, or the workspace, has another length than the arm has joints.
    pub fn inverse_of<S: Scalar>(
        &self,
        q: &[S],
        qd: &[S],
        qdd: &[S],
        workspace: &mut Workspace<S>,
        tau: &mut [S],
    ) {
        recursive_newton_euler(&self.bodies, self.upward, q, qd, qdd, workspace, tau);
    }

    /// Torques and forces that friction takes at velocities `qd`, N·m or N: viscous and dry, with the sign of
    /// the velocity; a joint at rest takes none. To be added to [`Dynamics::inverse`].
    ///
    /// # Panics
    /// When a slice has another length than the arm has joints.
    pub fn friction(&self, qd: &[f64], out: &mut [f64]) {
        self.friction_of(qd, out);
    }

    /// As [`Dynamics::friction`] with floats or intervals: a velocity that may change its sign gives dry
    /// friction of either direction and all between.
    ///
    /// # Panics
    /// When a slice has another length than the arm has joints.
    pub fn friction_of<S: Signed>(&self, qd: &[S], out: &mut [S]) {
        assert_eq!(qd.len(), self.bodies.len(), "velocities for another number of joints");
        assert_eq!(out.len(), self.bodies.len(), "torques for another number of joints");
        for ((body, &velocity), torque) in self.bodies.iter().zip(qd).zip(out) {
            *torque = velocity.scaled(body.damping) + velocity.sign().scaled(body.friction);
        }
    }

    /// The mass matrix M(q), kg·m², kg·m and kg by the kinds of the joints, rotor inertia included.
    /// Column k is the torque of a unit acceleration of joint k without gravity.
    ///
    /// # Panics
    /// When `q` has another length than the arm has joints.
    pub fn mass_matrix(&mut self, q: &[f64]) -> DMatrix<f64> {
        let dof = self.bodies.len();
        let mut matrix = DMatrix::zeros(dof, dof);
        for k in 0..dof {
            self.unit.fill(0.0);
            self.unit[k] = 1.0;
            let no_gravity = Vector3::zeros();
            recursive_newton_euler(
                &self.bodies,
                no_gravity,
                q,
                &self.zero,
                &self.unit,
                &mut self.workspace,
                &mut self.column,
            );
            matrix.column_mut(k).copy_from_slice(&self.column);
        }
        // Both halves are the same number, computed in two orders.
        (&matrix + matrix.transpose()) * 0.5
    }
}

/// Outward over the links: velocity, acceleration and inertial force; inward: what the joints must bear.
fn recursive_newton_euler<S: Scalar>(
    bodies: &[Body],
    upward: Vector3<f64>,
    q: &[S],
    qd: &[S],
    qdd: &[S],
    workspace: &mut Workspace<S>,
    tau: &mut [S],
) {
    let dof = bodies.len();
    let motions = &mut workspace.motions[..];
    assert_eq!(q.len(), dof, "positions for another number of joints");
    assert_eq!(qd.len(), dof, "velocities for another number of joints");
    assert_eq!(qdd.len(), dof, "accelerations for another number of joints");
    assert_eq!(tau.len(), dof, "torques for another number of joints");
    assert_eq!(motions.len(), dof, "a workspace for another number of joints");
    // Angular velocity and acceleration of the parent, and acceleration of its origin, in its frame.
    let (mut omega, mut alpha) = (Vector::zero(), Vector::zero());
    let mut acceleration = Vector::constant(&upward);
    for (k, (body, motion)) in bodies.iter().zip(motions.iter_mut()).enumerate() {
        motion.parent_from_link = body.hinge.parent_from_link(q[k]);
        let Frame { rotation, origin } = &motion.parent_from_link;
        let of_origin = acceleration + alpha.cross(*origin) + omega.cross(omega.cross(*origin));
        omega = rotation.turn_back(omega);
        alpha = rotation.turn_back(alpha);
        acceleration = rotation.turn_back(of_origin);
        match body.hinge.kind {
            JointKind::Revolute => {
                let spin = Vector::along(&body.hinge.axis, qd[k]);
                alpha += Vector::along(&body.hinge.axis, qdd[k]) + omega.cross(spin);
                omega += spin;
            }
            JointKind::Prismatic => {
                let slide = Vector::along(&body.hinge.axis, qd[k].scaled(2.0));
                acceleration += omega.cross(slide) + Vector::along(&body.hinge.axis, qdd[k]);
            }
        }
        let of_center = acceleration
            + alpha.cross_constant(&body.center)
            + omega.cross(omega.cross_constant(&body.center));
        motion.force = of_center.scaled(body.mass);
        motion.moment = alpha.mapped(&body.tensor) + omega.cross(omega.mapped(&body.tensor))
            - motion.force.cross_constant(&body.center);
    }
    let (mut force, mut moment) = (Vector::zero(), Vector::zero());
    for k in (0..dof).rev() {
        let (body, motion) = (&bodies[k], &motions[k]);
        force += motion.force;
        moment += motion.moment;
        let borne = match body.hinge.kind {
            JointKind::Revolute => moment.dot_constant(&body.hinge.axis),
            JointKind::Prismatic => force.dot_constant(&body.hinge.axis),
        };
        tau[k] = borne + qdd[k].scaled(body.rotor_inertia);
        force = motion.parent_from_link.rotation.turn(force);
        moment = motion.parent_from_link.rotation.turn(moment) + motion.parent_from_link.origin.cross(force);
    }
}
