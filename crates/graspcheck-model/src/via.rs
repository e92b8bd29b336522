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
    /// The velocity of each coordinate with which the point is met; without it that of the rule of signs
    /// ([`velocity_by_signs`]).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<f64>>,
}

/// The velocity at a point between two segments, by the rule of signs: the mean of their slopes, or 0 where these
/// differ in sign or one is 0, so that a coordinate turns round at the point itself (worked examples, section 5;
/// Biagiotti and Melchiorri, *Trajectory Planning for Automatic Machines and Robots*, section 4.3).
///
/// ```
/// use graspcheck_model::via::velocity_by_signs;
/// assert_eq!(velocity_by_signs(1.0, 3.0), 2.0);
/// assert_eq!(velocity_by_signs(1.0, -3.0), 0.0);
/// ```
#[must_use]
pub fn velocity_by_signs(before: f64, after: f64) -> f64 {
    let same_sign = (before > 0.0 && after > 0.0) || (before < 0.0 && after < 0.0);
    if same_sign { 0.5 * before + 0.5 * after } else { 0.0 }
}

impl ViaLaw {
    /// Linear functions with parabolic blends of this duration, s, at all of `points` points and in all of
    /// `coordinates` coordinates, inside the first and the last instant.
    ///
    /// ```
    /// use graspcheck_model::via::{Blend, ViaLaw};
    /// let ViaLaw::ParabolicBlends(blends) = ViaLaw::blends_of(0.5, 4, 3) else { panic!() };
    /// assert_eq!((blends.points.len(), blends.points[0].blends[2]), (4, Blend::Duration(0.5)));
    /// ```
    #[must_use]
    pub fn blends_of(duration: f64, points: usize, coordinates: usize) -> Self {
        let point =
            PointBlends { blends: vec![Blend::Duration(duration); coordinates], met: None, velocity: None };
        Self::ParabolicBlends(ParabolicBlends { points: vec![point; points], ends: BlendEnds::Inside })
    }

    /// How long after the time of the last point the motion ends, s: half of its longest blend where blends are
    /// centred, else 0. `positions[k]` is due at `times[k]`, s.
    ///
    /// A blend whose acceleration a is given takes |v|/a, v being the velocity of the last line, which begins at the
    /// later pseudo via point where the point before must be met.
    ///
    /// ```
    /// use graspcheck_model::via::{BlendEnds, ViaLaw};
    /// let mut law = ViaLaw::blends_of(0.5, 2, 1);
    /// assert_eq!(law.overrun(&[0.0, 1.0], &[vec![0.0], vec![2.0]]), 0.0);
    /// if let ViaLaw::ParabolicBlends(blends) = &mut law {
    ///     blends.ends = BlendEnds::Centred;
    /// }
    /// assert_eq!(law.overrun(&[0.0, 1.0], &[vec![0.0], vec![2.0]]), 0.25);
    /// ```
    #[must_use]
    pub fn overrun(&self, times: &[f64], positions: &[Vec<f64>]) -> f64 {
        let Self::ParabolicBlends(ParabolicBlends { points, ends: BlendEnds::Centred }) = self else {
            return 0.0;
        };
        let (Some(blends), true) = (points.last(), times.len() >= 2) else { return 0.0 };
        let last = times.len() - 1;
        let slope = |k: usize, c: usize| (positions[k][c] - positions[k - 1][c]) / (times[k] - times[k - 1]);
        let last_velocity = |c: usize| {
            let before = &points[last - 1];
            let Some(bracket) = before.met else { return slope(last, c) };
            let by_signs = || velocity_by_signs(slope(last - 1, c), slope(last, c));
            let met = before.velocity.as_ref().map_or_else(by_signs, |velocity| velocity[c]);
            let way = positions[last][c] - positions[last - 1][c] - met * bracket;
            way / (times[last] - times[last - 1] - bracket)
        };
        let half = |(c, blend): (usize, &Blend)| match *blend {
            Blend::Duration(duration) => 0.5 * duration,
            Blend::Acceleration(acceleration) => 0.5 * last_velocity(c).abs() / acceleration,
        };
        blends.blends.iter().enumerate().map(half).fold(0.0, f64::max)
    }

    /// Whether the acceleration steps by nature at points or ends.
    #[must_use]
    pub fn steps_acceleration(&self) -> bool {
        !matches!(self, Self::VirtualPoints(_))
    }
}
