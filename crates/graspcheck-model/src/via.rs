//! Via points: how a motion passes the points that it is given.
//!
//! The laws themselves, with their formulas, stand in the planner's modules `via` and `lfpb`.

use serde::{Deserialize, Serialize};

/// How the parabolic blend at a point is given; the other quantity follows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Blend {
    /// How long it takes, s.
    Duration(f64),
    /// The magnitude of its acceleration, per s².
    Acceleration(f64),
}

/// Where the blends of the first and the last point of a motion with parabolic blends lie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BlendEnds {
    /// After the first instant and before the last: the motion lasts from t₁ to t_N.
    #[default]
    Inside,
    /// Half before and half after: the motion lasts from t₁ - b₁/2 to t_N + b_N/2.
    Centred,
}

/// How a motion goes through its points. Lists have an entry for each point and in it one for each coordinate:
/// a joint, or x, y (m) and theta (rad) of a wrist.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ViaLaw {
    /// Cubics with these velocities at the points.
    ImposedVelocities(Vec<Vec<f64>>),
    /// Cubics from rest to rest with the velocities of the rule of signs.
    ComputedVelocities,
    /// A cubic spline.
    Spline(EndCondition),
    /// A cubic spline from rest to rest without a step of acceleration, by virtual points at these times, s.
    VirtualPoints([f64; 2]),
    /// Near the points by linear functions with parabolic blends (LFPB).
    ParabolicBlends(ParabolicBlends),
}

/// What holds at both ends of a spline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EndCondition {
    /// No velocity.
    AtRest,
    /// No acceleration.
    Natural,
    /// The first two pieces are one cubic, and so are the last two.
    NotAKnot,
    /// Velocity and acceleration are the same at both ends.
    Periodic,
}

/// The blends of an LFPB motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParabolicBlends {
    /// For each point.
    pub points: Vec<PointBlends>,
    /// Where the blends of the first and the last point lie.
    pub ends: BlendEnds,
}

/// The blends at a point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointBlends {
    /// For each coordinate; where the point must be met, the blend of both pseudo via points.
    pub blends: Vec<Blend>,
    /// How long before and after the point its pseudo via points are due, s, when it must be met; without
    /// them it is passed near.
    pub met: Option<f64>,
}

impl ViaLaw {
    /// Linear functions with parabolic blends of this duration, s, at all of `points` points and in all of
    /// `coordinates` coordinates, inside the first and the last instant.
    #[must_use]
    pub fn blends_of(duration: f64, points: usize, coordinates: usize) -> Self {
        let point = PointBlends { blends: vec![Blend::Duration(duration); coordinates], met: None };
        Self::ParabolicBlends(ParabolicBlends { points: vec![point; points], ends: BlendEnds::Inside })
    }

    /// Whether the acceleration steps by nature at points or ends.
    #[must_use]
    pub fn steps_acceleration(&self) -> bool {
        !matches!(self, Self::VirtualPoints(_))
    }
}
