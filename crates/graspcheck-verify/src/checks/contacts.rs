//! `executed.contacts`: nothing touches that may not touch in its phase, and nothing overlaps deeper than
//! it may. What may touch, when, why and how deep is the policy of the proof, [`Scene::pairs`]: there is
//! one policy for plan and execution.

use std::collections::BTreeMap;

use graspcheck_proof::RequiredPair;
#[cfg(doc)]
use graspcheck_proof::Scene;
use graspcheck_recording::ContactSample;

use crate::{
    evidence::Evidence,
    finding::{Finding, Gap},
    note::Note,
    stream::{self, seconds},
    verdict::Unit,
};

/// The force from which on two bodies count as touching, N: the weight of one gram. A solver leaves less
/// than a thousandth of it between bodies that are apart; less than this moves nothing here.
const TOUCH_FORCE: f64 = 0.01;

/// The overlap from which on two bodies count as touching without a force, m: poses in the world carry
/// rounding of 1e-15 m, and surfaces that stand on each other without a force are at zero.
const TOUCH_DEPTH: f64 = 1e-9;

/// How a contact is seen, from the least to the most serious, with what orders contacts of one kind.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Gravity {
    /// Allowed, with the share of the allowed depth.
    Allowed(f64),
    /// Allowed, but too deep by so many metres.
    TooDeep(f64),
    /// Forbidden, without force, with its depth, m.
    ForbiddenOverlap(f64),
    /// Forbidden, with its force, N.
    ForbiddenForce(f64),
}

/// The most serious contact: a forbidden one with the largest force, else the deepest one against the
/// depth that it may have. Without any contact the value is a force of 0 N.
///
/// A contact that may not be fails whatever else the log lacks; without one, none may be missing.
pub(super) fn contacts(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let contacts = stream::contacts(evidence)?;
    let pairs = evidence.proof()?.scene.pairs(&evidence.plan);
    let policy: Policy<'_> =
        pairs.iter().map(|pair| (key(pair.phase.as_deref(), &pair.a, &pair.b), pair)).collect();

    let mut worst: Option<(Gravity, Finding)> = None;
    let mut violated: Option<[f64; 2]> = None;
    let mut fault_count = 0;
    for contact in contacts {
        if contact.normal_force_n <= TOUCH_FORCE && contact.depth_m <= TOUCH_DEPTH {
            continue;
        }
        let phase = evidence.phase_name(seconds(contact.time_ns));
        let of_phase = policy.get(&key(Some(phase), &contact.body_a, &contact.body_b));
        let rule = of_phase.or_else(|| policy.get(&key(None, &contact.body_a, &contact.body_b)));
        let Some((gravity, finding)) = seen(contact, rule.copied()) else { continue };
        if !finding.passes {
            let time = seconds(contact.time_ns);
            violated = Some(violated.map_or([time, time], |[first, last]| [first.min(time), last.max(time)]));
            fault_count += 1;
        }
        if worst.as_ref().is_none_or(|(so_far, _)| gravity > *so_far) {
            worst = Some((gravity, finding.during(phase)));
        }
    }
    if fault_count == 0 {
        stream::contacts_are_all_there(evidence, f64::NEG_INFINITY..=f64::INFINITY)?;
    }
    let Some((_, mut finding)) = worst else {
        return Ok(Finding::at_most(0.0, TOUCH_FORCE, Unit::Newton).noted("nothing touches"));
    };
    finding.violated = violated;
    if fault_count > 1 {
        finding.note = finding.note.and(format!("; {fault_count} such samples in all"));
    }
    Ok(finding)
}

/// What is required of two bodies in a phase, or in all phases.
type Policy<'p> = BTreeMap<(Option<&'p str>, [&'p str; 2]), &'p RequiredPair>;

fn key<'k>(phase: Option<&'k str>, a: &'k str, b: &'k str) -> (Option<&'k str>, [&'k str; 2]) {
    (phase, if a <= b { [a, b] } else { [b, a] })
}

/// What a touch is worth, or nothing when the two bodies are not judged.
fn seen(contact: &ContactSample, rule: Option<&RequiredPair>) -> Option<(Gravity, Finding)> {
    let ContactSample { depth_m: depth, normal_force_n: force, .. } = *contact;
    let allowed_depth = match rule {
        // Bodies of the robot that overlap by design.
        Some(RequiredPair { required: None, .. }) => return None,
        Some(RequiredPair { depth, .. }) => *depth,
        // Bodies that nobody expected to meet.
        None => None,
    };
    let (gravity, finding) = match allowed_depth {
        Some(limit) => {
            let finding = Finding::at_most(depth, limit, Unit::Meter);
            let gravity = if finding.passes {
                Gravity::Allowed(depth / limit)
            } else {
                Gravity::TooDeep(depth - limit)
            };
            (gravity, finding)
        }
        None if force > TOUCH_FORCE => {
            (Gravity::ForbiddenForce(force), Finding::at_most(force, TOUCH_FORCE, Unit::Newton))
        }
        None => (Gravity::ForbiddenOverlap(depth), Finding::at_most(depth, TOUCH_DEPTH, Unit::Meter)),
    };
    let why = match (rule.and_then(|pair| pair.reason.as_deref()), allowed_depth) {
        (Some(reason), Some(_)) => reason,
        _ => "they may not touch in this phase",
    };
    let note =
        Note::from("depth ").quantity(depth, Unit::Meter).and(", force ").quantity(force, Unit::Newton);
    let bodies = [contact.body_a.as_str(), contact.body_b.as_str()];
    Some((gravity, finding.at(seconds(contact.time_ns)).of(bodies).noted(note.and(format!("; {why}")))))
}

#[cfg(test)]
mod tests {
    use graspcheck_model::robot::AllowedContact;

    use crate::{
        Outcome, Unit,
        fixture::{self, contact, ns_of},
    };

    #[test]
    fn the_contacts_of_a_grasp_pass_with_the_depth_that_is_left() {
        let result = fixture::pick().check("executed.contacts");
        assert_eq!((result.outcome, result.unit), (Outcome::Pass, Unit::Meter), "{result:?}");
        assert_eq!(result.value, Some(1e-5));
        assert!(result.margin.unwrap() > 0.0);
    }

    #[test]
    fn bodies_that_may_not_touch_fail_with_pair_time_and_force() {
        let mut run = fixture::pick();
        run.recording.contacts.push(contact(ns_of(4.0), "palm", "table", 1e-4, 3.0));
        run.recording.contacts.push(contact(ns_of(4.5), "palm", "table", 1e-4, 2.0));
        let result = run.check("executed.contacts");
        assert_eq!((result.outcome, result.value, result.unit), (Outcome::Fail, Some(3.0), Unit::Newton));
        assert_eq!(result.place.subjects, ["palm", "table"]);
        assert_eq!(result.place.phase.as_deref(), Some("carry"));
        assert_eq!(result.violated, Some([4.0, 4.5]));
        assert!(
            result.note.to_string().contains("0.0001 m") && result.note.to_string().contains("3 N"),
            "{}",
            result.note
        );
    }

    #[test]
    fn what_may_touch_in_one_phase_may_not_in_another() {
        let mut run = fixture::pick();
        let early = contact(ns_of(0.5), "cube", "left_finger", 0.0, 1.0);
        run.recording.contacts.insert(0, early);
        let result = run.check("executed.contacts");
        assert_eq!((result.outcome, result.time), (Outcome::Fail, Some(0.5)), "{result:?}");
    }

    #[test]
    fn an_overlap_without_force_counts_where_nothing_may_touch() {
        let mut run = fixture::pick();
        run.recording.contacts.push(contact(ns_of(4.0), "carriage", "table", 1e-6, 0.0));
        let result = run.check("executed.contacts");
        assert_eq!((result.outcome, result.unit), (Outcome::Fail, Unit::Meter));
        // The order of the names does not matter.
        let mut run = fixture::pick();
        run.recording.contacts.push(contact(ns_of(4.0), "table", "carriage", 1e-6, 0.0));
        assert_eq!(run.check("executed.contacts").outcome, Outcome::Fail);
    }

    #[test]
    fn an_allowed_contact_that_is_too_deep_fails() {
        let mut run = fixture::pick();
        run.recording.contacts.push(contact(ns_of(3.0), "cube", "left_finger", 0.0006, 10.0));
        let result = run.check("executed.contacts");
        assert_eq!((result.outcome, result.value, result.unit), (Outcome::Fail, Some(0.0006), Unit::Meter));
    }

    #[test]
    fn bodies_that_are_apart_and_forces_of_nothing_do_not_count() {
        let mut run = fixture::pick();
        run.touch(contact(ns_of(4.0), "palm", "table", -0.001, 0.0));
        run.touch(contact(ns_of(4.0), "palm", "table", -0.001, super::TOUCH_FORCE));
        assert_eq!(run.check("executed.contacts").outcome, Outcome::Pass);
        run.touch(contact(ns_of(4.0), "palm", "table", -0.001, 0.011));
        assert_eq!(run.check("executed.contacts").outcome, Outcome::Fail);
    }

    #[test]
    fn bodies_of_the_robot_may_not_touch_each_other() {
        let mut run = fixture::pick();
        run.touch(contact(ns_of(4.0), "carriage", "left_finger", 0.0, 5.0));
        let result = run.check("executed.contacts");
        assert_eq!((result.outcome, result.value), (Outcome::Fail, Some(5.0)), "{result:?}");
        run.resolved.robot.allowed_contacts.push(AllowedContact {
            a: "left_finger".into(),
            b: "carriage".into(),
            reason: "for the test".into(),
        });
        assert_eq!(run.check("executed.contacts").outcome, Outcome::Pass);
    }

    #[test]
    fn contacts_that_are_missing_are_undecided_and_never_a_pass() {
        let mut run = fixture::pick();
        run.recording.contacts.clear();
        let result = run.check("executed.contacts");
        assert_eq!((result.outcome, result.time), (Outcome::Inconclusive, Some(0.0)), "{result:?}");
        let mut run = fixture::pick();
        let gone = run.recording.contacts.pop().unwrap();
        let result = run.check("executed.contacts");
        assert_eq!(result.outcome, Outcome::Inconclusive);
        assert_eq!(result.time, Some(gone.time_ns as f64 / 1e9));
        // One that is there and may not be is a fault all the same.
        run.recording.contacts.push(contact(ns_of(4.0), "palm", "table", 1e-4, 3.0));
        assert_eq!(run.check("executed.contacts").outcome, Outcome::Fail);
        let mut run = fixture::pick();
        run.recording.monitor.clear();
        assert_eq!(run.check("executed.contacts").outcome, Outcome::Inconclusive);
        // Between two steps there is nothing.
        let mut run = fixture::pick();
        run.recording.contacts.push(contact(ns_of(3.0) + 1, "cube", "left_finger", 1e-5, 1.0));
        assert_eq!(run.check("executed.contacts").outcome, Outcome::Inconclusive);
    }

    #[test]
    fn bodies_that_nobody_knows_may_not_touch() {
        let mut run = fixture::pick();
        run.recording.contacts.push(contact(ns_of(4.0), "ghost", "palm", 0.0, 1.0));
        assert_eq!(run.check("executed.contacts").outcome, Outcome::Fail);
    }

    #[test]
    fn no_contact_passes_with_no_force_and_a_nan_fails() {
        let mut run = fixture::pick();
        run.recording.contacts.clear();
        for sample in &mut run.recording.monitor {
            sample.contacts = 0;
        }
        let result = run.check("executed.contacts");
        assert_eq!((result.outcome, result.value, result.unit), (Outcome::Pass, Some(0.0), Unit::Newton));
        run.recording.contacts.push(contact(ns_of(3.0), "cube", "left_finger", f64::NAN, 1.0));
        let result = run.check("executed.contacts");
        assert_eq!((result.outcome, result.time), (Outcome::Fail, Some(3.0)));
    }

    #[test]
    fn contacts_without_a_run_are_no_evidence() {
        let mut run = fixture::pick();
        run.recording.measured = Default::default();
        assert_eq!(run.check("executed.contacts").outcome, Outcome::Inconclusive);
    }
}
