//! Closed-form inverse kinematics with named branches and all turns.
//!
//! A pose of the tool has up to two *branches* (elbow left or right) and on each of them several *turns*
//! of a joint whose limits leave room for more than one. [`InverseKinematics`] measures the arm once, in
//! its constructor, and then only evaluates formulas; [`RobotModel::inverse`] does both in one call.
//!
//! The elbow follows from the distance r of the wrist from axis 1 by the half-angle form of the law of
//! cosines, which loses no digits where the arm is nearly straight or folded:
//!
//! ```text
//! tan²(φ₂/2) = ((l₁+l₂)² − r²) / (r² − (l₁−l₂)²)
//! ```
//!
//! The other symbols are those of [`crate::structure`].
//!
//! ```
//! use graspcheck_model::{example, inverse::InverseKinematics};
//!
//! let robot = example::scara();
//! let inverse = InverseKinematics::new(&robot)?;
//! let pose = robot.world_from_tool(&[0.4, 0.9, -0.1, 2.0]);
//! let names: Vec<String> = inverse
//!     .solve(&pose)?
//!     .iter()
//!     .filter(|solution| solution.is_legal())
//!     .map(|solution| solution.name.to_string())
//!     .collect();
//! // The wrist has three turns between −20° and 1080° on either side of the elbow.
//! assert_eq!(names[0], "elbow left, last joint at turn 0");
//! assert_eq!(names.len(), 6);
//! # Ok::<(), graspcheck_model::inverse::Unreachable>(())
//! ```

use std::{f64::consts::TAU, fmt, ops::RangeInclusive};

use nalgebra::{Point2, Vector2};

use crate::{
    Pose,
    robot::{JointLimits, RobotModel},
    structure::PlanarGeometry,
    task::Elbow,
};

/// How far a pose may be off the set of poses that an arm can take, m or rad, and still be reached: a
/// thousand times the rounding of a chain of transforms, a thousandth of what an arm repeats.
pub const POSE_TOLERANCE: f64 = 1e-9;

/// How far the wrist may be outside the reach, relative to it: within rounding the arm counts as straight.
const REACH_TOLERANCE: f64 = 1e-12;

/// How far a position may be outside a limit and still count as inside, rad or m: the rounding of the
/// solution when a pose was made from a position at the limit.
pub const LIMIT_TOLERANCE: f64 = 1e-9;

/// What tells one way to reach a pose from the others.
///
/// ```
/// use graspcheck_model::{inverse::BranchName, task::Elbow};
/// let name = BranchName { elbow: Elbow::Right, shoulder_turn: -1, elbow_turn: 0, last_turn: 2 };
/// assert_eq!(name.to_string(), "elbow right, shoulder at turn -1, last joint at turn 2");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct BranchName {
    /// The side of the elbow.
    pub elbow: Elbow,
    /// Whole turns of joint 1 away from (−π, π].
    pub shoulder_turn: i32,
    /// Whole turns of joint 2 away from (−π, π].
    pub elbow_turn: i32,
    /// Whole turns of the last joint away from (−π, π].
    pub last_turn: i32,
}

impl fmt::Display for BranchName {
    /// The side of the elbow, the turn of the last joint, and those of the others where they are not 0.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.elbow {
            Elbow::Left => "elbow left",
            Elbow::Right => "elbow right",
        })?;
        for (joint, turn) in [("shoulder", self.shoulder_turn), ("elbow", self.elbow_turn)] {
            if turn != 0 {
                write!(f, ", {joint} at turn {turn}")?;
            }
        }
        write!(f, ", last joint at turn {}", self.last_turn)
    }
}

/// One way to reach a pose.
#[derive(Clone, Debug, PartialEq)]
pub struct InverseSolution {
    /// Joint positions from base to tool, rad or m.
    pub q: Vec<f64>,
    /// What tells it from the others, for people to read.
    pub name: BranchName,
    /// The branch of the elbow.
    pub elbow: Elbow,
    /// Whole turns of the last joint away from (−π, π].
    pub turn: i32,
    /// The position limits that this solution breaks; none when it is legal.
    pub violations: Vec<LimitViolation>,
}

impl InverseSolution {
    /// Whether all joints are within their position limits.
    #[must_use]
    pub fn is_legal(&self) -> bool {
        self.violations.is_empty()
    }
}

/// A position limit that is broken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitViolation {
    /// Index of the joint.
    pub joint: usize,
    /// Its position, rad or m.
    pub value: f64,
    /// The limit that it breaks, rad or m.
    pub limit: f64,
    /// By how much, rad or m; positive.
    pub excess: f64,
}

/// Why no joint positions reach a pose, whatever the joints' limits.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unreachable {
    /// The arm has no closed-form inverse kinematics.
    #[error("robot {robot}: no closed-form inverse kinematics: {reason}")]
    NoClosedForm {
        /// Name of the robot.
        robot: String,
        /// What about its structure does not fit.
        reason: String,
    },
    /// A coordinate of the pose is NaN or infinite.
    #[error("tool pose: a coordinate is not finite")]
    NotFinite,
    /// The tool would have to lean away from the direction that the arm keeps.
    #[error("tool pose: leans {angle:.6} rad from the only direction that the arm can give its tool")]
    Tilted {
        /// The smallest rotation that would put it right, rad.
        angle: f64,
    },
    /// The pose is beside the plane in which a planar arm moves.
    #[error("tool pose: {offset:.6} m out of the plane in which the arm moves")]
    OutOfPlane {
        /// Along the base's z axis, signed, m.
        offset: f64,
    },
    /// The wrist would be farther from axis 1 than both links together reach.
    #[error("wrist: {distance:.6} m from axis 1 exceeds the outer reach of {reach:.6} m by {excess:.6} m")]
    TooFar {
        /// Of the wrist from axis 1, m.
        distance: f64,
        /// Sum of both lengths, m.
        reach: f64,
        /// How much too far, m.
        excess: f64,
    },
    /// The wrist would be nearer to axis 1 than the folded arm.
    #[error(
        "wrist: {distance:.6} m from axis 1 is inside the hole of radius {hole:.6} m by {shortfall:.6} m"
    )]
    TooNear {
        /// Of the wrist from axis 1, m.
        distance: f64,
        /// Difference of both lengths, m.
        hole: f64,
        /// How much too near, m.
        shortfall: f64,
    },
}

/// How near to axis 1 and how far from it the wrist can be, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Radius of the hole that the elbow's limits leave.
    pub inner: f64,
    /// Outer radius that the elbow's limits leave.
    pub outer: f64,
    /// Radius of the hole if the elbow had no limit: the difference of the lengths.
    pub inner_without_limits: f64,
    /// Outer radius if the elbow had no limit: the sum of the lengths.
    pub outer_without_limits: f64,
}

/// Wrist and absolute tool angle of a planar R-R-R arm, in the base's x-y plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarWrist {
    /// The end of link 2, m.
    pub position: Point2<f64>,
    /// Angle of the tool's x axis against the base's x, rad. It is the sum of the joint positions and the
    /// angle at the zero position, not wrapped. Where the tool points along link 3 this is the angle of
    /// link 3.
    pub theta: f64,
}

/// The inverse kinematics of one arm, measured and ready.
#[derive(Clone, Debug, PartialEq)]
pub struct InverseKinematics {
    geometry: PlanarGeometry,
    base_from_world: Pose,
    pub(crate) limits: Vec<JointLimits>,
    pub(crate) joint_names: Vec<String>,
}

/// The most joints that an arm with a closed form has.
const MOST_JOINTS: usize = 4;

/// What a pose asks of the arm.
struct Target {
    /// From axis 1 to the wrist, m.
    wrist: Vector2<f64>,
    /// Its length, m.
    distance: f64,
    /// ψ in (−2π, 2π], rad.
    turn: f64,
    /// Of the tool over its height at the zero position, m.
    rise: f64,
}

/// The angle φ₂ of the left elbow from 0 (straight) to π (folded), rad, with its sine and cosine.
struct Bend {
    angle: f64,
    sin: f64,
    cos: f64,
}

impl InverseKinematics {
    /// The inverse kinematics of `robot`.
    ///
    /// # Errors
    /// [`Unreachable::NoClosedForm`] when the arm is none of the families with a closed form.
    pub fn new(robot: &RobotModel) -> Result<Self, Unreachable> {
        let geometry = PlanarGeometry::of(robot)
            .map_err(|reason| Unreachable::NoClosedForm { robot: robot.name.clone(), reason })?;
        Ok(Self {
            geometry,
            base_from_world: robot.world_from_base.inverse(),
            limits: robot.joints.iter().map(|joint| joint.limits).collect(),
            joint_names: robot.joints.iter().map(|joint| joint.name.clone()).collect(),
        })
    }

    /// The measured numbers of the arm.
    #[must_use]
    pub fn geometry(&self) -> &PlanarGeometry {
        &self.geometry
    }

    /// All ways to reach a pose of the tool: both elbows (left first), and on each the turns of every
    /// revolute joint that lie within its limits. A joint none of whose turns is within its limits is
    /// given at the turn nearest to them, and the solution lists the violation. Where the arm is straight
    /// or folded both elbows give the same pose of all links and both are listed.
    ///
    /// # Errors
    /// When no joint positions reach the pose, whatever the limits.
    pub fn solve(&self, world_from_tool: &Pose) -> Result<Vec<InverseSolution>, Unreachable> {
        let mut solutions = Vec::with_capacity(8);
        self.visit(world_from_tool, |name, q| {
            let violations = violations(q, &self.limits);
            let BranchName { elbow, last_turn: turn, .. } = name;
            solutions.push(InverseSolution { q: q.to_vec(), name, elbow, turn, violations });
        })?;
        Ok(solutions)
    }

    /// Shows every solution of [`InverseKinematics::solve`], in its order, to `visit`: its name and the joint
    /// positions. Allocates nothing.
    ///
    /// # Errors
    /// When no joint positions reach the pose, whatever the limits.
    ///
    /// ```
    /// use graspcheck_model::{example, inverse::InverseKinematics};
    /// let robot = example::scara();
    /// let inverse = InverseKinematics::new(&robot)?;
    /// let mut legal = 0;
    /// inverse.visit(&robot.world_from_tool(&[0.4, 0.9, -0.1, 2.0]), |_, q| {
    ///     legal += usize::from(inverse.is_within_limits(q));
    /// })?;
    /// assert_eq!(legal, 6);
    /// # Ok::<(), graspcheck_model::inverse::Unreachable>(())
    /// ```
    pub fn visit(
        &self,
        world_from_tool: &Pose,
        mut visit: impl FnMut(BranchName, &[f64]),
    ) -> Result<(), Unreachable> {
        let target = self.target(world_from_tool)?;
        let elbow_bend = self.bend(target.distance)?;
        let dof = self.limits.len();
        let mut q = [0.0; MOST_JOINTS];
        if let Some(quill) = self.geometry.quill {
            q[quill] = target.rise;
        }
        for elbow in [Elbow::Left, Elbow::Right] {
            let [shoulder, bend, wrist] = self.angles(&target, elbow, &elbow_bend);
            for shoulder_turn in turns(shoulder, &self.limits[0]) {
                q[0] = shoulder + TAU * f64::from(shoulder_turn);
                for elbow_turn in turns(bend, &self.limits[1]) {
                    q[1] = bend + TAU * f64::from(elbow_turn);
                    for last_turn in turns(wrist, &self.limits[dof - 1]) {
                        q[dof - 1] = wrist + TAU * f64::from(last_turn);
                        visit(BranchName { elbow, shoulder_turn, elbow_turn, last_turn }, &q[..dof]);
                    }
                }
            }
        }
        Ok(())
    }

    /// Whether all joints are within their position limits, to [`LIMIT_TOLERANCE`].
    ///
    /// # Panics
    /// When `q` has another length than the arm has joints.
    #[must_use]
    pub fn is_within_limits(&self, q: &[f64]) -> bool {
        assert_eq!(q.len(), self.limits.len(), "positions for another number of joints");
        q.iter().zip(&self.limits).all(|(&value, limits)| {
            value >= limits.position_min - LIMIT_TOLERANCE && value <= limits.position_max + LIMIT_TOLERANCE
        })
    }

    /// The joint positions on one branch at the turns nearest to `near`, whatever the limits, into `q`:
    /// following a path of the tool with `near` the solution before gives a continuous motion. Allocates
    /// nothing.
    ///
    /// # Errors
    /// When no joint positions reach the pose.
    ///
    /// # Panics
    /// When `near` or `q` has another length than the arm has joints.
    pub fn solve_near(
        &self,
        world_from_tool: &Pose,
        elbow: Elbow,
        near: &[f64],
        q: &mut [f64],
    ) -> Result<(), Unreachable> {
        let last = self.limits.len() - 1;
        assert_eq!(near.len(), self.limits.len(), "positions for another number of joints");
        assert_eq!(q.len(), self.limits.len(), "positions for another number of joints");
        let target = self.target(world_from_tool)?;
        let angles = self.angles(&target, elbow, &self.bend(target.distance)?);
        for (joint, angle) in [0, 1, last].into_iter().zip(angles) {
            q[joint] = angle + TAU * ((near[joint] - angle) / TAU).round();
        }
        if let Some(quill) = self.geometry.quill {
            q[quill] = target.rise;
        }
        Ok(())
    }

    /// How near to axis 1 and how far from it the wrist can be.
    #[must_use]
    pub fn reach(&self) -> Reach {
        let (upper, fore) = (self.geometry.upper, self.geometry.fore);
        let low = self.limits[1].position_min + self.geometry.elbow_zero;
        let high = self.limits[1].position_max + self.geometry.elbow_zero;
        let passes = |angle: f64| ((low - angle) / TAU).ceil() <= ((high - angle) / TAU).floor();
        let (inner_without_limits, outer_without_limits) = ((upper - fore).abs(), upper + fore);
        let ends = [self.limits[1].position_min, self.limits[1].position_max].map(|q2| self.distance_at(q2));
        Reach {
            inner: if passes(TAU / 2.0) { inner_without_limits } else { ends[0].min(ends[1]) },
            outer: if passes(0.0) { outer_without_limits } else { ends[0].max(ends[1]) },
            inner_without_limits,
            outer_without_limits,
        }
    }

    /// Distance of the wrist from axis 1 when the elbow stands at `q2` (rad), m.
    pub(crate) fn distance_at(&self, q2: f64) -> f64 {
        let (upper, fore) = (self.geometry.upper, self.geometry.fore);
        // |l₁ + l₂ exp(i φ₂)|, which loses no digits where the arm is nearly folded.
        let (sin, cos) = (q2 + self.geometry.elbow_zero).sin_cos();
        (upper + fore * cos).hypot(fore * sin)
    }

    /// Distance of the wrist from axis 1 that a pose of the tool asks for, m.
    ///
    /// # Errors
    /// When the pose is not finite, or the arm cannot give its tool that direction or height.
    pub fn wrist_distance(&self, world_from_tool: &Pose) -> Result<f64, Unreachable> {
        Ok(self.target(world_from_tool)?.distance)
    }

    /// What the pose asks of the arm.
    fn target(&self, world_from_tool: &Pose) -> Result<Target, Unreachable> {
        let base_from_tool = self.base_from_world * world_from_tool;
        let tool = base_from_tool.translation.vector;
        let zero_from_now = base_from_tool.rotation * self.geometry.base_from_tool_zero.inverse();
        let [i, j, k, w] = <[f64; 4]>::from(zero_from_now.coords);
        if !(tool.iter().sum::<f64>() + i + j + k + w).is_finite() {
            return Err(Unreachable::NotFinite);
        }
        // Swing and twist about z: the swing must vanish, the twist is ψ.
        let (swing, twist) = ((i * i + j * j).sqrt(), (k * k + w * w).sqrt());
        if swing > 0.5 * POSE_TOLERANCE * twist {
            return Err(Unreachable::Tilted { angle: 2.0 * swing.atan2(twist) });
        }
        let rise = tool.z - self.geometry.tool_height;
        if self.geometry.quill.is_none() && rise.abs() > POSE_TOLERANCE {
            return Err(Unreachable::OutOfPlane { offset: rise });
        }
        let (cos, sin) = ((w * w - k * k) / (twist * twist), 2.0 * w * k / (twist * twist));
        let offset = self.geometry.tool_offset;
        let wrist = Vector2::new(
            tool.x - self.geometry.shoulder.x - (cos * offset.x - sin * offset.y),
            tool.y - self.geometry.shoulder.y - (sin * offset.x + cos * offset.y),
        );
        Ok(Target { wrist, distance: wrist.norm(), turn: 2.0 * k.atan2(w), rise })
    }

    /// The elbow that puts the wrist at this distance from axis 1.
    fn bend(&self, distance: f64) -> Result<Bend, Unreachable> {
        let (reach, hole) =
            (self.geometry.upper + self.geometry.fore, (self.geometry.upper - self.geometry.fore).abs());
        if distance - reach > REACH_TOLERANCE * reach {
            return Err(Unreachable::TooFar { distance, reach, excess: distance - reach });
        }
        if hole - distance > REACH_TOLERANCE * reach {
            return Err(Unreachable::TooNear { distance, hole, shortfall: hole - distance });
        }
        let from_straight = ((reach - distance).max(0.0) * (reach + distance)).sqrt();
        let from_folded = ((distance - hole).max(0.0) * (distance + hole)).sqrt();
        // These are 2√(l₁l₂) times sine and cosine of half the angle.
        let whole = from_straight * from_straight + from_folded * from_folded;
        Ok(Bend {
            angle: 2.0 * from_straight.atan2(from_folded),
            sin: 2.0 * from_straight * from_folded / whole,
            cos: (from_folded * from_folded - from_straight * from_straight) / whole,
        })
    }

    /// Positions of the three revolute joints on one branch, each in (−π, π].
    fn angles(&self, target: &Target, elbow: Elbow, bend: &Bend) -> [f64; 3] {
        let side = match elbow {
            Elbow::Left => 1.0,
            Elbow::Right => -1.0,
        };
        // The wrist as seen from an upper arm along x; the upper arm's angle is what turns it onto the target.
        let seen = Vector2::new(
            self.geometry.upper + self.geometry.fore * bend.cos,
            self.geometry.fore * side * bend.sin,
        );
        let upper_angle = seen.perp(&target.wrist).atan2(seen.dot(&target.wrist));
        let q1 = wrap(upper_angle - self.geometry.shoulder_zero);
        let q2 = wrap(side * bend.angle - self.geometry.elbow_zero);
        [q1, q2, wrap(target.turn - q1 - q2)]
    }
}

impl RobotModel {
    /// All ways to reach a pose of the tool; see [`InverseKinematics::solve`], which a loop should call on
    /// an [`InverseKinematics`] built once.
    ///
    /// # Errors
    /// When the arm has no closed form, or no joint positions reach the pose.
    pub fn inverse(&self, world_from_tool: &Pose) -> Result<Vec<InverseSolution>, Unreachable> {
        InverseKinematics::new(self)?.solve(world_from_tool)
    }

    /// Wrist and absolute tool angle of a planar R-R-R arm at joint positions `q`.
    ///
    /// # Errors
    /// [`Unreachable::NoClosedForm`] when the arm is not a planar R-R-R.
    ///
    /// # Panics
    /// When `q` has another length than the arm has joints.
    pub fn planar_wrist(&self, q: &[f64]) -> Result<PlanarWrist, Unreachable> {
        let geometry = self.planar_geometry()?;
        let base_from_wrist = self.world_from_base.inv_mul(&self.world_from_wrist(q));
        Ok(PlanarWrist {
            position: Point2::from(base_from_wrist.translation.vector.xy()),
            theta: geometry.tool_angle_zero() + q.iter().sum::<f64>(),
        })
    }

    /// From the tool to the world when a planar R-R-R arm has its wrist and tool angle as given.
    ///
    /// # Errors
    /// [`Unreachable::NoClosedForm`] when the arm is not a planar R-R-R.
    pub fn world_from_tool_at(&self, wrist: &PlanarWrist) -> Result<Pose, Unreachable> {
        let geometry = self.planar_geometry()?;
        let turn = wrist.theta - geometry.tool_angle_zero();
        Ok(self.world_from_base * geometry.base_from_tool(wrist.position, turn, 0.0))
    }

    /// The geometry, if the arm is a planar R-R-R.
    fn planar_geometry(&self) -> Result<PlanarGeometry, Unreachable> {
        PlanarGeometry::of(self)
            .and_then(|geometry| match geometry.quill {
                None => Ok(geometry),
                Some(_) => Err("it is not a planar R-R-R arm".to_owned()),
            })
            .map_err(|reason| Unreachable::NoClosedForm { robot: self.name.clone(), reason })
    }
}

/// The same direction in (−π, π], rad.
fn wrap(angle: f64) -> f64 {
    if -TAU / 2.0 < angle && angle <= TAU / 2.0 {
        return angle;
    }
    angle - TAU * ((angle - TAU / 2.0) / TAU).ceil()
}

/// The whole turns that bring `angle` within the limits, or the one that brings it nearest to them.
fn turns(angle: f64, limits: &JointLimits) -> RangeInclusive<i32> {
    let first = ((limits.position_min - LIMIT_TOLERANCE - angle) / TAU).ceil() as i32;
    let last = ((limits.position_max + LIMIT_TOLERANCE - angle) / TAU).floor() as i32;
    if first <= last {
        return first..=last;
    }
    // No turn fits: `last` is the nearest below the limits, `first` the nearest above.
    let below = limits.position_min - (angle + TAU * f64::from(last));
    let above = angle + TAU * f64::from(first) - limits.position_max;
    let nearest = if below <= above { last } else { first };
    nearest..=nearest
}

/// The position limits that `q` breaks.
fn violations(q: &[f64], limits: &[JointLimits]) -> Vec<LimitViolation> {
    q.iter()
        .zip(limits)
        .enumerate()
        .filter_map(|(joint, (&value, limits))| {
            let (limit, excess) = if value < limits.position_min {
                (limits.position_min, limits.position_min - value)
            } else {
                (limits.position_max, value - limits.position_max)
            };
            (excess > LIMIT_TOLERANCE).then_some(LimitViolation { joint, value, limit, excess })
        })
        .collect()
}
