//! A cubic spline through joint positions: geometry alone, without times.
//!
//! The parameter runs from 0 to 1 in proportion to the straight ways between the points (chord length; Piegl and
//! Tiller, *The NURBS Book*, 2nd edition, section 9.2.1):
//!
//! ```text
//! s₀ = 0,   sₖ = sₖ₋₁ + |qₖ − qₖ₋₁| / Σ |qⱼ − qⱼ₋₁|
//! ```
//!
//! so that points that lie unevenly make no loops. Between two points q(s) is a cubic; slope and bend are continuous at
//! every point. The systems of equations and the conditions at the ends are those of [`crate::via::spline`].
//!
//! ```
//! use graspcheck_planner::{path::{JointSpline, Path}, via::spline::{SplineEnd, SplineEnds}};
//!
//! let points = [[0.0, 0.0], [1.0, 0.5], [2.0, 0.0]].map(|q| q.to_vec());
//! let path = JointSpline::new(&points, &SplineEnds::both(SplineEnd::Natural))?;
//! let middle = path.eval(0.5);
//! assert_eq!(middle.q, [1.0, 0.5]);
//! assert!(middle.q_s[1].abs() < 1e-15 && middle.q_ss[1] < 0.0); // its highest place
//! # Ok::<(), graspcheck_planner::path::PathError>(())
//! ```

use graspcheck_motion::Trajectory;

use super::{NOTHING, Path, PathError, PathPoint};
use crate::via::{
    ViaPoints,
    spline::{SplineEnds, through},
};

/// A C² path of the joints through points.
#[derive(Clone, Debug, PartialEq)]
pub struct JointSpline {
    /// The joints, with s in the place of time.
    by_s: Trajectory,
}

impl JointSpline {
    /// The spline through these joint positions, rad or m, under these conditions at its ends (velocities and
    /// accelerations there are derivatives by s).
    ///
    /// # Errors
    /// When there are fewer than two points, two neighbours are the same, or a number is not finite or missing.
    pub fn new(points: &[Vec<f64>], ends: &SplineEnds) -> Result<Self, PathError> {
        let way = |pair: &[Vec<f64>]| {
            pair[0].iter().zip(&pair[1]).map(|(a, b)| (b - a) * (b - a)).sum::<f64>().sqrt()
        };
        let places = shares(points.windows(2).map(way))?;
        Ok(Self { by_s: through(&ViaPoints::new(places, points.to_vec())?, ends)? })
    }
}

impl Path for JointSpline {
    fn dof(&self) -> usize {
        self.by_s.dof()
    }

    fn range(&self) -> [f64; 2] {
        [0.0, 1.0]
    }

    fn eval(&self, s: f64) -> PathPoint {
        assert!((0.0..=1.0).contains(&s), "s = {s} is outside the spline, which runs from 0 to 1");
        let state = self.by_s.eval(s);
        PathPoint { q: state.q, q_s: state.qd, q_ss: state.qdd, q_sss: state.qddd }
    }
}

/// The path parameter at each of the points between which these ways lie, from 0 to 1.
///
/// # Errors
/// When two points are the same. Ways that are not finite are for whoever reads the points.
pub(super) fn shares(ways: impl Iterator<Item = f64>) -> Result<Vec<f64>, PathError> {
    let mut places = vec![0.0];
    for (k, way) in ways.enumerate() {
        if way <= NOTHING {
            return Err(PathError::SamePoint { point: k + 2, way });
        }
        places.push(places[k] + way);
    }
    let length = places[places.len() - 1];
    let last = places.len() - 1;
    for place in &mut places[..last] {
        *place /= length;
    }
    if last > 0 {
        // The end itself, not the end up to rounding.
        places[last] = 1.0;
    }
    Ok(places)
}
