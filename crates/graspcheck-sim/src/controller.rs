//! The controllers of the arm: from the reference and the joints as read to what the drives are told.
//!
//! The laws are those of [`Controller`]. Computed torque is the model's inverse dynamics around a linear error
//! equation: where the model is right, every joint follows ë + 2ζω ė + ω² e = 0.
//!
//! Friction is fed forward at the commanded velocity: at the measured one, dry friction would change its
//! sign with every rounding error at rest.

use graspcheck_model::{
    dynamics::Dynamics,
    execution::{Controller, Execution},
    inertia::Inertial,
    robot::RobotModel,
};
use graspcheck_motion::MotionState;
use nalgebra::Vector3;

/// What the drives of the arm's joints are told.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Command {
    /// Efforts within the limits, N·m or N.
    pub(crate) efforts: Vec<f64>,
    /// Velocities, rad/s or m/s: what a servo is told.
    pub(crate) velocities: Vec<f64>,
}

impl Command {
    pub(crate) fn zeros(dof: usize) -> Self {
        Self { efforts: vec![0.0; dof], velocities: vec![0.0; dof] }
    }

    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.efforts.copy_from_slice(&other.efforts);
        self.velocities.copy_from_slice(&other.velocities);
    }
}

/// The controller of the arm, with its buffers.
pub(crate) struct ArmController {
    law: Controller,
    period: f64,
    dynamics: Dynamics,
    effort_limits: Vec<f64>,
    /// The diagonal of the mass matrix where the plan starts, kg·m² or kg.
    inertia: Vec<f64>,
    at_rest: Vec<f64>,
    qdd: Vec<f64>,
    friction: Vec<f64>,
    asked: Vec<f64>,
    command: Command,
}

impl ArmController {
    /// The controller of this robot under this gravity, m/s² in the world, for a plan that starts at `start` with
    /// the gripper at `opening`, m.
    pub(crate) fn new(
        robot: &RobotModel,
        gravity: Vector3<f64>,
        execution: &Execution,
        start: &[f64],
        opening: f64,
    ) -> Self {
        let dof = robot.dof();
        let mut dynamics = Dynamics::new(robot, gravity);
        dynamics.set_load(opening, None);
        let inertia = dynamics.mass_matrix(start).diagonal().as_slice().to_vec();
        Self {
            law: execution.controller,
            period: execution.command_period(),
            dynamics,
            effort_limits: robot.joints.iter().map(|joint| joint.limits.effort).collect(),
            inertia,
            at_rest: vec![0.0; dof],
            qdd: vec![0.0; dof],
            friction: vec![0.0; dof],
            asked: vec![0.0; dof],
            command: Command::zeros(dof),
        }
    }

    /// Tells the model how far the fingers are open, m, and what they hold, in the frame of the last link.
    pub(crate) fn set_load(&mut self, opening: f64, load: Option<&Inertial>) {
        self.dynamics.set_load(opening, load);
    }

    /// Computes the command for the reference now and at the next command, from positions and velocities of the
    /// arm's joints as read.
    pub(crate) fn update(&mut self, reference: &MotionState, next: &MotionState, q: &[f64], qd: &[f64]) {
        match self.law {
            Controller::ComputedTorque { bandwidth, damping_ratio } => {
                self.correct(bandwidth, damping_ratio, reference, q, qd);
                for (qdd, feed_forward) in self.qdd.iter_mut().zip(&reference.qdd) {
                    *qdd += feed_forward;
                }
                self.dynamics.inverse(q, qd, &self.qdd, &mut self.asked);
                self.dynamics.friction(&reference.qd, &mut self.friction);
                add(&mut self.asked, &self.friction);
            }
            Controller::GravityPd { bandwidth, damping_ratio } => {
                self.correct(bandwidth, damping_ratio, reference, q, qd);
                self.dynamics.inverse(&reference.q, &self.at_rest, &self.at_rest, &mut self.asked);
                self.add_inertial();
            }
            Controller::JointPd { bandwidth, damping_ratio } => {
                self.correct(bandwidth, damping_ratio, reference, q, qd);
                self.asked.fill(0.0);
                self.add_inertial();
            }
            Controller::IdealServo => {
                for joint in 0..q.len() {
                    let velocity = (next.q[joint] - q[joint]) / self.period;
                    self.command.velocities[joint] = velocity;
                    self.qdd[joint] = (velocity - qd[joint]) / self.period;
                }
                // What the motion takes: the servo itself finds its torque from the error of velocity.
                self.dynamics.inverse(q, qd, &self.qdd, &mut self.asked);
                self.dynamics.friction(&self.command.velocities, &mut self.friction);
                add(&mut self.asked, &self.friction);
            }
        }
        for ((effort, asked), limit) in
            self.command.efforts.iter_mut().zip(&self.asked).zip(&self.effort_limits)
        {
            *effort = asked.clamp(-limit, *limit);
        }
    }

    /// Sets `qdd` to ω² e + 2ζω ė.
    fn correct(
        &mut self,
        bandwidth: f64,
        damping_ratio: f64,
        reference: &MotionState,
        q: &[f64],
        qd: &[f64],
    ) {
        let stiffness = bandwidth * bandwidth;
        let damping = 2.0 * damping_ratio * bandwidth;
        for joint in 0..self.qdd.len() {
            self.qdd[joint] =
                damping * (reference.qd[joint] - qd[joint]) + stiffness * (reference.q[joint] - q[joint]);
        }
    }

    /// Adds what `qdd` takes of each joint alone.
    fn add_inertial(&mut self) {
        for ((asked, inertia), qdd) in self.asked.iter_mut().zip(&self.inertia).zip(&self.qdd) {
            *asked += inertia * qdd;
        }
    }

    /// The efforts that the law asked for, before they were limited, N·m or N.
    pub(crate) fn asked(&self) -> &[f64] {
        &self.asked
    }

    /// What the drives are told.
    pub(crate) fn command(&self) -> &Command {
        &self.command
    }
}

/// Adds the second to the first, joint by joint.
fn add(sum: &mut [f64], more: &[f64]) {
    sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
}
