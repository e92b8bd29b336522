//! Via points in joint space, at given times.
//!
//! The times are those of the points. The pace's share is not used; a duration for the phase `via` stretches or
//! compresses the whole motion. Limits are not looked at: whether the motion keeps them is for the checks to
//! say.

use graspcheck_model::{
    object::Object,
    robot::RobotModel,
    task::{JointVia, Pace},
};

use crate::{
    Planned,
    cartesian_via::{PHASE, in_one_phase},
    error::PlanError,
    input::check_joint_count,
    pace::{CheckedPace, PhaseNames},
    via_motion::via_motion,
};

/// Plans the motion through the via points. An object that there is stays where it stands.
pub(crate) fn find(
    robot: &RobotModel,
    object: Option<&Object>,
    task: &JointVia,
    pace: &Pace,
) -> Result<Planned, PlanError> {
    let pace = CheckedPace::new(pace, PhaseNames { all: &[PHASE], joint_moves: &[] })?;
    for (k, point) in task.points.iter().enumerate() {
        check_joint_count(&format!("via point {}", k + 1), &point.q, robot.dof())?;
    }
    let times: Vec<f64> = task.points.iter().map(|point| point.t).collect();
    let positions: Vec<Vec<f64>> = task.points.iter().map(|point| point.q.clone()).collect();
    let names: Vec<&str> = robot.joints.iter().map(|joint| joint.name.as_str()).collect();
    let motion = via_motion(&times, &positions, &task.law, &names)
        .map_err(|error| PlanError::ViaMotion { task: "joint_via", error: Box::new(error) })?;
    in_one_phase(robot, object, &motion, &pace)
}
