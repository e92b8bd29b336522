//! The result of planning, as data: what is executed and what is checked.

use graspcheck_motion::Trajectory;
use serde::{Deserialize, Serialize};

use crate::{Pose, inertia::Inertial, object::Object, robot::RobotModel, tool_path::ToolPath};

/// A planned motion: what the controller is given and what is proved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Motion of the arm's joints.
    pub trajectory: Trajectory,
    /// Commanded opening of the gripper (one joint), m, over the same time.
    pub opening: Trajectory,
    /// The phases, one after the other without a gap, from 0 to the duration.
    pub phases: Vec<Phase>,
    /// How the object is held; none when nothing is grasped.
    pub grasp: Option<Grasp>,
    /// The paths on which the tool is led, in order of time; none in plans of joint moves alone, and in logs that are
    /// older than this field.
    #[serde(default)]
    pub paths: Vec<PlannedPath>,
}

/// A path on which the tool is led during a phase: what the deviation is proved from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannedPath {
    /// Name of the phase.
    pub phase: String,
    /// Where the tracked point should be and how the tool should be turned, by the path parameter.
    pub path: ToolPath,
    /// What is led along the path.
    #[serde(default)]
    pub point: TrackedPoint,
    /// The path parameter over the time since the phase began, as a motion of one "joint".
    pub law: Trajectory,
    /// How far the point may be from the path, m, and the tool turned away, rad.
    pub tolerance: f64,
}

/// The point of an arm that a path leads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TrackedPoint {
    /// The tool's origin.
    #[default]
    Tool,
    /// The end of the second link, at the height of the tool.
    Wrist,
}

/// Why no motion exists that does what a task asks: what can be expected of a scenario that must fail in planning
/// (worked examples, section 7).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum NoMotion {
    /// A pose, or a part of a path, is outside the workspace: too far, too near, or beyond a limit of position.
    Unreachable,
    /// A path comes near a singularity, where the joints would have to be very fast.
    NearSingular,
    /// The end of a path can be reached, but only on another branch of the inverse kinematics.
    Branch,
    /// A path touches the singular circle and goes on on the other branch: continuous, but on no branch.
    BranchChange,
}

impl NoMotion {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Unreachable, Self::NearSingular, Self::Branch, Self::BranchChange];

    /// Its stable name, as in `expect_fail`.
    ///
    /// ```
    /// use graspcheck_model::plan::NoMotion;
    /// assert_eq!(NoMotion::NearSingular.name(), "plan.near_singular");
    /// ```
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Unreachable => "plan.unreachable",
            Self::NearSingular => "plan.near_singular",
            Self::Branch => "plan.branch",
            Self::BranchChange => "plan.branch_change",
        }
    }
}

/// A stretch of the motion with one purpose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Phase {
    /// Its name, e.g. `carry`.
    pub name: String,
    /// When it begins, s.
    pub start: f64,
    /// When it ends, s.
    pub end: f64,
    /// Where the object is.
    pub holding: Holding,
}

/// Where the object is during a phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Holding {
    /// There is no object in the task.
    Nothing,
    /// It stands where it stood at the start.
    AtStart,
    /// It stands at the start and the fingers close on it.
    Closing,
    /// It moves with the tool.
    Held,
    /// It stands at its place and the fingers open.
    Opening,
    /// It stands at its place.
    Placed,
}

/// How the object is held.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grasp {
    /// Name of the handle.
    pub handle: String,
    /// From the object's frame to the tool's while it is held.
    pub tool_from_object: Pose,
    /// Distance between the pads on the object, m.
    pub width: f64,
    /// Opening with which the gripper approaches and leaves, m.
    pub opening: f64,
    /// Force of each finger, N.
    pub force: f64,
    /// Where the object stands at the start.
    pub world_from_start: Pose,
    /// Where the plan puts it down.
    pub world_from_placed: Pose,
}

impl Grasp {
    /// The mass properties of the object in the frame of the last link, while it is held.
    #[must_use]
    pub fn load(&self, robot: &RobotModel, object: &Object) -> Inertial {
        let link_from_object = robot.link_from_tool * self.tool_from_object;
        object.shape.inertial(object.mass).transformed(&link_from_object)
    }
}

/// Times that a planner adds up in different orders differ by rounding only: this much, s, for each second
/// of the plan and one more.
const SAME_TIME: f64 = 1e-9;

/// Where the parts of a plan do not fit each other or the robot.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{what} is {found}, not {expected}")]
pub struct PlanFault {
    /// What does not fit.
    pub what: String,
    /// What it is.
    pub found: String,
    /// What would fit.
    pub expected: String,
}

impl Plan {
    /// Whether arm, opening and phases fit each other and a robot of `dof` joints: one opening, all of one
    /// duration, phases one after the other from 0 to the end.
    ///
    /// # Errors
    /// The first thing that does not fit.
    pub fn check(&self, dof: usize) -> Result<(), PlanFault> {
        let fault = |what: String, found: String, expected: String| Err(PlanFault { what, found, expected });
        let joints = self.trajectory.dof();
        if joints != dof {
            return fault(
                "the number of joints".to_owned(),
                joints.to_string(),
                format!("{dof}, as the robot's"),
            );
        }
        if self.opening.dof() != 1 {
            let found = self.opening.dof().to_string();
            return fault("the number of openings".to_owned(), found, "1".to_owned());
        }
        let duration = self.duration();
        let same = |a: f64, b: f64| (a - b).abs() <= SAME_TIME * (1.0 + duration);
        let seconds = |t: f64| format!("{t} s");
        if !same(self.opening.duration(), duration) {
            let found = seconds(self.opening.duration());
            return fault("the duration of the opening".to_owned(), found, seconds(duration));
        }
        let mut end = 0.0;
        for (index, Phase { name, start, end: next, .. }) in self.phases.iter().enumerate() {
            if self.phases[..index].iter().any(|before| before.name == *name) {
                let expected = "a name of its own".to_owned();
                return fault(format!("the name of phase {}", index + 1), name.clone(), expected);
            }
            if !same(*start, end) {
                return fault(format!("the start of phase {name}"), seconds(*start), seconds(end));
            }
            // A comparison with NaN is false, which is a fault.
            let in_order = *next > *start;
            if !in_order {
                let expected = format!("later than {start} s");
                return fault(format!("the end of phase {name}"), seconds(*next), expected);
            }
            end = *next;
        }
        if self.phases.is_empty() || !same(end, duration) {
            return fault("the end of the last phase".to_owned(), seconds(end), seconds(duration));
        }
        Ok(())
    }

    /// When the plan ends, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.trajectory.duration()
    }

    /// The phase at time `t`; at a boundary the one that begins there, after the end the last.
    ///
    /// # Panics
    /// When the plan has no phase, which no planner makes.
    #[must_use]
    pub fn phase_at(&self, t: f64) -> &Phase {
        &self.phases[self.phase_index_at(t)]
    }

    /// The index of the phase at time `t`; at a boundary of the one that begins there, after the end of the
    /// last, and 0 when there is no phase.
    #[must_use]
    pub fn phase_index_at(&self, t: f64) -> usize {
        self.phases.partition_point(|phase| phase.start <= t).max(1) - 1
    }
}
