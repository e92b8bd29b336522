//! Why an arm cannot bring its tool to a pose: which bound is in the way, and by how much.
//!
//! An arm of two links of lengths l₁ and l₂ reaches wrist distances r from its first axis with
//! `r² = l₁² + l₂² + 2 l₁ l₂ cos φ₂`: at most l₁ + l₂, at least |l₁ − l₂|. A limit of the elbow short of folding
//! leaves a larger hole: the SCARA with links of 0.25 m and 0.20 m and an elbow of ±120° has one of 0.229129 m.
//!
//! ```
//! use graspcheck_model::{Pose, example, inverse::InverseKinematics, reach::OutOfReach};
//! use nalgebra::Translation3;
//!
//! let robot = example::scara();
//! let inverse = InverseKinematics::new(&robot)?;
//! let stretched = robot.world_from_tool(&[0.0; 4]); // 0.45 m from axis 1
//! let in_the_hole = Translation3::new(-0.25, 0.0, 0.0) * stretched;
//! let why = inverse.legal(&in_the_hole).expect_err("0.2 m is too near");
//! assert!(matches!(why, OutOfReach::InsideElbowLimit { shortfall, .. } if (shortfall - 0.029_129).abs() < 1e-6));
//! # Ok::<(), graspcheck_model::inverse::Unreachable>(())
//! ```

use crate::{
    Pose,
    inverse::{BranchName, InverseKinematics, InverseSolution, LimitViolation, Unreachable},
};

/// Why no joint positions within the limits reach a pose.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OutOfReach {
    /// No joint positions reach it, whatever the limits.
    #[error(transparent)]
    Whatever(#[from] Unreachable),
    /// The wrist would be nearer to axis 1 than the elbow's limits let it come.
    #[error(
        "wrist: {distance:.6} m from axis 1 is inside the hole of radius {hole:.6} m that joint {joint} leaves at its \
         limit of {limit:.6} rad, by {shortfall:.6} m: move the pose outwards or widen the limit"
    )]
    InsideElbowLimit {
        /// Name of the elbow's joint.
        joint: String,
        /// Of the wrist from axis 1, m.
        distance: f64,
        /// The least distance within the limits, m.
        hole: f64,
        /// The elbow's limit that makes it, rad.
        limit: f64,
        /// How much too near, m.
        shortfall: f64,
    },
    /// The wrist would be farther from axis 1 than the elbow's limits let it go.
    #[error(
        "wrist: {distance:.6} m from axis 1 exceeds the {reach:.6} m that joint {joint} leaves at its limit of \
         {limit:.6} rad by {excess:.6} m: move the pose inwards or widen the limit"
    )]
    BeyondElbowLimit {
        /// Name of the elbow's joint.
        joint: String,
        /// Of the wrist from axis 1, m.
        distance: f64,
        /// The largest distance within the limits, m.
        reach: f64,
        /// The elbow's limit that makes it, rad.
        limit: f64,
        /// How much too far, m.
        excess: f64,
    },
    /// The wrist can be there, but on every branch a joint would have to pass a limit.
    #[error(
        "joint {joint}: {:.6} passes its limit of {:.6} by {:.6} even on the nearest branch ({branch}): widen the \
         limit or move the pose",
        violation.value, violation.limit, violation.excess
    )]
    JointLimit {
        /// Name of the joint that passes a limit by most.
        joint: String,
        /// What it would have to do.
        violation: LimitViolation,
        /// The branch on which the least is lacking.
        branch: BranchName,
    },
}

impl InverseKinematics {
    /// All ways to reach a pose of the tool within the joints' limits, as [`InverseKinematics::solve`] orders them;
    /// never none.
    ///
    /// # Errors
    /// When there is none, with the bound that is in the way and by how much.
    pub fn legal(&self, world_from_tool: &Pose) -> Result<Vec<InverseSolution>, OutOfReach> {
        let (legal, illegal): (Vec<InverseSolution>, Vec<InverseSolution>) =
            self.solve(world_from_tool)?.into_iter().partition(InverseSolution::is_legal);
        if !legal.is_empty() {
            return Ok(legal);
        }
        let distance = self.wrist_distance(world_from_tool)?;
        Err(self.elbow_in_the_way(distance).unwrap_or_else(|| self.joint_in_the_way(&illegal)))
    }

    /// The elbow's limits, when they alone keep the wrist from this distance.
    fn elbow_in_the_way(&self, distance: f64) -> Option<OutOfReach> {
        const ELBOW: usize = 1;
        let reach = self.reach();
        let joint = self.joint_names[ELBOW].clone();
        let limits = &self.limits[ELBOW];
        // Of the two limits the one at which the wrist is nearest to this radius.
        let limit_at = |radius: f64| {
            let off = |limit: &f64| (self.distance_at(*limit) - radius).abs();
            let [low, high] = [limits.position_min, limits.position_max];
            if off(&low) < off(&high) { low } else { high }
        };
        if distance < reach.inner {
            let (hole, shortfall) = (reach.inner, reach.inner - distance);
            return Some(OutOfReach::InsideElbowLimit {
                joint,
                distance,
                hole,
                limit: limit_at(hole),
                shortfall,
            });
        }
        if distance > reach.outer {
            let (limit, excess) = (limit_at(reach.outer), distance - reach.outer);
            return Some(OutOfReach::BeyondElbowLimit { joint, distance, reach: reach.outer, limit, excess });
        }
        None
    }

    /// The violation of the solution of which the worst joint lacks least.
    fn joint_in_the_way(&self, illegal: &[InverseSolution]) -> OutOfReach {
        let worst = |solution: &InverseSolution| {
            solution.violations.iter().copied().max_by(|a, b| a.excess.total_cmp(&b.excess))
        };
        let (branch, violation) = illegal
            .iter()
            .filter_map(|solution| Some((solution.name, worst(solution)?)))
            .min_by(|a, b| a.1.excess.total_cmp(&b.1.excess))
            .expect(
                "a solution that is not legal breaks a limit, and there are solutions of every pose in reach",
            );
        OutOfReach::JointLimit { joint: self.joint_names[violation.joint].clone(), violation, branch }
    }
}
