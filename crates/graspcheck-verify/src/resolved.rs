//! What a run was asked to be: the document `resolved.json`.

use graspcheck_model::{
    cell::Cell, execution::Execution, object::Object, robot::RobotModel, task::Pace, task::Task,
};
use serde::{Deserialize, Serialize};

/// Version of the form of `resolved.json`.
pub const RESOLVED_SCHEMA: u32 = 1;

/// A scenario with every default written out, in SI units and radians: all that is needed to judge a
/// recording again when the scenario language has changed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Resolved {
    /// [`RESOLVED_SCHEMA`] when it was written.
    pub schema: u32,
    /// Name of the scenario, e.g. `scara::pick_cube`.
    pub name: String,
    /// One line for people.
    pub title: String,
    /// The robot, with limits as tightened by the scenario.
    pub robot: RobotModel,
    /// The cell, its gravity and required clearances.
    pub cell: Cell,
    /// The object of the task, if there is one.
    pub object: Option<Object>,
    /// What the robot is asked to do.
    pub task: Task,
    /// How fast.
    pub pace: Pace,
    /// How it is executed; none when the run only plans and proves.
    pub execution: Option<Execution>,
    /// Limits of the checks that are not limits of the robot.
    pub checks: CheckLimits,
    /// What must come out.
    pub expect: Expectation,
}

/// Limits of checks; a check without a limit here is not requested.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CheckLimits {
    /// Largest distance between measured and commanded tool, m.
    pub tracking: Option<f64>,
    /// Largest slip of the object in the gripper between lift and release, m.
    pub slip: Option<f64>,
    /// Largest distance of the object from its place at the end, m.
    pub place: Option<f64>,
    /// Largest angle of the object from its place at the end, rad.
    pub place_angle: Option<f64>,
    /// Largest number of steps in which a joint's command was limited.
    pub saturated_steps: Option<u32>,
    /// Largest distance by which a via point is missed, m.
    pub via_miss: Option<f64>,
    /// Largest angle by which a via point is missed, rad.
    pub via_miss_angle: Option<f64>,
    /// Largest deviation from the paths on which the tool or the wrist is led, m and rad, where it is less than the
    /// tolerance that they are planned with.
    pub deviation: Option<f64>,
    /// Least peak utilisation of velocity, acceleration and torque that the scenario claims to reach, as
    /// shares of the limits; it fails when the motion is slower than it claims.
    pub utilisation_min: Option<f64>,
    /// Largest speed of the tool, m/s.
    pub tool_speed: Option<f64>,
    /// Largest acceleration of the tool, m/s².
    pub tool_acceleration: Option<f64>,
    /// Phases that have limits of their own for the tool.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tool_in_phases: Vec<ToolLimits>,
    /// How much an acceleration may step by at a break, as a share of the joint's acceleration limit; for tasks that
    /// say nothing see `planned.continuity`.
    pub acceleration_step: Option<f64>,
    /// Whether the elbow must keep its side throughout and not only where the tool is led on a path.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub branch_throughout: bool,
    /// Least distance from a singular pose, no unit; see [`graspcheck_proof::singular`].
    pub singularity_min: Option<f64>,
}

/// Limits of the tool in one phase, instead of those of the whole plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ToolLimits {
    /// Name of the phase.
    pub phase: String,
    /// Largest speed, m/s; that of the whole plan when it is not given.
    pub speed: Option<f64>,
    /// Largest acceleration, m/s²; that of the whole plan when it is not given.
    pub acceleration: Option<f64>,
}

/// What must come out of a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Expectation {
    /// Every check passes.
    Pass,
    /// Exactly these checks fail; `clearance` stands for `planned.clearance` or `executed.clearance`. Or there is no
    /// plan, for the one reason that is named ([`NoMotion`](graspcheck_model::plan::NoMotion)).
    Fail(Vec<String>),
}
