//! How a plan is executed in simulation.
//!
//! ```
//! use graspcheck_model::execution::{Controller, Imperfections};
//!
//! // The worst of both drives: they act 2 ms late, and the torque ripples by 5 %, twelve times a turn.
//! let real = Imperfections { latency: 2e-3, torque_ripple: 0.05, ripple_waves: 12.0, ..Imperfections::default() };
//! assert!(!real.is_none());
//! assert!(Imperfections::default().is_none());
//! assert!(Controller::IdealServo.gains().is_none());
//! ```

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
    /// Time between two commands of the controller, s: a whole number of steps. Between them the command is
    /// held (zero-order hold). None: a command in every step.
    #[serde(default)]
    pub control_period: Option<f64>,
    /// How contacts are solved.
    pub contact: ContactModel,
    /// Seed of everything that is drawn at random.
    pub seed: u64,
    /// What is not as the plan and the controller believe.
    #[serde(default)]
    pub imperfections: Imperfections,
}

impl Execution {
    /// Time between two commands of the controller, s.
    #[must_use]
    pub fn command_period(&self) -> f64 {
        self.control_period.unwrap_or(self.dt)
    }
}

/// The law that turns the reference and the measured state into commands. Symbols: `q` positions, `e` and `ė` are
/// reference less measured position and velocity, ω the bandwidth, ζ the damping ratio. Torques are clamped to the
/// effort limits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Controller {
    /// τ = RNEA(q, qd, qdd_ref + 2ζω ė + ω² e) + friction of qd_ref (computed torque; Siciliano et al., *Robotics:
    /// Modelling, Planning and Control*, section 8.5.2).
    ComputedTorque {
        /// ω, rad/s.
        bandwidth: f64,
        /// ζ.
        damping_ratio: f64,
    },
    /// τ = I (ω² e + 2ζω ė) + gravity at q_ref (section 8.5.1 there). I is the diagonal of the mass matrix where the
    /// plan starts.
    GravityPd {
        /// ω, rad/s.
        bandwidth: f64,
        /// ζ.
        damping_ratio: f64,
    },
    /// τ = I (ω² e + 2ζω ė): each joint for itself (section 8.3 there), with the same I.
    JointPd {
        /// ω, rad/s.
        bandwidth: f64,
        /// ζ.
        damping_ratio: f64,
    },
    /// Each joint is driven at the velocity that brings it to its reference by the next command, by any torque
    /// within its effort limit: the servo amplifier that has no fault of its own.
    IdealServo,
}

impl Controller {
    /// Bandwidth, rad/s, and damping ratio; none for a law without gains.
    #[must_use]
    pub fn gains(&self) -> Option<(f64, f64)> {
        match *self {
            Self::ComputedTorque { bandwidth, damping_ratio }
            | Self::GravityPd { bandwidth, damping_ratio }
            | Self::JointPd { bandwidth, damping_ratio } => Some((bandwidth, damping_ratio)),
            Self::IdealServo => None,
        }
    }
}

/// What is not as the plan and the controller believe. Everything else of a run stays: the plan is that of the
/// perfect world, and its proofs are. The default is no imperfection.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Imperfections {
    /// How much heavier the object is than declared, kg; of the same density everywhere.
    pub payload: f64,
    /// Coefficient of friction that the object has instead of the declared one.
    pub object_friction: Option<f64>,
    /// Viscous and dry friction of all joints, as a share of the declared ones; none: as declared.
    pub joint_friction: Option<f64>,
    /// Step of each joint's encoder, rad or m: readings are multiples of it. 0: as fine as numbers are. Empty: all 0.
    /// Where a reading is coarse or noisy, the measured velocity is the difference of two readings over the time
    /// between two commands, else it is the true one.
    pub encoder_step: Vec<f64>,
    /// Standard deviation of each joint's reading, rad or m, before it is rounded to a step. Empty: all 0.
    pub encoder_noise: Vec<f64>,
    /// What each joint's reading is beyond its true position, rad or m. The arm starts where its readings are those
    /// of the plan. Empty: all 0.
    pub calibration: Vec<f64>,
    /// How late commands act, s: a whole number of steps.
    pub latency: f64,
    /// Amplitude of the ripple of a revolute joint's torque, as a share of the torque.
    pub torque_ripple: f64,
    /// Waves of the ripple in one turn of the joint; where they begin is drawn from the seed, for each joint.
    pub ripple_waves: f64,
    /// A push from outside.
    pub push: Option<Push>,
    /// Where the object stands instead of where it was declared: so far away in the world, m, …
    pub object_offset: [f64; 3],
    /// … and turned so far about the vertical through its origin, rad.
    pub object_yaw: f64,
}

impl Imperfections {
    /// Whether there is none.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// A force from outside on one body, at its centre of mass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Push {
    /// Name of a link, a finger or the object.
    pub body: String,
    /// When it begins, s.
    pub start: f64,
    /// How long it lasts, s.
    pub duration: f64,
    /// In the world, N.
    pub force: [f64; 3],
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
