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
