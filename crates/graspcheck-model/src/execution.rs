//! How a plan is executed in simulation.

use serde::{Deserialize, Serialize};

/// How a plan is executed in simulation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Execution {
    /// Step of the physics, s; divides one second.
    pub dt: f64,
    /// Solver substeps in one step.
    pub substeps: usize,
    /// How long the simulation goes on at rest after the plan's end, s.
    pub settle: f64,
    /// The controller and its gains.
    pub controller: Controller,
    /// How contacts are solved.
    pub contact: ContactModel,
    /// Seed of everything that is drawn at random.
    pub seed: u64,
}

/// The law that turns the reference and the measured state into torques.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Controller {
    /// τ = RNEA(q, qd, qdd_ref + 2ζω(qd_ref - qd) + ω²(q_ref - q)) + friction feed-forward, clamped to
    /// the effort limits (computed torque; Siciliano et al., *Robotics: Modelling, Planning and Control*,
    /// section 8.5.2).
    ComputedTorque {
        /// ω, rad/s.
        bandwidth: f64,
        /// ζ.
        damping_ratio: f64,
    },
}

/// How contacts are solved: a spring-damper of this frequency and damping ratio at every contact point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactModel {
    /// Natural frequency, Hz.
    pub frequency: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
    /// Distance at which contacts are predicted, m.
    pub prediction: f64,
    /// Coefficient of friction of fingers and cell (the average with the object's is used).
    pub friction: f64,
}
