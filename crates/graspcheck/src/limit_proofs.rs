//! The proofs of the joints' limits as data: what travels with a recording as `limits.json`, so that others can
//! check them.

use graspcheck_model::plan::Plan;
use graspcheck_motion::trajectory::SMOOTH_TOLERANCE;
use graspcheck_proof::torque::{TORQUE_TOLERANCE, torque_peaks};
use graspcheck_recording::Attachment;
use graspcheck_verify::Resolved;
use serde::{Deserialize, Serialize};

/// Name of the attachment.
pub const LIMITS_JSON: &str = "limits.json";

/// Version of its form.
pub const LIMITS_SCHEMA: u32 = 1;

/// What is proved of the quantities of all joints.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LimitProofs {
    /// [`LIMITS_SCHEMA`].
    pub schema: u32,
    /// Duration of the plan, s.
    pub duration: f64,
    /// For each joint, in the robot's order, each quantity once.
    pub limits: Vec<LimitProof>,
    /// All jumps of the plan, by joint, order and time; the robot is at rest before and after it.
    pub breaks: Vec<Jump>,
    /// Why nothing is claimed of efforts; none when something is.
    pub effort_unproved: Option<String>,
}

/// What is proved of one quantity of one joint, in its SI unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LimitProof {
    /// Name of the joint.
    pub joint: String,
    /// Of what.
    pub quantity: LimitQuantity,
    /// The robot's limit. Whether it is kept is for the checks to say.
    pub limit: f64,
    /// The quantity is never beyond this: below it for the least position, above it else, in magnitude for all
    /// that are no positions. At a knot it counts from both sides; where it jumps see [`LimitProofs::breaks`].
    pub bound: f64,
    /// What it is at `time`, with its sign; of efforts the magnitude that is reached there at least.
    pub peak: f64,
    /// When, s.
    pub time: f64,
}

/// What a joint has a limit of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LimitQuantity {
    /// The least position.
    PositionMin,
    /// The largest position.
    PositionMax,
    /// Velocity.
    Velocity,
    /// Acceleration.
    Acceleration,
    /// Jerk.
    Jerk,
    /// Torque or force of the drive, with what is held.
    Effort,
}

/// A jump of a derivative of one joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Jump {
    /// Name of the joint.
    pub joint: String,
    /// 0 position, 1 velocity, 2 acceleration, where the jerk is an impulse.
    pub order: usize,
    /// When, s.
    pub time: f64,
    /// After less before, in the derivative's SI unit.
    pub size: f64,
}

/// The proofs of a plan.
#[must_use]
pub fn of(resolved: &Resolved, plan: &Plan) -> LimitProofs {
    let robot = &resolved.robot;
    let trajectory = &plan.trajectory;
    let (gravity, object) = (resolved.cell.gravity, resolved.object.as_ref());
    let efforts = torque_peaks(robot, gravity, object, plan, TORQUE_TOLERANCE);
    let mut limits = Vec::with_capacity(6 * robot.dof());
    for (index, joint) in robot.joints.iter().enumerate() {
        let mut enter = |quantity, limit, bound, peak, time| {
            limits.push(LimitProof { joint: joint.name.clone(), quantity, limit, bound, peak, time });
        };
        let of = &joint.limits;
        let [low, high] = trajectory.range_in(index, 0, 0.0, trajectory.duration());
        enter(LimitQuantity::PositionMin, of.position_min, low.value, low.value, low.time);
        enter(LimitQuantity::PositionMax, of.position_max, high.value, high.value, high.time);
        for (order, quantity, limit) in [
            (1, LimitQuantity::Velocity, of.velocity),
            (2, LimitQuantity::Acceleration, of.acceleration),
            (3, LimitQuantity::Jerk, of.jerk),
        ] {
            let peak = trajectory.peak(index, order);
            enter(quantity, limit, peak.value.abs(), peak.value, peak.time);
        }
        if let Ok(efforts) = &efforts {
            let effort = &efforts[index];
            enter(LimitQuantity::Effort, of.effort, effort.upper, effort.lower, effort.time);
        }
    }
    let breaks = (0..robot.dof()).flat_map(|joint| {
        let name = &robot.joints[joint].name;
        jumps(plan, joint).map(move |(order, time, size)| Jump { joint: name.clone(), order, time, size })
    });
    LimitProofs {
        schema: LIMITS_SCHEMA,
        duration: plan.duration(),
        limits,
        breaks: breaks.collect(),
        effort_unproved: efforts.err(),
    }
}

/// Order, time and size of every jump of a joint.
fn jumps(plan: &Plan, joint: usize) -> impl Iterator<Item = (usize, f64, f64)> {
    let trajectory = &plan.trajectory;
    let (knots, last) = (trajectory.knots(), trajectory.piece_count() - 1);
    (0..3).flat_map(move |order| {
        let smooth = SMOOTH_TOLERANCE * trajectory.peak(joint, order).value.abs().max(1.0);
        knots.iter().enumerate().filter_map(move |(knot, &time)| {
            let before = if knot == 0 {
                0.0
            } else {
                trajectory.piece(knot - 1, joint).eval(knots[knot] - knots[knot - 1])[order]
            };
            let after = if knot > last { 0.0 } else { trajectory.piece(knot, joint).eval(0.0)[order] };
            let may_jump = order > 0 || (1..=last).contains(&knot);
            let size = after - before;
            (may_jump && size.abs() > smooth).then_some((order, time, size))
        })
    })
}

/// The proofs of a plan as a document of its recording.
#[must_use]
pub fn document(resolved: &Resolved, plan: &Plan) -> Attachment {
    Attachment {
        name: LIMITS_JSON.to_owned(),
        media_type: "application/json".to_owned(),
        data: serde_json::to_vec(&of(resolved, plan)).expect("structs, strings and numbers have a JSON form"),
    }
}
