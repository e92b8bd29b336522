//! Via points of the wrist of a planar arm: linear function with parabolic blends in x, y and theta.
//!
//! Each coordinate is an [`Lfpb`] of its own with the blends inside the first and the last instant; all
//! share the instants at which pieces meet. The angle is taken literally, not by the shortest way. Inverse
//! kinematics on the asked elbow branch, followed over whole turns, gives the joints; the acceleration jumps
//! where a blend meets a line, and so does the trajectory, which declares these breaks.
//!
//! The times are those of the points. The pace's share is not used; a duration for the phase `via` stretches
//! or compresses the whole motion.

use graspcheck_model::{
    inverse::{InverseSolution, PlanarWrist},
    object::Object,
    plan::{Holding, Phase, Plan},
    robot::RobotModel,
    task::{CartesianVia, Pace},
};
use graspcheck_motion::Polynomial;
use nalgebra::{Point2, Vector2, Vector3, Vector6};

use crate::{
    Planned,
    arm::Arm,
    branch::{BranchFault, Located, ToolPath},
    error::PlanError,
    input::check_number,
    interpolation::{InterpolationError, Tolerance, ToolMotion, ToolState, interpolate},
    lfpb::{BlendEnds, Lfpb},
    opening::idle,
    pace::CheckedPace,
    retime,
};

/// Name of the only phase.
pub(crate) const PHASE: &str = "via";

/// Plans the motion through the via points. An object that there is stays where it stands.
pub(crate) fn find(
    robot: &RobotModel,
    object: Option<&Object>,
    task: &CartesianVia,
    pace: &Pace,
) -> Result<Planned, PlanError> {
    let pace = CheckedPace::new(pace, &[PHASE])?;
    let motion = WristMotion::new(robot, task)?;
    let arm = Arm::new(robot).map_err(PlanError::NoInverse)?;
    let tolerance = Tolerance { position: task.tolerance, angle: task.tolerance };
    check_number("tolerance, m and rad", task.tolerance, task.tolerance > 0.0, "finite and positive")?;
    let pose = |t: f64| motion.state(motion.piece_at(t), t).world_from_tool;
    let path = ToolPath::new(&arm, 0.0, motion.duration(), &pose);
    let elbow = task.elbow;
    let mut farthest: Option<Located> = None;
    let mut branch = None;
    for start in starts(&arm, task, &motion)? {
        match path.follow(&start) {
            Ok(found) => {
                branch = Some(found);
                break;
            }
            Err(fault) => {
                if farthest.as_ref().is_none_or(|so_far| fault.at > so_far.at) {
                    farthest = Some(fault);
                }
            }
        }
    }
    let Some(branch) = branch else {
        let Located { at, fault } = farthest.expect("there is at least one start, and following it failed");
        return Err(PlanError::Via { elbow, at, fault });
    };
    let mut trajectory = interpolate(&arm, &motion, &branch, tolerance).map_err(|error| match error {
        InterpolationError::Located(Located { at, fault }) => PlanError::Via { elbow, at, fault },
        InterpolationError::Trajectory(error) => error.into(),
    })?;
    if let Some(duration) = pace.duration(PHASE) {
        trajectory = retime::lasting(&trajectory, duration)?;
    }
    let end = trajectory.duration();
    let holding = if object.is_some() { Holding::AtStart } else { Holding::Nothing };
    let phases = vec![Phase { name: PHASE.to_owned(), start: 0.0, end, holding }];
    let opening = idle(&robot.gripper, end)?;
    Ok(Planned::without_proof(Plan { trajectory, opening, phases, grasp: None }))
}

/// Legal joint positions at the first point on the asked branch: those whose angles add up to the literal
/// tool angle first, then those that are turned least.
fn starts(arm: &Arm, task: &CartesianVia, motion: &WristMotion) -> Result<Vec<Vec<f64>>, PlanError> {
    let elbow = task.elbow;
    let unreachable = |bound| PlanError::Via {
        elbow,
        at: 0.0,
        fault: BranchFault::OutOfReach { until: motion.duration(), bound },
    };
    let solutions = arm.inverse.solve(&motion.state(0, 0.0).world_from_tool).map_err(unreachable)?;
    let (legal, illegal): (Vec<_>, Vec<_>) =
        solutions.into_iter().filter(|solution| solution.elbow == elbow).partition(InverseSolution::is_legal);
    if legal.is_empty() {
        let violations = illegal.iter().flat_map(|solution| &solution.violations);
        let least = violations.min_by(|a, b| a.excess.total_cmp(&b.excess));
        let least =
            least.expect("the inverse kinematics lists every branch, and illegal ones with violations");
        return Err(PlanError::ViaStart { elbow, reason: arm.limit_fault(least.joint, least.value) });
    }
    let mut starts: Vec<Vec<f64>> = legal.into_iter().map(|solution| solution.q).collect();
    let theta = task.points[0].theta - motion.theta_zero;
    let rank = |q: &[f64]| {
        // A whole turn is 2π; what is below a tenth of it is rounding.
        let misses_theta = (q.iter().sum::<f64>() - theta).abs() > 0.1;
        (misses_theta, q.iter().fold(0.0, |most: f64, value| most.max(value.abs())))
    };
    starts.sort_by(|a, b| {
        let ((a_misses, a_most), (b_misses, b_most)) = (rank(a), rank(b));
        a_misses.cmp(&b_misses).then(a_most.total_cmp(&b_most))
    });
    Ok(starts)
}

/// The motion of wrist and tool angle, from time 0.
struct WristMotion<'a> {
    robot: &'a RobotModel,
    knots: Vec<f64>,
    /// x, y and theta on each interval, in local time.
    pieces: Vec<[Polynomial; 3]>,
    /// From the wrist to the tool's origin, in a frame at the wrist along the tool angle, base's x-y plane, m.
    tool_from_wrist: Vector2<f64>,
    /// Tool angle when all joints are at 0, rad.
    theta_zero: f64,
}

impl<'a> WristMotion<'a> {
    fn new(robot: &'a RobotModel, task: &CartesianVia) -> Result<Self, PlanError> {
        let times: Vec<f64> = task.points.iter().map(|point| point.t).collect();
        let blends = vec![task.blend; times.len()];
        let coordinate = |of: &dyn Fn(usize) -> f64| {
            let values: Vec<f64> = (0..times.len()).map(of).collect();
            Lfpb::with_blend_times(&times, &values, &blends, BlendEnds::Inside)
        };
        let x = coordinate(&|k| task.points[k].wrist.x)?;
        let y = coordinate(&|k| task.points[k].wrist.y)?;
        let theta = coordinate(&|k| task.points[k].theta)?;
        // The pieces follow from times and blends alone, so they are the same for all coordinates.
        let starts = x.pieces().iter().map(|(start, _)| *start);
        let ends = starts.clone().skip(1).chain([x.end()]);
        let mut knots = vec![0.0];
        let mut pieces = Vec::new();
        for (index, (start, end)) in starts.zip(ends).enumerate() {
            let at_start = [&x, &y, &theta].map(|coordinate| coordinate.pieces()[index].1);
            pieces.push(at_start);
            // The instant of a point is a knot too, so that what the point is missed by is exact.
            if let Some(t) = times.iter().find(|&&t| start < t && t < end) {
                knots.push(t - x.start());
                pieces.push(at_start.map(|polynomial| polynomial.shifted(t - start)));
            }
            knots.push(end - x.start());
        }
        let no_inverse = PlanError::NoInverse;
        let theta_zero = robot.planar_wrist(&vec![0.0; robot.dof()]).map_err(no_inverse)?.theta;
        let at_origin = PlanarWrist { position: Point2::origin(), theta: 0.0 };
        let world_from_tool = robot.world_from_tool_at(&at_origin).map_err(no_inverse)?;
        let base_from_tool = robot.world_from_base.inv_mul(&world_from_tool);
        let tool_from_wrist = base_from_tool.translation.vector.xy();
        Ok(Self { robot, knots, pieces, tool_from_wrist, theta_zero })
    }

    fn duration(&self) -> f64 {
        self.knots[self.knots.len() - 1]
    }

    fn piece_at(&self, t: f64) -> usize {
        self.knots.partition_point(|&knot| knot <= t).clamp(1, self.pieces.len()) - 1
    }

    /// Vector of the world for one in the base's x-y plane.
    fn in_world(&self, planar: Vector2<f64>) -> Vector3<f64> {
        self.robot.world_from_base.rotation * planar.push(0.0)
    }
}

impl ToolMotion for WristMotion<'_> {
    fn knots(&self) -> &[f64] {
        &self.knots
    }

    fn place(&self, _piece: usize, t: f64) -> f64 {
        t
    }

    /// The tool's origin is the wrist plus a vector r of fixed length that turns with theta, so that
    /// `v = ẇ + θ̇ r⊥` and `a = ẅ + θ̈ r⊥ − θ̇² r`, r⊥ being r turned by a quarter turn.
    fn state(&self, piece: usize, t: f64) -> ToolState {
        let [x, y, theta] = self.pieces[piece].map(|polynomial| polynomial.eval(t - self.knots[piece]));
        let wrist = PlanarWrist { position: Point2::new(x[0], y[0]), theta: theta[0] };
        let world_from_tool =
            self.robot.world_from_tool_at(&wrist).expect("the constructor has found the arm to be planar");
        let r = nalgebra::Rotation2::new(theta[0]) * self.tool_from_wrist;
        let across = Vector2::new(-r.y, r.x);
        let velocity = self.in_world(Vector2::new(x[1], y[1]) + theta[1] * across);
        let acceleration =
            self.in_world(Vector2::new(x[2], y[2]) + theta[2] * across - theta[1] * theta[1] * r);
        let axis = self.robot.world_from_base.rotation * Vector3::z();
        ToolState {
            world_from_tool,
            twist: stacked(velocity, axis * theta[1]),
            twist_rate: stacked(acceleration, axis * theta[2]),
        }
    }
}

/// Linear above angular.
fn stacked(linear: Vector3<f64>, angular: Vector3<f64>) -> Vector6<f64> {
    Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}
