//! Which joints turn and which slide, from the document `resolved.json` of the recording.

use graspcheck_model::robot::JointKind;
use graspcheck_recording::Recording;
use serde::Deserialize;

/// The part of `resolved.json` that says it. Whatever else the document holds is left alone.
#[derive(Deserialize)]
struct Resolved {
    robot: Robot,
}

#[derive(Deserialize)]
struct Robot {
    joints: Vec<Joint>,
}

#[derive(Deserialize)]
struct Joint {
    name: String,
    kind: JointKind,
}

/// The joints of the arm and their kinds; empty when the recording does not say.
pub(crate) fn arm_joints(recording: &Recording) -> Vec<(String, JointKind)> {
    let document = recording.attachment("resolved.json");
    let resolved = document.and_then(|document| serde_json::from_slice::<Resolved>(&document.data).ok());
    let joints = resolved.map(|resolved| resolved.robot.joints).unwrap_or_default();
    joints.into_iter().map(|joint| (joint.name, joint.kind)).collect()
}
