//! Inverse kinematics of any serial arm, by damped least squares.
//!
//! Where no closed form fits, the joint positions that bring the tool to a pose are searched: from a start, each
//! step solves `(JᵀJ + λ 1) Δq = Jᵀ e` for the error e between the pose wanted and the pose that the arm has. The
//! damping λ keeps steps small near singular poses, falls while steps succeed and rises when one does not
//! (Levenberg–Marquardt; Nakamura, Hanafusa, "Inverse kinematic solutions with singularity robustness", 1986;
//! Buss, "Introduction to inverse kinematics", 2004, section 6). A joint that a step would push through its limit
//! stays there and the others go on (projection with an active set). Where that ends beside the pose, in a local
//! minimum, the search is made again with revolute joints free to turn through their limits, and counts if whole
//! turns bring them back between. Then it starts again from positions drawn between the limits by a seeded
//! generator: the same question has the same answer on every machine.
//!
//! The error compares metres with radians: distances count in units of the arm's size.
//!
//! What is found is one solution, not all. That none is found proves nothing; the closed forms of
//! [`inverse`](crate::inverse) do.
//!
//! ```
//! use graspcheck_model::{example, numerical::NumericalInverse};
//!
//! let robot = example::scara();
//! let inverse = NumericalInverse::new(&robot)?;
//! let wanted = robot.world_from_tool(&[0.5, -1.0, -0.1, 2.0]);
//! let found = inverse.solve(&wanted, &[0.0; 4], 1)?;
//! let reached = robot.world_from_tool(&found.q);
//! assert!((reached.translation.vector - wanted.translation.vector).norm() < 1e-9);
//! # Ok::<(), graspcheck_model::numerical::NumericalError>(())
//! ```

use std::{f64::consts::TAU, fmt};

use nalgebra::{DMatrix, DVector, Vector6};
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{RngCore, SeedableRng},
};

use crate::{
    Pose,
    chain::SerialChain,
    inverse::POSE_TOLERANCE,
    robot::{Joint, JointKind, RobotModel},
};

/// How many searches begin from drawn positions after the one from the start given. On the six-joint arm of the
/// tests, with limits of less than a turn, nine of ten poses are found by the first three, and the worst of a
/// thousand by the eighteenth.
pub const RESTARTS: usize = 100;

/// How many steps a search takes at most: near a solution the digits double with every step, and a search that
/// crawls is better begun anew.
const MOST_STEPS: usize = 200;

/// Where an arm ended beside the pose wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// Distance of the tool's origin from where it should be, m.
    pub distance: f64,
    /// Angle of the rotation that is lacking, rad.
    pub angle: f64,
}

/// Joint positions that reach a pose.
#[derive(Clone, Debug, PartialEq)]
pub struct NumericalSolution {
    /// Joint positions from base to tool, all within their limits, rad or m.
    pub q: Vec<f64>,
    /// What is left; at most [`POSE_TOLERANCE`] each.
    pub residual: Residual,
    /// How many searches it took: 1 when the start led to it.
    pub searches: usize,
}

/// A joint that stands at a limit and would have to pass it.
#[derive(Clone, Debug, PartialEq)]
pub struct ActiveLimit {
    /// Name of the joint.
    pub joint: String,
    /// The limit, rad or m.
    pub limit: f64,
    /// Whether it is the upper one.
    pub upper: bool,
}

impl fmt::Display for ActiveLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let side = if self.upper { "upper" } else { "lower" };
        write!(f, "joint {} stands at its {side} limit of {:.6}", self.joint, self.limit)
    }
}

/// Why no joint positions are given.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NumericalError {
    /// Between the limits of a joint nothing can be drawn.
    #[error("joint {joint}: position limits from {lower} to {upper} must be finite and in order")]
    Limits {
        /// Name of the joint.
        joint: String,
        /// Its lower limit, rad or m.
        lower: f64,
        /// Its upper limit, rad or m.
        upper: f64,
    },
    /// The start is of another arm.
    #[error("start: {count} positions for an arm of {dof} joints")]
    WrongLength {
        /// How many positions were given.
        count: usize,
        /// How many joints the arm has.
        dof: usize,
    },
    /// The start is outside a joint's limits, or not a number.
    #[error("start: joint {joint} at {value} must be between {lower} and {upper}")]
    StartOutside {
        /// Name of the joint.
        joint: String,
        /// Its position, rad or m.
        value: f64,
        /// Its lower limit, rad or m.
        lower: f64,
        /// Its upper limit, rad or m.
        upper: f64,
    },
    /// A coordinate of the pose is NaN or infinite.
    #[error("tool pose: a coordinate is not finite")]
    NotFinite,
    /// Every search ended beside the pose.
    #[error(
        "tool pose: the nearest of {searches} searches is off by {:.3e} m and {:.3e} rad{}",
        residual.distance, residual.angle, advice(active)
    )]
    NotFound {
        /// What is lacking at best.
        residual: Residual,
        /// The joint positions there, rad or m.
        q: Vec<f64>,
        /// The joints that would have to pass a limit to come nearer; none when the arm is too short, or cannot
        /// turn its tool so.
        active: Vec<ActiveLimit>,
        /// How many searches there were.
        searches: usize,
    },
}

/// What to change when a search ended with these joints at their limits.
fn advice(active: &[ActiveLimit]) -> String {
    if active.is_empty() {
        return "; no limit is in the way: the pose is out of reach, move it or turn it".to_owned();
    }
    let limits: Vec<String> = active.iter().map(ToString::to_string).collect();
    format!("; {}: widen the limit or move the pose", limits.join(", "))
}

/// The numerical inverse kinematics of one arm.
#[derive(Clone, Debug)]
pub struct NumericalInverse {
    chain: SerialChain,
    names: Vec<String>,
    limits: Limits,
    /// As the limits, but revolute joints turn freely.
    without_stops: Limits,
    /// Of the arm, m: what a radian is compared with.
    size: f64,
}

/// Position limits of all joints, rad or m.
#[derive(Clone, Debug)]
struct Limits {
    lower: DVector<f64>,
    upper: DVector<f64>,
}

/// Where a search is.
struct State {
    q: DVector<f64>,
    /// Rotation and translation that are lacking, the latter in units of the arm's size.
    error: Vector6<f64>,
    residual: Residual,
}

impl NumericalInverse {
    /// The numerical inverse kinematics of `robot`, whatever its structure.
    ///
    /// # Errors
    /// When a position limit is infinite or NaN, or the limits of a joint are in the wrong order.
    pub fn new(robot: &RobotModel) -> Result<Self, NumericalError> {
        let mut size = robot.link_from_tool.translation.vector.norm();
        for joint in &robot.joints {
            let (lower, upper) = (joint.limits.position_min, joint.limits.position_max);
            if !(lower.is_finite() && upper.is_finite() && lower <= upper) {
                return Err(NumericalError::Limits { joint: joint.name.clone(), lower, upper });
            }
            size += joint.parent_from_joint.translation.vector.norm();
            if joint.kind == JointKind::Prismatic {
                size += lower.abs().max(upper.abs());
            }
        }
        let limits = Limits::of(robot, |joint| [joint.limits.position_min, joint.limits.position_max]);
        let without_stops = Limits::of(robot, |joint| match joint.kind {
            JointKind::Revolute => [f64::NEG_INFINITY, f64::INFINITY],
            JointKind::Prismatic => [joint.limits.position_min, joint.limits.position_max],
        });
        Ok(Self {
            chain: SerialChain::of(robot),
            names: robot.joints.iter().map(|joint| joint.name.clone()).collect(),
            limits,
            without_stops,
            size: if size > 0.0 { size } else { 1.0 },
        })
    }

    /// Joint positions within their limits that bring the tool to a pose, to [`POSE_TOLERANCE`]: searched first
    /// from `start` (rad or m), then from positions drawn with `seed`.
    ///
    /// # Errors
    /// When the start does not fit the arm or its limits, the pose is not finite, or every search ended beside the
    /// pose: then with the best that was found and the limits that were in the way.
    pub fn solve(
        &self,
        world_from_tool: &Pose,
        start: &[f64],
        seed: u64,
    ) -> Result<NumericalSolution, NumericalError> {
        self.check_start(start)?;
        if !world_from_tool.to_homogeneous().iter().all(|value| value.is_finite()) {
            return Err(NumericalError::NotFinite);
        }
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut from = DVector::from_column_slice(start);
        let mut best: Option<State> = None;
        for search in 1..=RESTARTS + 1 {
            let found = self.search(world_from_tool, &from, &self.limits);
            let found = if found.is_reached() {
                found
            } else {
                self.search_through_stops(world_from_tool, &from).unwrap_or(found)
            };
            if found.is_reached() {
                let State { q, residual, .. } = found;
                return Ok(NumericalSolution { q: q.as_slice().to_vec(), residual, searches: search });
            }
            if best.as_ref().is_none_or(|best| found.error.norm() < best.error.norm()) {
                best = Some(found);
            }
            let Limits { lower, upper } = &self.limits;
            from = DVector::from_fn(from.len(), |k, _| lower[k] + share(&mut random) * (upper[k] - lower[k]));
        }
        let best = best.expect("there was a search");
        Err(NumericalError::NotFound {
            residual: best.residual,
            active: self.active_limits(&best),
            q: best.q.as_slice().to_vec(),
            searches: RESTARTS + 1,
        })
    }

    fn check_start(&self, start: &[f64]) -> Result<(), NumericalError> {
        let dof = self.chain.dof();
        if start.len() != dof {
            return Err(NumericalError::WrongLength { count: start.len(), dof });
        }
        let Limits { lower, upper } = &self.limits;
        match (0..dof).find(|&k| !(lower[k]..=upper[k]).contains(&start[k])) {
            None => Ok(()),
            Some(k) => Err(NumericalError::StartOutside {
                joint: self.names[k].clone(),
                value: start[k],
                lower: lower[k],
                upper: upper[k],
            }),
        }
    }

    /// A solution, if a search with free revolute joints finds one and whole turns bring it between the limits.
    fn search_through_stops(&self, world_from_tool: &Pose, from: &DVector<f64>) -> Option<State> {
        let found = self.search(world_from_tool, from, &self.without_stops);
        let Limits { lower, upper } = &self.limits;
        let back = |k: usize| {
            if self.without_stops.lower[k].is_finite() {
                return found.q[k];
            }
            let turns = |to: f64| (to - found.q[k]) / TAU;
            // The turn nearest to where the search began, among those between the limits.
            found.q[k] + TAU * turns(from[k]).round().min(turns(upper[k]).floor()).max(turns(lower[k]).ceil())
        };
        let state = self.state(world_from_tool, DVector::from_fn(from.len(), |k, _| back(k)));
        let legal = (0..from.len()).all(|k| (lower[k]..=upper[k]).contains(&state.q[k]));
        (legal && state.is_reached()).then_some(state)
    }

    /// One search between limits, to a solution or a local minimum.
    fn search(&self, world_from_tool: &Pose, from: &DVector<f64>, limits: &Limits) -> State {
        /// Damping of the first step, relative to squared singular values of at most a few units.
        const FIRST_DAMPING: f64 = 1e-2;
        /// More damping than this makes a step that floats do not see.
        const MOST_DAMPING: f64 = 1e9;
        /// The factor by which damping falls after a step that helped.
        const FALL: f64 = 0.2;
        /// The factor by which it rises after one that did not.
        const RISE: f64 = 5.0;

        let mut state = self.state(world_from_tool, from.clone());
        let mut damping = FIRST_DAMPING;
        for _ in 0..MOST_STEPS {
            if state.is_reached() {
                break;
            }
            let jacobian = self.jacobian(&state.q);
            let slope = jacobian.tr_mul(&state.error);
            let free: Vec<usize> = (0..slope.len()).filter(|&k| !limits.hold(&state.q, &slope, k)).collect();
            let next = loop {
                let q = limits.step(&state.q, &jacobian, &slope, &free, damping);
                let next = self.state(world_from_tool, q);
                if next.error.norm() < state.error.norm() {
                    damping *= FALL;
                    break Some(next);
                }
                damping *= RISE;
                if damping > MOST_DAMPING {
                    break None;
                }
            };
            match next {
                Some(next) => state = next,
                None => break,
            }
        }
        state
    }

    /// The error of the tool at joint positions `q`.
    fn state(&self, world_from_tool: &Pose, q: DVector<f64>) -> State {
        let now = self.chain.tool(q.as_slice()).to_pose();
        let linear = world_from_tool.translation.vector - now.translation.vector;
        let angular = (world_from_tool.rotation * now.rotation.inverse()).scaled_axis();
        let mut error = Vector6::zeros();
        error.fixed_rows_mut::<3>(0).copy_from(&(linear / self.size));
        error.fixed_rows_mut::<3>(3).copy_from(&angular);
        State { q, error, residual: Residual { distance: linear.norm(), angle: angular.norm() } }
    }

    /// How the error falls with each joint: the Jacobian with its distances in units of the arm's size.
    fn jacobian(&self, q: &DVector<f64>) -> DMatrix<f64> {
        let jacobian = self.chain.jacobian(q.as_slice());
        DMatrix::from_fn(6, q.len(), |row, column| {
            jacobian[(row, column)] / if row < 3 { self.size } else { 1.0 }
        })
    }

    /// The joints that would have to pass a limit to come nearer.
    fn active_limits(&self, state: &State) -> Vec<ActiveLimit> {
        let slope = self.jacobian(&state.q).tr_mul(&state.error);
        (0..slope.len())
            .filter(|&k| self.limits.hold(&state.q, &slope, k))
            .map(|k| {
                let upper = slope[k] > 0.0;
                let limit = if upper { self.limits.upper[k] } else { self.limits.lower[k] };
                ActiveLimit { joint: self.names[k].clone(), limit, upper }
            })
            .collect()
    }
}

impl Limits {
    fn of(robot: &RobotModel, range: impl Fn(&Joint) -> [f64; 2]) -> Self {
        let [lower, upper] = [0, 1].map(|side| {
            DVector::from_iterator(robot.dof(), robot.joints.iter().map(|joint| range(joint)[side]))
        });
        Self { lower, upper }
    }

    /// The positions after a damped step of the free joints, cut off at the limits.
    fn step(
        &self,
        q: &DVector<f64>,
        jacobian: &DMatrix<f64>,
        slope: &DVector<f64>,
        free: &[usize],
        damping: f64,
    ) -> DVector<f64> {
        let columns = jacobian.select_columns(free);
        let matrix = columns.tr_mul(&columns) + DMatrix::identity(free.len(), free.len()) * damping;
        let mut q = q.clone();
        // Positive definite by the damping, unless that has sunk below rounding: then the step is left out.
        if let Some(factors) = matrix.cholesky() {
            let step = factors.solve(&slope.select_rows(free));
            for (&joint, change) in free.iter().zip(step.iter()) {
                q[joint] = (q[joint] + change).clamp(self.lower[joint], self.upper[joint]);
            }
        }
        q
    }

    /// Whether a joint stands at a limit and the error would fall beyond it.
    fn hold(&self, q: &DVector<f64>, slope: &DVector<f64>, joint: usize) -> bool {
        (q[joint] <= self.lower[joint] && slope[joint] < 0.0)
            || (q[joint] >= self.upper[joint] && slope[joint] > 0.0)
    }
}

impl State {
    fn is_reached(&self) -> bool {
        self.residual.distance <= POSE_TOLERANCE && self.residual.angle <= POSE_TOLERANCE
    }
}

/// A number in [0, 1), with all the digits of a float.
fn share(random: &mut ChaCha8Rng) -> f64 {
    /// 2⁻⁵³.
    const UNIT: f64 = 0.5 * f64::EPSILON;
    (random.next_u64() >> 11) as f64 * UNIT
}
