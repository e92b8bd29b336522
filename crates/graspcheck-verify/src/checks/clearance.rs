//! `planned.clearance`, `planned.certificate`: every pair of bodies keeps the distance it must at every
//! instant of the plan. Nothing is taken on trust: the proof is made again from the recorded plan, robot
//! and cell, and the one that travelled with the recording must be the same.

use graspcheck_model::plan::Plan;
use graspcheck_proof::{
    Leaf, MarginBounds, PairCertificate, PairVerdict, ProofOutcome, Scene, Sweep,
    certificate::CERTIFICATE_SCHEMA, minimum::MARGIN_TOLERANCE,
};

use crate::{
    evidence::Evidence,
    finding::{Finding, Gap, worst_by},
    note::Note,
    verdict::Unit,
};

/// How far two proofs of the same plan may differ in a distance (m), a time (s) or a direction: sines and
/// cosines of another system's mathematics differ by 1e-16, which a chain of joints makes 1e-14.
const SAME_PROOF: f64 = 1e-9;

/// How near the bounds of the least margin are brought to each other, as a share of it: the second digit
/// of a margin decides nothing, and a third one costs a hundred times the whole proof where a distance
/// stays the same over a long motion.
const MARGIN_SHARE: f64 = 0.01;

/// The same for margins so wide that their share would be coarser still, m.
const COARSE_TOLERANCE: f64 = 1e-3;

/// The pair with the least margin between its distance and the distance it must keep. When the plan is
/// free the value is a proved lower bound of the distance; when it is not, the distance at an instant.
pub(super) fn clearance(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let proof = evidence.proof()?;
    match proof.certificate.outcome() {
        ProofOutcome::Free => free(evidence),
        // A pair that the proof left undecided at one instant can be plainly too near at another.
        ProofOutcome::Violated | ProofOutcome::Unknown | ProofOutcome::NotChecked => {
            violated(evidence)?.ok_or_else(|| undecided(&proof.certificate.pairs))
        }
    }
}

fn free(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let proof = evidence.proof()?;
    let Some(bounds) = least_margin(&proof.scene, &evidence.plan) else {
        return Err(Gap::inconclusive(None, "there is no pair of bodies that must keep apart"));
    };
    // The search for the least margin stops at a tolerance; the proof knows that it is not negative.
    let margin = bounds.lower.max(proof.certificate.proved_margin());
    let mut finding = Finding::at_least(margin + bounds.required, bounds.required, Unit::Meter)
        .at(bounds.time)
        .of([bounds.a, bounds.b])
        .during(bounds.phase)
        .noted(format!(
            "{} pairs of solids at every instant, {} steps of proof",
            proof.certificate.pair_count,
            proof.certificate.leaf_count()
        ));
    finding.value_is_bound = true;
    Ok(finding)
}

/// The least margin, bracketed the more finely the smaller it is.
fn least_margin(scene: &Scene, plan: &Plan) -> Option<MarginBounds> {
    let coarse = scene.minimum_margin(plan, COARSE_TOLERANCE)?;
    let fine = (MARGIN_SHARE * coarse.lower).clamp(MARGIN_TOLERANCE, COARSE_TOLERANCE);
    if fine < COARSE_TOLERANCE { scene.minimum_margin(plan, fine) } else { Some(coarse) }
}

/// The pair that is nearest against what it must keep, at an instant at which it is too near; none when no
/// such instant is known.
fn violated(evidence: &Evidence<'_>) -> Result<Option<Finding>, Gap> {
    let proof = evidence.proof()?;
    let found = proof.certificate.violations().map(|(pair, at)| {
        let finding = Finding::at_least(at.distance, at.required, Unit::Meter).at(at.time);
        (finding.of([pair.a.as_str(), pair.b.as_str()]).during(at.phase.as_str()), at.points)
    });
    // The proof stops at any instant of a violation; the search for the least margin finds the worst, or
    // nothing but an upper bound that says nothing.
    let searched = proof.scene.minimum_margin(&evidence.plan, MARGIN_TOLERANCE).map(|bounds| {
        let distance = bounds.upper + bounds.required;
        let finding = Finding::at_least(distance, bounds.required, Unit::Meter).at(bounds.time);
        (finding.of([bounds.a, bounds.b]).during(bounds.phase), bounds.points)
    });
    let too_near = found.chain(searched.filter(|(finding, _)| finding.margin < 0.0));
    let Some((mut worst, [a, b])) = worst_by(too_near, |(finding, _)| -finding.margin) else {
        return Ok(None);
    };
    // Proved by a witness, even where the distance reads as what is required: an overlap may be known no
    // better than as deeper than it may be.
    worst.passes = false;
    worst.margin = worst.margin.min(0.0);
    let count = proof.certificate.violations().count();
    Ok(Some(worst.noted(Note::from("at ").vector(a, Unit::Meter).and(" and ").vector(b, Unit::Meter).and(
        match count {
            0 | 1 => "; no other pair of solids is nearer than it may be".to_owned(),
            count => format!("; {count} pairs of solids are nearer than they may be"),
        },
    ))))
}

fn undecided(pairs: &[PairCertificate]) -> Gap {
    let not_checked = pairs.iter().find_map(|pair| match &pair.verdict {
        PairVerdict::NotChecked { reason } => Some((pair, reason)),
        _ => None,
    });
    if let Some((pair, reason)) = not_checked {
        return Gap::inconclusive(None, format!("{} - {} was not checked: {reason}", pair.a, pair.b));
    }
    let doubt = pairs.iter().find_map(|pair| match &pair.verdict {
        PairVerdict::Unknown(doubt) => Some((pair, doubt)),
        _ => None,
    });
    let Some((pair, doubt)) = doubt else {
        return Gap::inconclusive(None, "there is no pair of bodies to look at");
    };
    let [low, high] = doubt.distance;
    let note = Note::from(format!("{} - {}: the distance of ", pair.a, pair.b))
        .quantity(low, Unit::Meter)
        .and(" to ")
        .quantity(high, Unit::Meter)
        .and(" is too near to the required ")
        .quantity(doubt.required, Unit::Meter)
        .and(" to tell");
    Gap::inconclusive(Some(doubt.interval[0]), note)
}

/// The number of pairs for which the recording's proof is not the one that is found here.
pub(super) fn certificate(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let stored = &evidence.certificate;
    if stored.schema < CERTIFICATE_SCHEMA {
        let note =
            format!("the recording's proof has the older form {}, which is not compared", stored.schema);
        return Err(Gap::inconclusive(None, note));
    }
    let found = &evidence.proof()?.certificate;
    let pair_count = found.pair_count;
    if pair_count == 0 {
        return Err(Gap::inconclusive(None, "there is no pair of bodies to look at"));
    }
    let listed = found.pairs.len().max(stored.pairs.len());
    let mut different: Vec<usize> = (0..listed)
        .filter(|&index| match (stored.pairs.get(index), found.pairs.get(index)) {
            (Some(stored), Some(found)) => !same_pair(stored, found),
            _ => true,
        })
        .collect();
    let all_alike = same(stored.duration, found.duration)
        && stored.pair_count == pair_count
        && stored.sweeps.len() == found.sweeps.len()
        && stored.sweeps.iter().zip(&found.sweeps).all(|(stored, found)| same_sweep(stored, found));
    if different.is_empty() && !all_alike {
        // What concerns many pairs may concern each of them.
        different = (0..listed).collect();
    }
    let count = if all_alike { different.len() } else { different.len().max(1) };
    let finding = Finding::at_most(count as f64, 0.0, Unit::Count);
    if count == 0 {
        return Ok(finding.noted(format!("the proofs of {pair_count} pairs are the same")));
    }
    let note = "the recording's proof is not the one that its plan, robot and cell give; \
                was the recording changed?";
    let first = different.first().and_then(|&first| found.pairs.get(first).or(stored.pairs.get(first)));
    Ok(match first {
        Some(pair) => finding.of([pair.a.as_str(), pair.b.as_str()]).noted(note),
        None => finding.noted(note),
    })
}

fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME_PROOF
}

fn same_pair(stored: &PairCertificate, found: &PairCertificate) -> bool {
    (&stored.a, stored.part_a, &stored.b, stored.part_b) == (&found.a, found.part_a, &found.b, found.part_b)
        && same_verdict(&stored.verdict, &found.verdict)
        && stored.leaves.len() == found.leaves.len()
        && stored.leaves.iter().zip(&found.leaves).all(|(stored, found)| same_leaf(stored, found))
}

fn same_verdict(stored: &PairVerdict, found: &PairVerdict) -> bool {
    match (stored, found) {
        (PairVerdict::Free { margin: stored }, PairVerdict::Free { margin: found }) => same(*stored, *found),
        (PairVerdict::Violated(stored), PairVerdict::Violated(found)) => {
            stored.phase == found.phase
                && same(stored.time, found.time)
                && same(stored.distance, found.distance)
                && same(stored.required, found.required)
        }
        (PairVerdict::Unknown(stored), PairVerdict::Unknown(found)) => {
            stored.phase == found.phase
                && same(stored.required, found.required)
                && (0..2).all(|end| same(stored.interval[end], found.interval[end]))
        }
        (PairVerdict::NotChecked { reason: stored }, PairVerdict::NotChecked { reason: found }) => {
            stored == found
        }
        _ => false,
    }
}

fn same_leaf(stored: &Leaf, found: &Leaf) -> bool {
    let numbers = |leaf: &Leaf| {
        let [x, y, z] = leaf.normal;
        [leaf.start, leaf.end, x, y, z, leaf.gap, leaf.loss, leaf.required]
    };
    numbers(stored).into_iter().zip(numbers(found)).all(|(stored, found)| same(stored, found))
}

fn same_sweep(stored: &Sweep, found: &Sweep) -> bool {
    let numbers = |sweep: &Sweep| {
        let ([a, b, c], [d, e, f]) = (sweep.min, sweep.max);
        [sweep.start, sweep.end, a, b, c, d, e, f]
    };
    (&stored.body, stored.part) == (&found.body, found.part)
        && numbers(stored).into_iter().zip(numbers(found)).all(|(stored, found)| same(stored, found))
}

#[cfg(test)]
mod tests {
    use graspcheck_model::cell::{CellBody, PairRule};
    use graspcheck_model::{Pose, shape::Shape};
    use graspcheck_proof::{Certificate, PairVerdict};
    use nalgebra::Vector3;

    use crate::{
        Basis, Outcome, Unit,
        fixture::{self, Run},
    };

    /// The pick with a post of 2 cm by 2 cm up to a height, `x` away from the middle.
    fn with_post(x: f64, height: f64) -> Run {
        let mut run = fixture::pick();
        run.resolved.cell.bodies.push(CellBody {
            name: "post".into(),
            shape: Shape::Box { half_extents: Vector3::new(0.01, 0.01, 0.5 * height) },
            world_from_shape: Pose::translation(x, 0.0, 0.5 * height),
        });
        run
    }

    #[test]
    fn a_free_plan_passes_with_a_proved_bound_near_the_true_distance() {
        let result = fixture::pick().check("planned.clearance");
        assert_eq!(
            (result.outcome, result.basis, result.unit),
            (Outcome::Pass, Basis::Proved, Unit::Meter),
            "{result:?}"
        );
        // The fingers end 1 cm below the tool, which goes down to 2 cm above the table; 5 mm are required.
        let value = result.value.unwrap();
        assert!(result.value_is_bound && value <= 0.01 && value > 0.01 - 5e-5 - 1e-9, "{result:?}");
        assert_eq!(result.limit, Some(0.005));
        assert!((result.margin.unwrap() - (value - 0.005)).abs() < 1e-12);
        assert!(result.place.subjects.contains(&"table".to_owned()), "{result:?}");
    }

    #[test]
    fn the_requirement_of_a_pair_decides() {
        let mut run = fixture::pick();
        run.resolved.cell.clearance.pairs.push(PairRule {
            a: "left_finger".into(),
            b: "table".into(),
            required: 0.012,
            reason: "for the test".into(),
        });
        let result = run.check("planned.clearance");
        assert_eq!((result.outcome, result.limit), (Outcome::Fail, Some(0.012)), "{result:?}");
        assert!((result.value.unwrap() - 0.01).abs() < 2e-5 && result.margin.unwrap() < 0.0);
    }

    #[test]
    fn a_collision_fails_with_pair_phase_and_a_negative_margin() {
        // The palm is at least 8 cm above the tool; its half length along x is 4 cm.
        let result = with_post(0.035, 0.13).check("planned.clearance");
        assert_eq!(result.outcome, Outcome::Fail);
        assert!(result.place.subjects.contains(&"post".to_owned()), "{result:?}");
        assert!(result.time.is_some() && result.place.phase.is_some());
        assert!(result.margin.unwrap() < 0.0 && !result.value_is_bound);
        assert_eq!(with_post(0.2, 0.13).check("planned.clearance").outcome, Outcome::Pass);
    }

    #[test]
    fn a_refuted_pair_fails_even_where_its_distance_reads_as_what_is_required() {
        for off in [0.0006, 0.002, 0.004] {
            let mut run = fixture::pick();
            let aside = |pose: &Pose| Pose::translation(0.0, off, 0.0) * pose;
            let object = run.resolved.object.as_mut().unwrap();
            object.world_from_object = aside(&object.world_from_object);
            let grasp = run.plan.grasp.as_mut().unwrap();
            grasp.world_from_start = aside(&grasp.world_from_start);
            let result = run.check("planned.clearance");
            assert_eq!(result.outcome, Outcome::Fail, "{off} m aside: {result:?}");
            assert!(result.margin.unwrap() <= 0.0 && result.place.subjects.contains(&"cube".to_owned()));
        }
    }

    #[test]
    fn an_arm_without_anything_to_hit_is_undecided() {
        let mut run = fixture::blends();
        run.resolved.cell.bodies.clear();
        for link in &mut run.resolved.robot.links {
            link.shapes.clear();
        }
        for finger in &mut run.resolved.robot.gripper.fingers {
            finger.link.shapes.clear();
        }
        assert_eq!(run.check("planned.clearance").outcome, Outcome::Inconclusive);
        assert_eq!(run.check("planned.certificate").outcome, Outcome::Inconclusive);
    }

    #[test]
    fn bodies_that_make_no_scene_are_undecided() {
        let mut run = with_post(0.2, 0.1);
        run.certificate = Some(run.proved());
        run.resolved.cell.bodies[1].name = "table".into();
        assert_eq!(run.check("planned.clearance").outcome, Outcome::Inconclusive);
        assert_eq!(run.check("executed.contacts").outcome, Outcome::Inconclusive);
    }

    #[test]
    fn the_proof_that_travelled_must_be_the_one_that_is_found() {
        let run = fixture::pick();
        let result = run.check("planned.certificate");
        assert_eq!((result.outcome, result.value), (Outcome::Pass, Some(0.0)), "{result:?}");

        let changes: [fn(&mut Certificate); 5] = [
            |certificate| {
                let PairVerdict::Free { margin } = &mut certificate.pairs[0].verdict else { panic!("free") };
                *margin += 1e-6;
            },
            |certificate| certificate.pairs[0].verdict = PairVerdict::NotChecked { reason: String::new() },
            |certificate| drop(certificate.pairs.pop()),
            |certificate| certificate.pairs[1].leaves[0].gap += 1e-6,
            |certificate| certificate.duration += 0.1,
        ];
        for change in changes {
            let mut run = fixture::pick();
            let mut certificate = run.proved();
            change(&mut certificate);
            run.certificate = Some(certificate);
            assert_eq!(run.check("planned.certificate").outcome, Outcome::Fail);
            assert_eq!(run.check("planned.clearance").outcome, Outcome::Pass);
        }
    }

    #[test]
    fn a_plan_that_was_changed_after_its_proof_is_found() {
        let mut run = fixture::pick();
        run.certificate = Some(run.proved());
        run.resolved.cell.bodies[0].world_from_shape = Pose::translation(0.0, 0.0, -0.051);
        let result = run.check("planned.certificate");
        assert_eq!(result.outcome, Outcome::Fail);
        assert!(result.value.unwrap() >= 1.0 && !result.place.subjects.is_empty());
    }

    #[test]
    fn a_proof_of_a_crash_travels_too() {
        let run = with_post(0.035, 0.13);
        assert!(!run.proved().is_free());
        assert_eq!(run.check("planned.certificate").outcome, Outcome::Pass);
    }
}
