//! The rows of a recording as the proof of the executed motion reads them.

use graspcheck_proof::{BodyState, JointLog, LoggedMotion, MotionLog};

use crate::{
    evidence::Evidence,
    finding::Gap,
    stream::{self, JointStream},
};

/// The executed motion, as measured: arm, fingers and, where there is one, the object.
pub(crate) fn motion(evidence: &Evidence<'_>) -> Result<LoggedMotion, Gap> {
    let (arm, fingers) = (JointStream::measured(evidence)?, JointStream::measured_fingers(evidence)?);
    let column = |stream: &JointStream<'_>, joint: usize| JointLog {
        position: stream.positions(joint).collect(),
        velocity: stream.velocities(joint).collect(),
    };
    let object = match &evidence.resolved.object {
        Some(_) => {
            let object = stream::object(evidence)?;
            let same = object.iter().map(|sample| sample.time_ns).eq(arm.times().iter().copied());
            if !same {
                return Err(Gap::inconclusive(None, "streams measured and object have other times"));
            }
            object
        }
        None => Vec::new(),
    };
    let state = |sample: &stream::PoseSample| BodyState {
        world_from_body: sample.world_from_body,
        linear: sample.linear,
        angular: sample.angular,
    };
    let log = MotionLog {
        times: arm.times().iter().map(|time_ns| stream::seconds(*time_ns)).collect(),
        arm: (0..evidence.joints().len()).map(|joint| column(&arm, joint)).collect(),
        fingers: [0, 1].map(|finger| column(&fingers, finger)),
        object: object.iter().map(state).collect(),
    };
    LoggedMotion::new(&evidence.resolved.robot, log)
        .map_err(|error| Gap::inconclusive(None, error.to_string()))
}
