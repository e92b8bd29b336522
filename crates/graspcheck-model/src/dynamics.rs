//! Inverse dynamics of a serial arm: the torques that a motion takes.
//!
//! Recursive Newton–Euler in the links' own frames (Craig, *Introduction to Robotics*, section 6.5;
//! Siciliano et al., *Robotics: Modelling, Planning and Control*, 7.5.2). Gravity enters as an upward
//! acceleration of the base. A rotor adds its reflected inertia at its own joint; its gyroscopic effect on
//! other joints is neglected, as usual for geared drives.
//!
//! Symbols: `q qd qdd` are joint positions, velocities, accelerations, SI units and radians; `tau` are
//! torques and forces, N·m or N.

use nalgebra::{DMatrix, Matrix3, Vector3};

use crate::{
    inertia::Inertial,
    robot::{Gripper, JointKind, RobotModel},
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
    scratch: Vec<Motion>,
    unit: Vec<f64>,
    zero: Vec<f64>,
    column: Vec<f64>,
}

/// A link and the joint that moves it.
#[derive(Clone, Debug)]
struct Body {
    kind: JointKind,
    axis: Vector3<f64>,
    /// Rotation of the joint's frame at position 0 into the parent's.
    parent_from_joint: Matrix3<f64>,
    /// `parent_from_joint` times the part of the rotation about the axis that goes with sin q.
    with_sin: Matrix3<f64>,
    /// … and with 1 − cos q.
    with_versine: Matrix3<f64>,
    /// Origin of the joint's frame at position 0 in the parent's frame, m.
    origin: Vector3<f64>,
    /// The axis of a prismatic joint in the parent's frame; zero for a revolute one.
    slide: Vector3<f64>,
    mass: f64,
    center: Vector3<f64>,
    tensor: Matrix3<f64>,
    rotor_inertia: f64,
    damping: f64,
    friction: f64,
}

/// Motion of and force on one link, in its own frame.
#[derive(Clone, Copy, Debug)]
struct Motion {
    parent_from_link: Matrix3<f64>,
    /// Origin of the link's frame in the parent's, m.
    origin: Vector3<f64>,
    /// Inertial force on the link, N.
    force: Vector3<f64>,
    /// Inertial moment on the link about its frame's origin, N·m.
    moment: Vector3<f64>,
}

impl Dynamics {
    /// The inverse dynamics of `robot` in a gravity given in the world frame (m/s²). The gripper is closed
    /// and empty until [`Dynamics::set_load`] says otherwise.
    #[must_use]
    pub fn new(robot: &RobotModel, gravity_world: Vector3<f64>) -> Self {
        let dof = robot.dof();
        let bodies = robot.joints.iter().zip(&robot.links).map(|(joint, link)| {
            let parent_from_joint = joint.parent_from_joint.rotation.to_rotation_matrix().into_inner();
            let axis = joint.axis.into_inner();
            let cross = axis.cross_matrix();
            Body {
                kind: joint.kind,
                axis,
                parent_from_joint,
                with_sin: parent_from_joint * cross,
                with_versine: parent_from_joint * cross * cross,
                origin: joint.parent_from_joint.translation.vector,
                slide: match joint.kind {
                    JointKind::Revolute => Vector3::zeros(),
                    JointKind::Prismatic => parent_from_joint * axis,
                },
                mass: link.inertial.mass,
                center: link.inertial.center.coords,
                tensor: link.inertial.tensor,
                rotor_inertia: joint.rotor_inertia,
                damping: joint.damping,
                friction: joint.friction,
            }
        });
        let at_rest = Motion {
            parent_from_link: Matrix3::identity(),
            origin: Vector3::zeros(),
            force: Vector3::zeros(),
            moment: Vector3::zeros(),
        };
        let mut dynamics = Self {
            bodies: bodies.collect(),
            last_link: robot.links.last().map_or(Inertial::massless(), |link| link.inertial.clone()),
            gripper: robot.gripper.clone(),
            upward: -(robot.world_from_base.rotation.inverse() * gravity_world),
            scratch: vec![at_rest; dof],
            unit: vec![0.0; dof],
            zero: vec![0.0; dof],
            column: vec![0.0; dof],
        };
        dynamics.set_load(0.0, None);
        dynamics
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
        recursive_newton_euler(&self.bodies, self.upward, q, qd, qdd, &mut self.scratch, tau);
    }

    /// Torques and forces that friction takes at velocities `qd`, N·m or N: viscous and dry, with the sign of
    /// the velocity; a joint at rest takes none. To be added to [`Dynamics::inverse`].
    ///
    /// # Panics
    /// When a slice has another length than the arm has joints.
    pub fn friction(&self, qd: &[f64], out: &mut [f64]) {
        assert_eq!(qd.len(), self.bodies.len(), "velocities for another number of joints");
        assert_eq!(out.len(), self.bodies.len(), "torques for another number of joints");
        for ((body, &velocity), torque) in self.bodies.iter().zip(qd).zip(out) {
            let direction = if velocity == 0.0 { 0.0 } else { velocity.signum() };
            *torque = body.damping * velocity + body.friction * direction;
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
                &mut self.scratch,
                &mut self.column,
            );
            matrix.column_mut(k).copy_from_slice(&self.column);
        }
        // Both halves are the same number, computed in two orders.
        (&matrix + matrix.transpose()) * 0.5
    }
}

/// Outward over the links: velocity, acceleration and inertial force; inward: what the joints must bear.
fn recursive_newton_euler(
    bodies: &[Body],
    upward: Vector3<f64>,
    q: &[f64],
    qd: &[f64],
    qdd: &[f64],
    motions: &mut [Motion],
    tau: &mut [f64],
) {
    let dof = bodies.len();
    assert_eq!(q.len(), dof, "positions for another number of joints");
    assert_eq!(qd.len(), dof, "velocities for another number of joints");
    assert_eq!(qdd.len(), dof, "accelerations for another number of joints");
    assert_eq!(tau.len(), dof, "torques for another number of joints");
    // Angular velocity and acceleration of the parent, and acceleration of its origin, in its frame.
    let (mut omega, mut alpha, mut acceleration) = (Vector3::zeros(), Vector3::zeros(), upward);
    for (k, (body, motion)) in bodies.iter().zip(motions.iter_mut()).enumerate() {
        let origin = match body.kind {
            JointKind::Revolute => body.origin,
            JointKind::Prismatic => body.origin + body.slide * q[k],
        };
        let of_origin = acceleration + alpha.cross(&origin) + omega.cross(&omega.cross(&origin));
        match body.kind {
            JointKind::Revolute => {
                let (sin, cos) = q[k].sin_cos();
                motion.parent_from_link =
                    body.parent_from_joint + body.with_sin * sin + body.with_versine * (1.0 - cos);
                let (spin, spin_up) = (body.axis * qd[k], body.axis * qdd[k]);
                omega = motion.parent_from_link.tr_mul(&omega);
                alpha = motion.parent_from_link.tr_mul(&alpha) + spin_up + omega.cross(&spin);
                omega += spin;
                acceleration = motion.parent_from_link.tr_mul(&of_origin);
            }
            JointKind::Prismatic => {
                motion.parent_from_link = body.parent_from_joint;
                omega = motion.parent_from_link.tr_mul(&omega);
                alpha = motion.parent_from_link.tr_mul(&alpha);
                acceleration = motion.parent_from_link.tr_mul(&of_origin)
                    + omega.cross(&(body.axis * (2.0 * qd[k])))
                    + body.axis * qdd[k];
            }
        }
        motion.origin = origin;
        let of_center = acceleration + alpha.cross(&body.center) + omega.cross(&omega.cross(&body.center));
        motion.force = of_center * body.mass;
        motion.moment =
            body.tensor * alpha + omega.cross(&(body.tensor * omega)) + body.center.cross(&motion.force);
    }
    let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
    for k in (0..dof).rev() {
        let (body, motion) = (&bodies[k], &motions[k]);
        force += motion.force;
        moment += motion.moment;
        let borne = match body.kind {
            JointKind::Revolute => body.axis.dot(&moment),
            JointKind::Prismatic => body.axis.dot(&force),
        };
        tau[k] = borne + body.rotor_inertia * qdd[k];
        force = motion.parent_from_link * force;
        moment = motion.parent_from_link * moment + motion.origin.cross(&force);
    }
}
