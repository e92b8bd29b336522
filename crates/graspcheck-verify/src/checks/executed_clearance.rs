//! `executed.clearance`, `executed.tube`: the distances of the motion that was executed, proved for every
//! instant between the rows of the log, too; and what the plan has left when tracking may be as bad as it was.

use graspcheck_proof::{CourseClearance, CourseDoubt, MarginBounds, ProofOutcome};

use crate::{
    evidence::Evidence,
    finding::{Finding, Gap},
    note::Note,
    stream,
    verdict::Unit,
};

/// The pair with the least margin along the executed motion: joints and object on the pieces through the
/// logged positions and velocities. Bodies that may touch must not be too deep in each other.
pub(super) fn clearance(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    stream::requested(evidence)?;
    let motion = evidence.motion()?;
    let scene = &evidence.proof()?.scene;
    let found = scene.clearance_of(&evidence.plan, motion).map_err(|fault| Gap::inconclusive(None, fault))?;
    let least = decided(&found)?;
    let note = Note::from(format!("{} pairs of solids at every instant, {} looks", found.pairs, found.looks));
    Ok(match found.outcome {
        ProofOutcome::Violated => {
            let [a, b] = least.points;
            let note = Note::from("at ").vector(a, Unit::Meter).and(" and ").vector(b, Unit::Meter);
            refuted(least, least.upper).noted(note)
        }
        _ => proved(least).noted(note),
    })
}

/// The least distance of bodies that may not touch, anywhere within the tracking error of the plan.
pub(super) fn tube(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    stream::requested(evidence)?;
    let motion = evidence.motion()?;
    let scene = &evidence.proof()?.scene;
    let tube = scene.tracking_tube(&evidence.plan, motion).map_err(|fault| Gap::inconclusive(None, fault))?;
    let least = decided(&tube.clearance)?;
    let mut note = Note::from("tracking errors of at most ");
    for (index, (joint, error)) in evidence.joints().iter().zip(&tube.errors).enumerate() {
        let unit = Unit::of_derivative(joint.kind, 0);
        note = note.and(if index == 0 { "" } else { ", " }).quantity(*error, unit);
    }
    Ok(match tube.clearance.outcome {
        ProofOutcome::Violated => {
            let mut finding = refuted(least, least.lower);
            finding.value_is_bound = true;
            finding
        }
        _ => proved(least),
    }
    .noted(note))
}

/// The bounds of a search that came to an end.
fn decided(found: &CourseClearance) -> Result<&MarginBounds, Gap> {
    if let Some(CourseDoubt { a, b, phase, interval, margin }) = &found.doubt {
        let note = Note::from(format!(
            "{a} - {b}, {phase}: whether it keeps its distance could not be told; its margin is at least "
        ))
        .quantity(*margin, Unit::Meter);
        return Err(Gap::inconclusive(Some(interval[0]), note));
    }
    match (&found.outcome, &found.least) {
        (ProofOutcome::Free | ProofOutcome::Violated, Some(least)) => Ok(least),
        (ProofOutcome::NotChecked, _) if found.pairs == 0 && found.looks > 0 => {
            Err(Gap::inconclusive(None, "a distance cannot be computed"))
        }
        _ => Err(Gap::inconclusive(None, "there is no pair of bodies that must keep apart")),
    }
}

fn proved(least: &MarginBounds) -> Finding {
    // The search stops at a tolerance; it knows that the margin is not negative.
    let margin = least.lower.max(0.0);
    let mut finding = Finding::at_least(margin + least.required, least.required, Unit::Meter);
    finding.value_is_bound = true;
    placed(finding, least)
}

fn refuted(least: &MarginBounds, margin: f64) -> Finding {
    let mut finding = Finding::at_least(margin + least.required, least.required, Unit::Meter);
    finding.passes = false;
    finding.margin = finding.margin.min(0.0);
    placed(finding, least)
}

fn placed(finding: Finding, least: &MarginBounds) -> Finding {
    finding.at(least.time).of([least.a.as_str(), least.b.as_str()]).during(least.phase.as_str())
}

#[cfg(test)]
mod tests {
    use graspcheck_model::{Pose, cell::CellBody, shape::Shape};
    use nalgebra::Vector3;

    use crate::{
        Basis, Outcome, Unit,
        fixture::{self, DT, Run},
    };

    fn with_post(half: f64, at: [f64; 3]) -> Run {
        let mut run = fixture::pick();
        run.resolved.cell.bodies.push(CellBody {
            name: "post".into(),
            shape: Shape::Box { half_extents: Vector3::from_element(half) },
            world_from_shape: Pose::translation(at[0], at[1], at[2]),
        });
        run
    }

    #[test]
    fn a_perfect_execution_has_the_clearance_of_its_plan_and_so_has_the_tube() {
        let run = fixture::pick();
        let planned = run.check("planned.clearance").value.unwrap();
        let result = run.check("executed.clearance");
        assert_eq!(
            (result.outcome, result.basis, result.unit, result.limit),
            (Outcome::Pass, Basis::Proved, Unit::Meter, Some(0.005)),
            "{result:?}"
        );
        assert!((result.value.unwrap() - planned).abs() < 1e-4 && result.value_is_bound, "{result:?}");
        let tube = run.check("executed.tube");
        assert_eq!((tube.outcome, tube.limit), (Outcome::Pass, Some(0.0)), "{tube:?}");
        // Cubics through rows 10 ms apart leave the quintics by h⁴/384 of their fourth derivative.
        assert!((tube.value.unwrap() - planned).abs() < 2e-4, "{tube:?}");
    }

    /// The arm swings aside between two rows, where no sample sees it, and back.
    #[test]
    fn a_collision_between_two_rows_is_found() {
        // Half a millimetre beside a corner of the palm, and at a height that it has at the start only.
        let mut run = with_post(0.01, [0.035, 0.06 + 0.0005 + 0.01, 0.275]);
        run.resolved.cell.clearance.required = 1e-4;
        assert_eq!(run.check("executed.clearance").outcome, Outcome::Pass);
        let row = run.rows_from(0.1).start;
        // Out at 30 rad/s and back: by (h/4) 30 rad/s = 4.3° in the middle.
        run.recording.measured.velocity[4 * row + 1] = 30.0;
        run.recording.measured.velocity[4 * (row + 1) + 1] = -30.0;
        let result = run.check("executed.clearance");
        assert_eq!(result.outcome, Outcome::Fail, "{result:?}");
        let time = result.time.unwrap();
        assert!(time > 0.1 && time < 0.1 + DT, "{result:?}");
        assert!(result.place.subjects.contains(&"post".to_owned()));
    }

    #[test]
    fn a_lost_object_is_seen_where_it_is_and_not_where_it_was_planned() {
        let mut run = fixture::pick();
        for row in run.rows_from(3.5) {
            // It stays on the table from the middle of the lift on.
            run.recording.object.pose[row] = run.recording.object.pose[0];
        }
        let result = run.check("executed.clearance");
        assert_eq!(result.outcome, Outcome::Fail, "{result:?}");
        assert!(result.place.subjects.contains(&"cube".to_owned()), "{result:?}");
        // As planned it is 11 cm above it.
        let planned = run.check("planned.clearance");
        assert_eq!(planned.outcome, Outcome::Pass);
    }

    #[test]
    fn a_tracking_error_takes_from_the_tube() {
        let mut run = fixture::pick();
        let before = run.check("executed.tube").value.unwrap();
        for row in run.rows_from(0.0) {
            run.recording.measured.position[4 * row] += 3e-3;
        }
        let tube = run.check("executed.tube");
        assert!((before - tube.value.unwrap() - 3e-3).abs() < 2e-4, "{tube:?} {before}");
        // 11 mm would take all of the 10 mm between the fingers and the table.
        for row in run.rows_from(0.0) {
            run.recording.measured.position[4 * row] += 8e-3;
        }
        let tube = run.check("executed.tube");
        assert_eq!(tube.outcome, Outcome::Fail, "{tube:?}");
        assert!(tube.margin.unwrap() < 0.0, "{tube:?}");
    }

    #[test]
    fn without_rows_it_is_undecided_and_without_an_execution_not_asked() {
        for name in ["executed.clearance", "executed.tube"] {
            let mut run = fixture::pick();
            run.recording.object = Default::default();
            assert_eq!(run.check(name).outcome, Outcome::Inconclusive);
            let mut run = fixture::pick();
            run.recording.measured = Default::default();
            assert_eq!(run.check(name).outcome, Outcome::Inconclusive);
            run.resolved.execution = None;
            assert_eq!(run.check(name).outcome, Outcome::NotRequested);
        }
    }
}
