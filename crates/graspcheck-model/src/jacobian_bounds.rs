//! How far the Jacobian of the tool can change over a stretch of time, for any serial arm.
//!
//! A singular value differs between two matrices by at most the norm of their difference (Weyl), so that the least
//! singular value in the middle of a stretch, less this bound, is a lower bound on it throughout.
//!
//! ```
//! use graspcheck_model::{chain::SerialChain, example, jacobian_bounds::JacobianBounds};
//! use graspcheck_motion::{Polynomial, Trajectory};
//!
//! // The elbow of the planar arm goes from 0.5 to 0.6 rad: its singular value cannot vanish on the way.
//! let still = Polynomial::constant(0.0);
//! let motion = Trajectory::new(3, vec![0.0, 1.0], vec![still, Polynomial::new([0.5, 0.1]), still])?;
//! let chain = SerialChain::of(&example::planar());
//! let mut room = JacobianBounds::new(&chain, &motion, 8.0);
//! let least = chain.dexterity(&motion.eval(0.5).q, 8.0).smallest();
//! let change = room.change(0, [0.0, 1.0]);
//! assert!(0.0 < change && change < least, "{change}, {least}");
//! # Ok::<(), graspcheck_motion::TrajectoryError>(())
//! ```

use graspcheck_motion::{Scalar, Trajectory};

use crate::{
    chain::SerialChain,
    majorant::{self, JointReach, JointStretch, Link, MAJORANT_ROUNDING, Majorant},
    robot::JointKind,
};

/// Bounds on how far the Jacobian changes in one motion of one arm.
#[derive(Clone, Debug)]
pub struct JacobianBounds<'a> {
    motion: &'a Trajectory,
    joints: Vec<JointReach>,
    /// Distance of the tool from the last link's origin, m; in a planar arm across the axes.
    offset: f64,
    size: f64,
    links: Vec<Link>,
}

impl<'a> JacobianBounds<'a> {
    /// For `motion` of the arm `chain`, distances in units of `size` (m) as in [`SerialChain::dexterity`].
    ///
    /// # Panics
    /// When the motion is of another number of joints, or `size` is not positive.
    #[must_use]
    pub fn new(chain: &SerialChain, motion: &'a Trajectory, size: f64) -> Self {
        let hinges = chain.hinges();
        assert_eq!(motion.dof(), hinges.len(), "a motion of another number of joints");
        assert!(size > 0.0, "a size of {size} m");
        let planar = majorant::is_planar(hinges);
        let tool = chain.tool_in_last_link();
        let offset = match hinges.last() {
            Some(last) if planar => tool.cross(&last.axis).norm(),
            _ => tool.norm(),
        };
        let joints: Vec<JointReach> = hinges.iter().map(|hinge| JointReach::of(hinge, planar)).collect();
        let links = vec![Link::base(); joints.len()];
        Self { motion, joints, offset, size, links }
    }

    /// A bound on the Frobenius norm of the difference between the Jacobian in the middle of a stretch (two instants,
    /// s, of one piece) and that at any other of its instants.
    ///
    /// # Panics
    /// When there is no such piece.
    pub fn change(&mut self, piece: usize, [from, to]: [f64; 2]) -> f64 {
        let knots = self.motion.knots();
        let start = knots[piece];
        let length = knots[piece + 1] - start;
        let mut link = Link::base();
        for (k, polynomial) in self.motion.piece_of_all(piece).iter().enumerate() {
            let terms = majorant::terms(polynomial, length);
            let stretch = JointStretch::new(polynomial, [from - start, to - start], &terms);
            link = link.next(self.joints[k], &stretch.position);
            self.links[k] = link;
        }
        // From a joint's origin to the tool.
        let mut reach: Majorant = link.unit.scaled(self.offset);
        let mut square = 0.0;
        for (joint, link) in self.joints.iter().zip(&self.links).rev() {
            let [axis_rate, reach_rate] = match joint.kind {
                JointKind::Revolute => {
                    [link.axis.coefficients[1], (link.axis * reach).coefficients[1] / self.size]
                }
                // Its column is the axis, as a velocity.
                JointKind::Prismatic => [0.0, link.axis.coefficients[1] / self.size],
            };
            square += axis_rate * axis_rate + reach_rate * reach_rate;
            reach = reach + link.arm;
        }
        let half = 0.5 * (to - from) + 4.0 * f64::EPSILON * to;
        square.sqrt() * half * (1.0 + MAJORANT_ROUNDING)
    }
}
