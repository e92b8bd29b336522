//! `executed.place`, `executed.place_angle`, `executed.rest`: where the object is at the end, against where
//! it belongs, and whether it has come to rest there.

use crate::{
    checks::held,
    evidence::Evidence,
    finding::{Finding, Gap},
    note::Note,
    stream::{self, PoseSample},
    verdict::Unit,
};

/// The speed below which an object counts as at rest, m/s: at this speed it would take a second to move by
/// the finest place tolerance that a scenario sets, 1 mm; contact solving leaves well under a tenth of it.
const REST_SPEED: f64 = 1e-3;

/// The distance between the object and its place at the end of the recording, m.
pub(super) fn place(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    stream::requested(evidence)?;
    let task = held::task(evidence)?;
    let limit = evidence.resolved.checks.place.ok_or_else(no_limit)?;
    let end = end_of_object(evidence)?;
    let apart = end.world_from_body.translation.vector - task.world_from_placed.translation.vector;
    let finding = Finding::at_most(apart.norm(), limit, Unit::Meter);
    Ok(at_end(finding, &end, evidence)?
        .noted(Note::from("off by ").vector(apart.into(), Unit::Meter).and(" in the world")))
}

/// The angle between the object and its place at the end of the recording, rad.
pub(super) fn place_angle(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    stream::requested(evidence)?;
    let task = held::task(evidence)?;
    let limit = evidence.resolved.checks.place_angle.ok_or_else(no_limit)?;
    let end = end_of_object(evidence)?;
    let angle = end.world_from_body.rotation.angle_to(&task.world_from_placed.rotation);
    at_end(Finding::at_most(angle, limit, Unit::Radian), &end, evidence)
}

/// The speed of the fastest point of the object at the end of the recording, m/s: no point within r of the
/// origin is faster than |v| + |ω| r.
pub(super) fn rest(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    stream::requested(evidence)?;
    let object = held::object(evidence)?;
    if evidence.resolved.checks.place.is_none() && evidence.resolved.checks.place_angle.is_none() {
        return Err(no_limit());
    }
    let end = end_of_object(evidence)?;
    let speed = end.linear.norm() + end.angular.norm() * object.shape.extent_radius();
    let mut finding = Finding::at_most(speed, REST_SPEED, Unit::MeterPerSecond);
    finding.value_is_bound = true;
    at_end(finding, &end, evidence)
}

fn no_limit() -> Gap {
    Gap::not_requested("the scenario sets no limit")
}

fn end_of_object(evidence: &Evidence<'_>) -> Result<PoseSample, Gap> {
    let samples = stream::object(evidence)?;
    samples.last().copied().ok_or_else(|| Gap::inconclusive(None, "no sample of the object"))
}

fn at_end(finding: Finding, end: &PoseSample, evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let time = end.time();
    let mut located =
        finding.at(time).of([held::object(evidence)?.name.as_str()]).during(evidence.phase_name(time));
    if !located.passes {
        located.violated = Some([time, time]);
    }
    Ok(located)
}

#[cfg(test)]
mod tests {
    use crate::{
        Outcome, Unit,
        fixture::{self, Run},
    };

    fn at_the_end(change: impl FnOnce(&mut [f64; 7], &mut [f64; 6])) -> Run {
        let mut run = fixture::pick();
        let object = &mut run.recording.object;
        change(object.pose.last_mut().unwrap(), object.twist.last_mut().unwrap());
        run
    }

    #[test]
    fn an_object_at_its_place_passes() {
        let run = fixture::pick();
        for name in ["executed.place", "executed.place_angle", "executed.rest"] {
            let result = run.check(name);
            assert_eq!(result.outcome, Outcome::Pass, "{result:?}");
            assert!((result.time.unwrap() - run.plan.duration()).abs() < 1e-9);
            assert_eq!(result.place.subjects, ["cube"]);
            assert!(result.margin.unwrap() > 0.0);
        }
    }

    #[test]
    fn one_that_is_off_turned_or_moving_fails_on_just_that() {
        let off = at_the_end(|pose, _| pose[0] += 0.0011);
        assert_eq!(off.check("executed.place").outcome, Outcome::Fail);
        assert!((off.check("executed.place").value.unwrap() - 0.0011).abs() < 1e-9);
        assert_eq!(off.check("executed.place_angle").outcome, Outcome::Pass);

        // Turned back to where it came from, by 0.5 rad.
        let turned = at_the_end(|pose, _| pose[3..].copy_from_slice(&[0.0, 0.0, 0.0, 1.0]));
        let result = turned.check("executed.place_angle");
        assert_eq!((result.outcome, result.unit), (Outcome::Fail, Unit::Radian));
        assert!((result.value.unwrap() - 0.5).abs() < 1e-9);
        assert_eq!(turned.check("executed.place").outcome, Outcome::Pass);

        let sliding = at_the_end(|_, twist| twist[1] = -0.0011);
        assert_eq!(sliding.check("executed.rest").outcome, Outcome::Fail);
        let rocking = at_the_end(|_, twist| twist[4] = 0.05);
        assert_eq!(rocking.check("executed.rest").outcome, Outcome::Fail);
        let settled = at_the_end(|_, twist| twist[4] = 0.01);
        assert_eq!(settled.check("executed.rest").outcome, Outcome::Pass);
    }

    #[test]
    fn a_quaternion_of_the_other_sign_is_the_same_place() {
        let same = at_the_end(|pose, _| pose[3..].iter_mut().for_each(|q| *q = -*q));
        let result = same.check("executed.place_angle");
        assert_eq!(result.outcome, Outcome::Pass, "{result:?}");
    }

    #[test]
    fn not_finite_fails_missing_is_undecided_and_no_limit_is_not_asked() {
        let broken = at_the_end(|_, twist| twist[0] = f64::NAN);
        assert_eq!(broken.check("executed.rest").outcome, Outcome::Fail);
        let mut missing = fixture::pick();
        missing.recording.object = Default::default();
        assert_eq!(missing.check("executed.place").outcome, Outcome::Inconclusive);
        let mut unasked = fixture::pick();
        unasked.resolved.checks = Default::default();
        for name in ["executed.place", "executed.place_angle", "executed.rest"] {
            assert_eq!(unasked.check(name).outcome, Outcome::NotRequested);
        }
    }
}
