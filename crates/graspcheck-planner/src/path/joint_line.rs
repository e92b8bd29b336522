//! The straight line in joint space: `q(s) = q₀ + s (q₁ − q₀)`, s from 0 to 1 (worked examples, section 1).
//!
//! Also called the direct path, or PTP with its law of time.
//!
//! ```
//! use graspcheck_planner::path::{JointLine, Path};
//!
//! let line = JointLine::new(&[0.0, 1.0], &[2.0, 0.0])?;
//! let middle = line.eval(0.5);
//! assert_eq!((middle.q, middle.q_s), (vec![1.0, 0.5], vec![2.0, -1.0]));
//! assert_eq!(middle.q_ss, [0.0, 0.0]);
//! # Ok::<(), graspcheck_planner::path::PathError>(())
//! ```

use super::{Path, PathError, PathPoint};

/// A straight line in joint space.
#[derive(Clone, Debug, PartialEq)]
pub struct JointLine {
    from: Vec<f64>,
    to: Vec<f64>,
}

impl JointLine {
    /// The line from `from` to `to`, rad or m. It may have no length.
    ///
    /// # Errors
    /// When the numbers of joints differ or a position is not finite.
    pub fn new(from: &[f64], to: &[f64]) -> Result<Self, PathError> {
        if from.len() != to.len() {
            return Err(PathError::JointCount { from: from.len(), to: to.len() });
        }
        if !from.iter().chain(to).all(|q| q.is_finite()) {
            return Err(PathError::NotFinite { quantity: "a joint position" });
        }
        Ok(Self { from: from.to_vec(), to: to.to_vec() })
    }
}

impl Path for JointLine {
    fn dof(&self) -> usize {
        self.from.len()
    }

    fn range(&self) -> [f64; 2] {
        [0.0, 1.0]
    }

    fn eval(&self, s: f64) -> PathPoint {
        assert!((0.0..=1.0).contains(&s), "s = {s} is outside the line, which runs from 0 to 1");
        let zeros = vec![0.0; self.from.len()];
        // Both ends are met to the last digit.
        let q = self.from.iter().zip(&self.to).map(|(from, to)| (1.0 - s) * from + s * to).collect();
        let q_s = self.from.iter().zip(&self.to).map(|(from, to)| to - from).collect();
        PathPoint { q, q_s, q_ss: zeros.clone(), q_sss: zeros }
    }
}
