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
    planar_path::PlanarPath,
    robot::RobotModel,
    task::{CartesianVia, Pace},
};
use graspcheck_motion::{Polynomial, Trajectory};
use graspcheck_proof::deviation::Deviation;
use nalgebra::Point2;

use crate::{
    Planned,
    arm::Arm,
    branch::{BranchFault, Located, Tracker},
    error::PlanError,
    input::check_number,
    lfpb::{BlendEnds, Lfpb},
    opening::idle,
    pace::CheckedPace,
    path::{
        FollowedPath,
        fit::{FitError, fit},
    },
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
    let tolerance = Deviation { position: task.tolerance, angle: task.tolerance };
    check_number("tolerance, m and rad", task.tolerance, task.tolerance > 0.0, "finite and positive")?;
    let wrist = wrist_motion(task)?;
    let planar = PlanarPath::of_wrist(robot, &wrist).map_err(PlanError::NoInverse)?;
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
    let mut trajectory =
        fit(&arm, &followed, &time_itself(wrist.knots())?, tolerance).map_err(|error| match error {
            FitError::Located(Located { at, fault }) => PlanError::Via { elbow, at, fault },
            FitError::Trajectory(error) => error.into(),
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

/// The motion of the wrist, from time 0: x, y (m) and theta (rad) as three "joints".
fn wrist_motion(task: &CartesianVia) -> Result<Trajectory, PlanError> {
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
        pieces.extend(at_start);
        // The instant of a point is a knot too, so that what the point is missed by is exact.
        if let Some(t) = times.iter().find(|&&t| start < t && t < end) {
            knots.push(t - x.start());
            pieces.extend(at_start.map(|polynomial| polynomial.shifted(t - start)));
        }
        knots.push(end - x.start());
    }
    Ok(Trajectory::new(3, knots, pieces)?)
}

/// The law s(t) = t with knots at the given times.
fn time_itself(knots: &[f64]) -> Result<Trajectory, PlanError> {
    let pieces = knots[..knots.len() - 1].iter().map(|&t| Polynomial::new([t, 1.0])).collect();
    Ok(Trajectory::new(1, knots.to_vec(), pieces)?)
}
