//! A motion over a stretch of time instead of at an instant: bounds that hold throughout.
//!
//! A proof about time asks where a joint can be between two instants, how fast, with what acceleration and
//! jerk. The bounds here come from Bernstein coefficients on the stretch ([`bernstein::enclose`]), which are
//! safe against rounding and, unlike exact extrema, come without computing a root.

use crate::bernstein;
use crate::interval::Interval;
use crate::polynomial::Polynomial;
use crate::trajectory::Trajectory;

/// Bounds on position, velocity, acceleration and jerk of all joints over a stretch of time, SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionBounds {
    /// Positions, rad or m.
    pub q: Vec<Interval>,
    /// Velocities, rad/s or m/s.
    pub qd: Vec<Interval>,
    /// Accelerations, rad/s² or m/s².
    pub qdd: Vec<Interval>,
    /// Jerks, rad/s³ or m/s³.
    pub qddd: Vec<Interval>,
}

impl MotionBounds {
    /// Bounds of `dof` zeros, to be filled by [`Trajectory::enclose_into`].
    #[must_use]
    pub fn zeros(dof: usize) -> Self {
        let zeros = vec![Interval::ZERO; dof];
        Self { q: zeros.clone(), qd: zeros.clone(), qdd: zeros.clone(), qddd: zeros }
    }
}

impl Polynomial {
    /// Bounds on position, velocity, acceleration and jerk over the local times from `a` to `b`, s; see
    /// [`bernstein::enclose`].
    ///
    /// ```
    /// use graspcheck_motion::Polynomial;
    /// let [q, qd, ..] = Polynomial::new([1.0, 2.0]).enclose(0.0, 0.5);
    /// assert!(q.contains(1.0) && q.contains(2.0) && q.width() < 1.0 + 1e-12);
    /// assert!(qd.contains(2.0) && qd.width() < 1e-12);
    /// ```
    #[must_use]
    pub fn enclose(&self, a: f64, b: f64) -> [Interval; 4] {
        bernstein::enclose(self, a, b)
    }
}

impl Trajectory {
    /// Bounds on the motion of one joint between `t0` and `t1`, s: position, velocity, acceleration and jerk.
    /// At `t0` the limit from the right counts, at `t1` the limit from the left, at knots between them both;
    /// what [`Trajectory::eval`] gives at `t1`, from the right, does not count.
    ///
    /// # Panics
    /// When `joint` is out of range, or not `0 ≤ t0 ≤ t1 ≤ duration`.
    ///
    /// ```
    /// use graspcheck_motion::{Polynomial, Trajectory};
    /// let swing = Polynomial::quintic_hermite([0.0; 3], [1.0, 0.0, 0.0], 2.0);
    /// let motion = Trajectory::new(1, vec![0.0, 2.0], vec![swing])?;
    /// let [q, qd, ..] = motion.enclose(0, 0.9, 1.1);
    /// assert!(q.contains(0.5) && qd.contains(0.9375) && qd.upper() < 0.95);
    /// # Ok::<(), graspcheck_motion::TrajectoryError>(())
    /// ```
    #[must_use]
    pub fn enclose(&self, joint: usize, t0: f64, t1: f64) -> [Interval; 4] {
        let bounds = self.stretches(joint, t0, t1).map(|part| part.polynomial.enclose(part.from, part.to));
        bounds
            .reduce(|mut all, next| {
                for (all, next) in all.iter_mut().zip(next) {
                    *all = all.hull(next);
                }
                all
            })
            .unwrap_or([Interval::WHOLE; 4])
    }

    /// As [`Trajectory::enclose`] for all joints, into bounds that are there already; allocates nothing.
    ///
    /// # Panics
    /// When not `0 ≤ t0 ≤ t1 ≤ duration`, or `bounds` was made for another number of joints.
    pub fn enclose_into(&self, t0: f64, t1: f64, bounds: &mut MotionBounds) {
        assert_eq!(bounds.q.len(), self.dof(), "the bounds have another number of joints");
        for joint in 0..self.dof() {
            let [q, qd, qdd, qddd] = self.enclose(joint, t0, t1);
            bounds.q[joint] = q;
            bounds.qd[joint] = qd;
            bounds.qdd[joint] = qdd;
            bounds.qddd[joint] = qddd;
        }
    }
}
