//! Via points of the wrist of a planar arm: x, y and theta under any law for via points.
//!
//! The law makes a motion of the three coordinates ([`via_motion`]), by default a linear function with
//! parabolic blends in each. The angle is taken literally, not by the shortest way. Inverse kinematics on the
//! asked elbow branch, followed over whole turns, gives the joints; where the acceleration of a coordinate
//! jumps so does the trajectory's, which declares these breaks.
//!
//! The times are those of the points, on the clock of the plan. The pace's share is not used; a duration for the
//! phase `via` stretches or compresses the whole motion.

use graspcheck_model::{
    inverse::{InverseSolution, PlanarWrist},
    object::Object,
    plan::{Holding, Phase, Plan, PlannedPath, TrackedPoint},
    planar_path::PlanarPath,
    robot::RobotModel,
    task::{CartesianVia, Pace},
};
use graspcheck_motion::{Polynomial, Trajectory, TrajectoryError};
use graspcheck_proof::deviation::Deviation;
use nalgebra::Point2;

use crate::{
    Planned,
    arm::Arm,
    branch::{BranchFault, Located, Tracker},
    error::PlanError,
    input::check_number,
    opening::idle,
    pace::{CheckedPace, PhaseNames},
    path::{
        FollowedPath,
        fit::{FitError, fit},
        wrist::{WristPathError, wrist_path},
    },
    retime,
    via_motion::{via_motion, with_knots},
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
    let pace = CheckedPace::new(pace, PhaseNames { all: &[PHASE], joint_moves: &[] })?;
    let tolerance = Deviation { position: task.tolerance, angle: task.tolerance };
    check_number("tolerance, m and rad", task.tolerance, task.tolerance > 0.0, "finite and positive")?;
    let wrist = wrist_motion(task)?;
    let path = wrist_path(robot, &wrist).map_err(|error| match error {
        WristPathError::NoWrist(bound) => PlanError::NoInverse(bound),
        WristPathError::Path(error) => PlanError::Path { phase: PHASE.to_owned(), error },
    })?;
    let planar = PlanarPath::tracking(robot, &path, TrackedPoint::Wrist)
        .map_err(|(_, bound)| PlanError::NoInverse(bound))?;
    let arm = Arm::new(robot).map_err(PlanError::NoInverse)?;
    let tracker = Tracker::new(&arm, &planar);
    let elbow = task.elbow;
    let mut farthest: Option<Located> = None;
    let mut branch = None;
    for start in starts(&arm, task, &wrist)? {
        match tracker.follow(&start) {
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
    let followed = FollowedPath { planar, branch };
    let law = time_itself(wrist.knots())?;
    let trajectory = fit(&arm, &followed, &law, tolerance).map_err(|error| match error {
        FitError::Located(Located { at, fault }) => PlanError::Via { elbow, at, fault },
        FitError::Trajectory(error) => error.into(),
    })?;
    let mut planned = in_one_phase(robot, object, &trajectory, &pace)?;
    let law = in_time(&law, &pace)?;
    let (phase, point, tolerance) = (PHASE.to_owned(), TrackedPoint::Wrist, task.tolerance);
    planned.plan.paths.push(PlannedPath { phase, path, point, law, tolerance });
    Ok(planned)
}

/// The plan of a motion that is one phase; the pace may ask for its duration.
pub(crate) fn in_one_phase(
    robot: &RobotModel,
    object: Option<&Object>,
    motion: &Trajectory,
    pace: &CheckedPace,
) -> Result<Planned, PlanError> {
    let trajectory = in_time(motion, pace)?;
    let end = trajectory.duration();
    let holding = if object.is_some() { Holding::AtStart } else { Holding::Nothing };
    let phases = vec![Phase { name: PHASE.to_owned(), start: 0.0, end, holding }];
    let opening = idle(&robot.gripper, end)?;
    Ok(Planned::without_proof(Plan { trajectory, opening, phases, grasp: None, paths: Vec::new() }))
}

/// The same motion, or law of time, in the duration that the pace may ask for.
fn in_time(motion: &Trajectory, pace: &CheckedPace) -> Result<Trajectory, TrajectoryError> {
    match pace.duration(PHASE) {
        Some(duration) => retime::lasting(motion, duration),
        None => Ok(motion.clone()),
    }
}

/// Legal joint positions at the first point on the asked branch: those whose angles add up to the literal
/// tool angle first, then those that are turned least.
fn starts(arm: &Arm, task: &CartesianVia, wrist: &Trajectory) -> Result<Vec<Vec<f64>>, PlanError> {
    let elbow = task.elbow;
    let unreachable = |bound| PlanError::Via {
        elbow,
        at: 0.0,
        fault: BranchFault::OutOfReach { until: wrist.duration(), bound },
    };
    let first = wrist.eval(0.0).q;
    let first = PlanarWrist { position: Point2::new(first[0], first[1]), theta: first[2] };
    let world_from_tool = arm.robot.world_from_tool_at(&first).map_err(PlanError::NoInverse)?;
    let solutions = arm.inverse.solve(&world_from_tool).map_err(unreachable)?;
    let (legal, illegal): (Vec<_>, Vec<_>) =
        solutions.into_iter().filter(|solution| solution.elbow == elbow).partition(InverseSolution::is_legal);
    if legal.is_empty() {
        let violations = illegal.iter().flat_map(|solution| &solution.violations);
        let least = violations.min_by(|a, b| a.excess.total_cmp(&b.excess));
        let least =
            least.expect("the inverse kinematics lists every branch, and illegal ones with violations");
        let joint = arm.robot.joints[least.joint].name.clone();
        let (value, limit, excess) = (least.value, least.limit, least.excess);
        let reason = BranchFault::Limit { joint, value, limit, excess, hole: None };
        return Err(PlanError::ViaStart { elbow, reason });
    }
    let mut starts: Vec<Vec<f64>> = legal.into_iter().map(|solution| solution.q).collect();
    let theta = task.points[0].theta - arm.inverse.geometry().tool_angle_zero();
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

/// The motion of the wrist on the clock of the plan: x, y (m) and theta (rad) as three "joints". The instants
/// of the points are knots, so that what a point is missed by is exact.
fn wrist_motion(task: &CartesianVia) -> Result<Trajectory, PlanError> {
    let times: Vec<f64> = task.points.iter().map(|point| point.t).collect();
    let positions: Vec<Vec<f64>> =
        task.points.iter().map(|point| vec![point.wrist.x, point.wrist.y, point.theta]).collect();
    let motion = via_motion(&times, &positions, &task.law, &["x", "y", "theta"])
        .map_err(|error| PlanError::ViaMotion { task: "cartesian_via", error: Box::new(error) })?;
    Ok(with_knots(&motion, &times)?)
}

/// The law s(t) = t with knots at the given times.
fn time_itself(knots: &[f64]) -> Result<Trajectory, PlanError> {
    let pieces = knots[..knots.len() - 1].iter().map(|&t| Polynomial::new([t, 1.0])).collect();
    Ok(Trajectory::new(1, knots.to_vec(), pieces)?)
}
