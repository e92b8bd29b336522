//! Following one branch of the inverse kinematics along a path of the tool.
//!
//! A path of the tool becomes a motion of the joints by staying on the elbow's branch on which it begins and
//! in the turns of the joints that are nearest to where they just were ([`FollowedPath`](crate::path::FollowedPath)). What can go wrong is one of
//! three things (worked examples, section 7), each found, located and explained:
//!
//! - part of the path is outside the workspace: beyond the outer reach, inside the hole that two unequal links
//!   leave, or inside the hole that the limit of a joint leaves;
//! - it comes near a singularity, where the joints would have to be very fast;
//! - its end can be reached, but only on another branch, so that no continuous joint motion follows the path.
//!
//! The exception: a path that *touches* the singular circle where the arm is straight or folded changes branch
//! there at finite speed. It is named for what it is, [`BranchFault::BranchChange`], with that speed.
//!
//! ```
//! use graspcheck_model::example;
//! use graspcheck_planner::{branch::BranchFault, path::{FollowedPath, FollowError, line::straight_line}};
//! use nalgebra::Isometry3;
//!
//! // Outwards from a wrist at 5 m of an arm that reaches 7 m: out of reach after 2 m of 4, s = 1/2.
//! let (robot, from) = (example::planar(), [-0.75_f64.atan(), std::f64::consts::FRAC_PI_2, -0.927_295_218]);
//! let start = robot.world_from_tool(&from);
//! let line = straight_line(&start, &(Isometry3::translation(4.0, 0.0, 0.0) * start))?;
//! let Err(FollowError::Branch { at, fault }) = FollowedPath::new(&robot, &line, &from) else { panic!() };
//! assert!((at - 0.5).abs() < 1e-6 && matches!(fault, BranchFault::OutOfReach { .. }));
//! # Ok::<(), graspcheck_planner::path::PathError>(())
//! ```

mod fault;
mod singular;
mod tracking;

pub use fault::{BranchFault, Demand, Located};
pub(crate) use tracking::{Branch, Tracker};

/// Largest turn of a revolute joint over half of a cell of the path that is accepted as a whole, rad.
///
/// The reason: the nearest of two solutions that are whole turns apart is the right one as long as the joint
/// moves by less than half a turn; an eighth of that keeps the bounds over a cell tight.
pub const STEP_TURN: f64 = 0.4;

/// Least |sin elbow| along a path that the tool follows by inverse kinematics.
///
/// The reason: joint speeds grow with 1 / |sin elbow|; at 0.1 they are ten times those of a bent arm, and
/// the outermost 0.25 % of an arm's reach is all that is given up.
pub const SINE_MIN: f64 = 0.1;
