//! Computed torque: the model's inverse dynamics around a linear error equation.
//!
//! τ = RNEA(q, qd, qdd_ref + 2ζω(qd_ref − qd) + ω²(q_ref − q)) + friction(qd_ref), clamped to the effort
//! limits (Siciliano et al., *Robotics: Modelling, Planning and Control*, section 8.5.2). Where the model
//! is right, every joint follows ë + 2ζω ė + ω² e = 0.
//!
//! Friction is fed forward at the commanded velocity: at the measured one, dry friction would change its
//! sign with every rounding error at rest.

use graspcheck_model::{dynamics::Dynamics, execution::Controller, inertia::Inertial, robot::RobotModel};
use graspcheck_motion::MotionState;
use nalgebra::Vector3;

/// The controller of the arm, with its buffers.
pub(crate) struct ComputedTorque {
    dynamics: Dynamics,
    bandwidth: f64,
    damping_ratio: f64,
    effort_limits: Vec<f64>,
    qdd: Vec<f64>,
    friction: Vec<f64>,
    commanded: Vec<f64>,
    applied: Vec<f64>,
    saturated: u32,
}

impl ComputedTorque {
    /// The controller of this robot under this gravity, m/s² in the world.
    pub(crate) fn new(robot: &RobotModel, gravity: Vector3<f64>, law: &Controller) -> Self {
        let Controller::ComputedTorque { bandwidth, damping_ratio } = *law;
        let zeros = vec![0.0; robot.dof()];
        Self {
            dynamics: Dynamics::new(robot, gravity),
            bandwidth,
            damping_ratio,
            effort_limits: robot.joints.iter().map(|joint| joint.limits.effort).collect(),
            qdd: zeros.clone(),
            friction: zeros.clone(),
            commanded: zeros.clone(),
            applied: zeros,
            saturated: 0,
        }
    }

    /// Tells the model how far the fingers are open, m, and what they hold, in the frame of the last link.
    pub(crate) fn set_load(&mut self, opening: f64, load: Option<&Inertial>) {
        self.dynamics.set_load(opening, load);
    }

    /// Computes the efforts for the reference from the measured state of the arm's joints.
    pub(crate) fn update(&mut self, reference: &MotionState, q: &[f64], qd: &[f64]) {
        let stiffness = self.bandwidth * self.bandwidth;
        let damping = 2.0 * self.damping_ratio * self.bandwidth;
        for joint in 0..self.qdd.len() {
            self.qdd[joint] = reference.qdd[joint]
                + damping * (reference.qd[joint] - qd[joint])
                + stiffness * (reference.q[joint] - q[joint]);
        }
        self.dynamics.inverse(q, qd, &self.qdd, &mut self.commanded);
        self.dynamics.friction(&reference.qd, &mut self.friction);
        self.saturated = 0;
        for joint in 0..self.commanded.len() {
            self.commanded[joint] += self.friction[joint];
            let limit = self.effort_limits[joint];
            self.applied[joint] = self.commanded[joint].clamp(-limit, limit);
            self.saturated += u32::from(self.commanded[joint].abs() > limit);
        }
    }

    /// The efforts that the law asked for, N·m or N.
    pub(crate) fn commanded(&self) -> &[f64] {
        &self.commanded
    }

    /// The efforts within the limits, N·m or N.
    pub(crate) fn applied(&self) -> &[f64] {
        &self.applied
    }

    /// How many joints were limited.
    pub(crate) fn saturated(&self) -> u32 {
        self.saturated
    }

    /// The largest |commanded effort| / limit over the joints.
    pub(crate) fn effort_ratio(&self) -> f64 {
        self.commanded
            .iter()
            .zip(&self.effort_limits)
            .fold(0.0, |worst, (effort, limit)| f64::max(worst, effort.abs() / limit))
    }
}
