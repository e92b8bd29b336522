//! `executed.grip`: whether the fingers press as hard as asked before the object is lifted.

use std::collections::BTreeMap;

use crate::{
    checks::held,
    evidence::Evidence,
    finding::{Finding, Gap, worst_by},
    note::Note,
    stream::{self, seconds},
    verdict::Unit,
};

/// The share of the asked force that must be reached. The rest is left to friction in the fingers and to
/// the gripper's own inertia and weight: an object gripped with four fifths of the force still has the
/// friction that the grasp was sized for, with a common safety factor of 2.
const REACHED_SHARE: f64 = 0.8;

/// How long the force must have been there before the lift begins, s: long enough not to take the bounce of
/// a pad's first touch for a grip, short against any closing time.
const SETTLED_BEFORE_LIFT: f64 = 0.01;

/// The least force of the weaker finger on the object shortly before the lift begins, N.
pub(super) fn grip(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    stream::requested(evidence)?;
    let object = held::object(evidence)?;
    let [lift, _] = held::stretch(evidence)?;
    let Some(grasp) = &evidence.plan.grasp else {
        return Err(Gap::inconclusive(None, "the plan has no grasp"));
    };
    let samples = stream::object(evidence)?;
    let window = (lift - SETTLED_BEFORE_LIFT)..=lift;
    stream::contacts_are_all_there(evidence, window.clone())?;
    let fingers = &evidence.resolved.robot.gripper.fingers;
    let mut forces: BTreeMap<i64, [f64; 2]> = samples
        .iter()
        .filter(|sample| window.contains(&sample.time()))
        .map(|sample| (sample.time_ns, [0.0; 2]))
        .collect();
    for contact in stream::contacts(evidence)? {
        let Some(pressed) = forces.get_mut(&contact.time_ns) else { continue };
        for (finger, force) in fingers.iter().zip(pressed) {
            let pair = [contact.body_a.as_str(), contact.body_b.as_str()];
            if pair.contains(&finger.link.name.as_str()) && pair.contains(&object.name.as_str()) {
                *force += contact.normal_force_n;
            }
        }
    }
    let weaker = forces.into_iter().map(|(time_ns, [one, other])| (seconds(time_ns), one.min(other)));
    let (time, force) = worst_by(weaker, |(_, force)| -*force)
        .ok_or_else(|| Gap::inconclusive(Some(lift), "no sample just before the lift"))?;
    if grasp.force <= 0.0 {
        return Err(Gap::inconclusive(Some(lift), format!("the plan asks for a grip of {} N", grasp.force)));
    }
    let mut finding = Finding::at_least(force, REACHED_SHARE * grasp.force, Unit::Newton).by_share();
    if !finding.passes {
        finding.violated = Some([time, time]);
    }
    Ok(finding
        .at(time)
        .of(fingers.iter().map(|finger| finger.link.name.as_str()))
        .during(evidence.phase_name(time))
        .noted(Note::default().quantity(grasp.force, Unit::Newton).and(" were asked of each finger")))
}

#[cfg(test)]
mod tests {
    use crate::{
        Outcome,
        fixture::{self, GRIP, LIFT, Run, ns_of},
    };

    /// The pick with another force of one finger from a time on, until the lift begins.
    fn with_force(force: f64, from: f64) -> Run {
        let mut run = fixture::pick();
        let stretch = ns_of(from)..=ns_of(LIFT);
        for contact in &mut run.recording.contacts {
            if contact.body_b == "right_finger" && stretch.contains(&contact.time_ns) {
                contact.normal_force_n = force;
            }
        }
        run
    }

    #[test]
    fn a_grip_passes_with_the_force_of_the_weaker_finger() {
        let result = fixture::pick().check("executed.grip");
        assert_eq!(
            (result.outcome, result.value, result.limit),
            (Outcome::Pass, Some(GRIP), Some(0.8 * GRIP))
        );
        let weaker = with_force(8.0, 2.0).check("executed.grip");
        assert_eq!((weaker.outcome, weaker.value), (Outcome::Pass, Some(8.0)));
    }

    #[test]
    fn a_weak_finger_fails_and_so_does_a_grip_that_comes_too_late() {
        let result = with_force(7.9, 2.0).check("executed.grip");
        assert_eq!((result.outcome, result.value), (Outcome::Fail, Some(7.9)));
        assert!(result.place.subjects.contains(&"right_finger".to_owned()));

        let mut late = fixture::pick();
        late.recording.contacts.retain(|contact| contact.time_ns > ns_of(LIFT) || contact.body_b == "table");
        assert_eq!(late.check("executed.grip").outcome, Outcome::Inconclusive, "the monitor counted them");
        late.count_contacts();
        let result = late.check("executed.grip");
        assert_eq!((result.outcome, result.value), (Outcome::Fail, Some(0.0)));
    }

    #[test]
    fn a_force_that_is_not_finite_fails() {
        assert_eq!(with_force(f64::NAN, 2.0).check("executed.grip").outcome, Outcome::Fail);
        assert_eq!(with_force(f64::INFINITY, 2.0).check("executed.grip").outcome, Outcome::Fail);
    }

    #[test]
    fn a_missing_stream_or_a_plan_without_a_grasp_is_undecided() {
        let mut run = fixture::pick();
        run.recording.object = Default::default();
        assert_eq!(run.check("executed.grip").outcome, Outcome::Inconclusive);
        let mut run = fixture::pick();
        run.plan.grasp.as_mut().unwrap().force = 0.0;
        assert_eq!(run.check("executed.grip").outcome, Outcome::Inconclusive);
    }

    #[test]
    fn a_task_that_grasps_nothing_is_not_asked() {
        assert_eq!(fixture::blends().check("executed.grip").outcome, Outcome::NotRequested);
    }
}
