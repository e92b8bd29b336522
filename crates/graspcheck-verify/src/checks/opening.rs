//! `executed.opening`: the fingers do what they are commanded.

use graspcheck_model::plan::Holding;
use graspcheck_motion::MotionState;

use crate::{
    evidence::Evidence,
    finding::{Finding, Gap},
    stream::JointStream,
    verdict::Unit,
};

/// How far the opening may be from where it belongs, m. Drives that follow a motion lag by a hundredth of a
/// second at most, and pads give way by a tenth of a millimetre; fingers that are stuck, that close on
/// nothing or on a thing of another width are off by several millimetres.
const OPENING_TOLERANCE: f64 = 1e-3;

/// The largest distance between the measured opening of the gripper and where it belongs, m: the commanded
/// opening, or the width of the object when the fingers are commanded to press on it.
pub(super) fn opening(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let fingers = JointStream::measured_fingers(evidence)?;
    let plan = &evidence.plan;
    let mut commanded = MotionState::zeros(1);
    let samples: Vec<_> = fingers.samples().collect();
    let distances: Vec<(f64, f64)> = samples
        .chunks_exact(evidence.resolved.robot.gripper.fingers.len())
        .map(|row| {
            let time = row[0].time;
            plan.opening.eval_held(time, &mut commanded);
            let between = match (plan.phase_at(time).holding, &plan.grasp) {
                (Holding::Closing | Holding::Held | Holding::Opening, Some(grasp)) => grasp.width,
                _ => f64::NEG_INFINITY,
            };
            let measured: f64 = row.iter().map(|finger| finger.position).sum();
            (time, (measured - commanded.q[0].max(between)).abs())
        })
        .collect();
    let finding = Finding::worst_at_most(&distances, OPENING_TOLERANCE, Unit::Meter)
        .ok_or_else(|| Gap::inconclusive(None, "no sample"))?;
    let phase = evidence.phase_name(finding.time.unwrap_or(0.0));
    let names = evidence.resolved.robot.gripper.fingers.iter().map(|finger| finger.link.name.as_str());
    Ok(finding.of(names).during(phase))
}

#[cfg(test)]
mod tests {
    use crate::{
        Outcome,
        fixture::{self, LIFT, OPEN, Run},
    };

    /// The pick with both fingers moved outwards by half of `wider` from a time until another.
    fn wider(wider: f64, from: f64, until: f64) -> Run {
        let mut run = fixture::pick();
        let rows = run.rows_from(from).start..run.rows_from(until).start;
        for row in rows {
            for finger in [2, 3] {
                run.recording.measured.position[4 * row + finger] += 0.5 * wider;
            }
        }
        run
    }

    #[test]
    fn fingers_that_follow_and_stop_at_the_object_pass() {
        let result = fixture::pick().check("executed.opening");
        assert_eq!(result.outcome, Outcome::Pass, "{result:?}");
        assert!(result.value.unwrap() < 1e-12);
        assert_eq!(wider(9e-4, 1.0, 5.0).check("executed.opening").outcome, Outcome::Pass);
    }

    #[test]
    fn fingers_that_stick_fail_for_as_long_as_they_do() {
        for (from, until) in [(1.0, 1.5), (LIFT, OPEN), (OPEN + 0.3, 6.0)] {
            for off in [0.0011, -0.0011] {
                let result = wider(off, from, until).check("executed.opening");
                assert_eq!(result.outcome, Outcome::Fail, "{result:?}");
                assert!((result.value.unwrap() - 0.0011).abs() < 1e-12, "{result:?}");
                let [first, last] = result.violated.unwrap();
                assert!(
                    (first - from).abs() < 1e-9 && (last - until + fixture::DT).abs() < 1e-9,
                    "{result:?}"
                );
                assert!(result.place.subjects.contains(&"left_finger".to_owned()));
            }
        }
    }

    #[test]
    fn fingers_that_close_on_nothing_fail_though_they_are_where_they_are_commanded() {
        let result = wider(-0.004, LIFT, OPEN).check("executed.opening");
        assert_eq!(
            (result.outcome, result.place.phase.as_deref()),
            (Outcome::Fail, Some("lift")),
            "{result:?}"
        );
    }

    #[test]
    fn fingers_without_a_column_are_undecided() {
        let mut run = fixture::pick();
        run.recording.measured.names[3] = "another".into();
        assert_eq!(run.check("executed.opening").outcome, Outcome::Inconclusive);
        run.resolved.execution = None;
        assert_eq!(run.check("executed.opening").outcome, Outcome::NotRequested);
    }
}
