//! `planned.deviation`: how far the plan may take the tool from the paths on which it is led.
//!
//! The plan carries each path with its law of time. Nothing is believed of how it was made: the deviation of the joint
//! polynomials from the path is proved again here, over all instants ([`graspcheck_proof::deviation`]). It is held
//! against the tolerance that the path was planned with, or what the scenario demands if that is less.

use graspcheck_model::{
    plan::{Phase, PlannedPath, TrackedPoint},
    planar_path::PlanarPath,
};
use graspcheck_motion::{Trajectory, TrajectoryError};
use graspcheck_proof::deviation::{Deviation, DeviationOutcome, prove_deviation};

use crate::{
    evidence::Evidence,
    finding::{Finding, Gap, worst_by},
    verdict::Unit,
};

/// The largest share of a tolerance that the tool's deviation from a path can take: a proved bound, or, when it is
/// exceeded, what is proved to be the case at an instant.
pub(super) fn deviation(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let plan = &evidence.plan;
    if plan.paths.is_empty() {
        return Err(Gap::not_requested("the plan leads the tool on no path"));
    }
    let mut findings = Vec::with_capacity(plan.paths.len());
    for planned in &plan.paths {
        let phase = plan.phases.iter().find(|phase| phase.name == planned.phase).ok_or_else(|| {
            Gap::inconclusive(
                None,
                format!("there is a path for phase {}, which the plan has not", planned.phase),
            )
        })?;
        findings.push(of_path(evidence, planned, phase)?);
    }
    // Paths may have different tolerances, so that shares compare.
    let worst = worst_by(findings, |finding: &Finding| finding.value / finding.limit);
    worst.ok_or_else(|| Gap::inconclusive(None, "the plan has no path"))
}

/// What is found of one path.
fn of_path(evidence: &Evidence<'_>, planned: &PlannedPath, phase: &Phase) -> Result<Finding, Gap> {
    let undecided = |note: String| Gap::inconclusive(Some(phase.start), note);
    let path = PlanarPath::tracking(&evidence.resolved.robot, &planned.path, planned.point)
        .map_err(|(s, bound)| undecided(format!("the path of phase {} at s = {s}: {bound}", phase.name)))?;
    let motion = part(&evidence.plan.trajectory, phase)
        .map_err(|error| undecided(format!("the motion of phase {}: {error}", phase.name)))?;
    let limit =
        evidence.resolved.checks.deviation.map_or(planned.tolerance, |max| max.min(planned.tolerance));
    let tolerance = Deviation { position: limit, angle: limit };
    let outcome = prove_deviation(&path, &planned.law, &motion, tolerance)
        .map_err(|error| undecided(error.to_string()))?;
    let (found, time, proved) = match outcome {
        DeviationOutcome::Within(pieces) => {
            let share = |bound: &Deviation| bound.position.max(bound.angle);
            let worst = worst_by(pieces, |piece| share(&piece.bound))
                .ok_or_else(|| undecided("the motion has no stretch".to_owned()))?;
            (worst.bound, worst.start, true)
        }
        DeviationOutcome::Exceeds { at, deviation } => (deviation, at, false),
        DeviationOutcome::Unknown(piece) => {
            let time = phase.start + piece.start;
            let note = format!("the deviation could not be decided at {time} s");
            return Err(Gap::inconclusive(Some(time), note));
        }
    };
    let (value, unit) = if found.position >= found.angle {
        (found.position, Unit::Meter)
    } else {
        (found.angle, Unit::Radian)
    };
    let subject = match planned.point {
        TrackedPoint::Tool => "tool",
        TrackedPoint::Wrist => "wrist",
    };
    let mut finding =
        Finding::at_most(value, limit, unit).at(phase.start + time).of([subject]).during(phase.name.clone());
    finding.value_is_bound = proved;
    Ok(finding)
}

/// The motion during a phase, from time 0.
fn part(trajectory: &Trajectory, phase: &Phase) -> Result<Trajectory, TrajectoryError> {
    let knots = trajectory.knots();
    let pieces: Vec<usize> = (0..trajectory.piece_count())
        .filter(|&piece| (phase.start..phase.end).contains(&(0.5 * (knots[piece] + knots[piece + 1]))))
        .collect();
    let first = pieces.first().map_or(0.0, |&piece| knots[piece]);
    let times = pieces.iter().map(|&piece| knots[piece]).chain(pieces.last().map(|&piece| knots[piece + 1]));
    let polynomials = pieces.iter().flat_map(|&piece| trajectory.piece_of_all(piece)).copied().collect();
    Trajectory::new(trajectory.dof(), times.map(|t| t - first).collect(), polynomials)
}

#[cfg(test)]
mod tests {
    use graspcheck_model::{
        plan::{PlannedPath, TrackedPoint},
        tool_path::{ArcCurve, OrientationCurve, PositionCurve, ToolPath, ToolSegment},
    };
    use graspcheck_motion::{Polynomial, Trajectory};
    use nalgebra::Vector3;

    use crate::{
        Outcome,
        fixture::{self, Run},
        verdict::Unit,
    };

    /// The shoulder alone turns by 2 rad, so that the tool is on an arc about its axis, exactly.
    fn on_an_arc() -> Run {
        let mut run = fixture::blends();
        let motion = &run.plan.trajectory;
        let start = run.resolved.robot.world_from_tool(&motion.eval(0.0).q);
        let center = Vector3::new(0.0, 0.0, start.translation.z);
        let toward = start.translation.vector - center;
        let arc = ArcCurve {
            center,
            toward,
            across: Vector3::z().cross(&toward),
            rate: 2.0,
            along: Vector3::zeros(),
        };
        let turn = Polynomial::new([0.0, 2.0]);
        let path = ToolPath::new(vec![ToolSegment {
            start: 0.0,
            end: 1.0,
            position: PositionCurve::Arc(arc),
            orientation: OrientationCurve::turning(start.rotation, Vector3::z_axis(), turn),
        }])
        .unwrap();
        let half = |p: &Polynomial| Polynomial::new(p.coefficients().map(|c| 0.5 * c));
        let law = (0..motion.piece_count()).map(|piece| half(motion.piece(piece, 0))).collect();
        let law = Trajectory::new(1, motion.knots().to_vec(), law).unwrap();
        let point = TrackedPoint::Tool;
        run.plan.paths = vec![PlannedPath { phase: "via".into(), path, point, law, tolerance: 1e-5 }];
        run
    }

    /// The same with the elbow's polynomial of the second piece bent by `size` in its middle, and nowhere at its ends.
    fn bent(size: f64) -> Run {
        let mut run = on_an_arc();
        let motion = &run.plan.trajectory;
        let mut pieces: Vec<Polynomial> =
            (0..motion.piece_count()).flat_map(|piece| motion.piece_of_all(piece).to_vec()).collect();
        // 64 size τ³ (1 − τ)³ on a piece of 1 s.
        let mut c = *pieces[4].coefficients();
        for (power, factor) in [(3, 64.0), (4, -192.0), (5, 192.0), (6, -64.0)] {
            c[power] += size * factor;
        }
        pieces[4] = Polynomial::new(c);
        run.plan.trajectory = Trajectory::new(3, motion.knots().to_vec(), pieces).unwrap();
        run
    }

    #[test]
    fn a_tool_on_its_path_passes_with_a_bound_and_one_that_leaves_it_fails_where_it_does() {
        let on = on_an_arc().check("planned.deviation");
        assert_eq!(on.outcome, Outcome::Pass, "{on:?}");
        assert!(on.value.unwrap() < 1e-8 && on.value_is_bound, "{on:?}");

        // The elbow is 0.4 m before the tool, so that the angle is what is larger in number.
        let near = bent(8e-6).check("planned.deviation");
        assert_eq!((near.outcome, near.unit), (Outcome::Pass, Unit::Radian), "{near:?}");
        assert!((near.value.unwrap() - 8e-6).abs() < 1e-8, "{near:?}");

        let off = bent(4e-5).check("planned.deviation");
        assert_eq!(off.outcome, Outcome::Fail, "{off:?}");
        let time = off.time.unwrap();
        assert!(time > 1.0 && time < 2.0 && off.value.unwrap() > 1e-5 && !off.value_is_bound, "{off:?}");
        assert_eq!(off.place.phase.as_deref(), Some("via"));
    }

    #[test]
    fn a_scenario_can_demand_less_than_the_tolerance_but_not_allow_more() {
        let demanding = |size: f64, demand: f64| {
            let mut run = bent(size);
            run.resolved.checks.deviation = Some(demand);
            let result = run.check("planned.deviation");
            (result.outcome, result.limit.unwrap())
        };
        assert_eq!(demanding(8e-6, 5e-6), (Outcome::Fail, 5e-6));
        assert_eq!(demanding(8e-6, 9e-6), (Outcome::Pass, 9e-6));
        assert_eq!(demanding(4e-5, 1e-3), (Outcome::Fail, 1e-5));
    }

    #[test]
    fn a_path_of_the_wrist_is_not_one_of_the_tool() {
        let mut run = on_an_arc();
        run.plan.paths[0].point = TrackedPoint::Wrist;
        let off = run.check("planned.deviation");
        assert_eq!((off.outcome, off.place.subjects), (Outcome::Fail, vec!["wrist".to_owned()]));
    }

    #[test]
    fn what_cannot_be_compared_is_undecided() {
        let mut other_phase = on_an_arc();
        other_phase.plan.paths[0].phase = "carry".into();
        assert_eq!(other_phase.check("planned.deviation").outcome, Outcome::Inconclusive);

        let mut short = on_an_arc();
        short.plan.paths[0].law = Trajectory::hold(&[0.0], 1.0).unwrap();
        assert_eq!(short.check("planned.deviation").outcome, Outcome::Inconclusive);
    }

    #[test]
    fn a_plan_without_paths_is_not_judged() {
        assert_eq!(fixture::blends().check("planned.deviation").outcome, Outcome::NotRequested);
    }
}
