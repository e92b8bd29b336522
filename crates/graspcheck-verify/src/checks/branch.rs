//! `planned.branch`: where the tool is led on a path, the elbow keeps its side; `planned.singularity`: the arm keeps
//! away from singular poses. Both at every instant; see [`graspcheck_proof::singular`].
//!
//! A joint move may change sides on purpose, and then passes through a singular pose, which does it no harm. On a
//! path it must not: the joints would have to turn at unbounded speed. So `planned.branch` looks at the phases that
//! follow a path, and at all of the plan when the scenario asks for it; `planned.singularity` is made on request, for
//! all of the plan.

use graspcheck_proof::singular::{Measure, NearestSingular, nearest_singular};

use crate::{
    evidence::Evidence,
    finding::{Finding, Gap, worst_by},
    verdict::Unit,
};

/// How near the elbow comes to changing sides where it must not: more than 0, or it does.
pub(super) fn branch(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let plan = &evidence.plan;
    let is_on_path = |name: &str| plan.paths.iter().any(|path| path.phase == name);
    let throughout = evidence.resolved.checks.branch_throughout;
    let phases = plan.phases.iter().filter(|phase| throughout || is_on_path(&phase.name));
    let nearest = phases.map(|phase| {
        let found = nearest(evidence, [phase.start, phase.end]);
        (found, phase.name.as_str())
    });
    let (found, phase) = worst_by(nearest, |(found, _)| -found.lower)
        .ok_or_else(|| Gap::not_requested("the plan leads the tool on no path"))?;
    if found.lower == 0.0 && found.upper > 0.0 {
        return Err(undecided(&found));
    }
    let mut finding = Finding::at_least(found.lower, 0.0, Unit::One).at(found.time).during(phase);
    // At 0 it passes from one side to the other.
    finding.passes = found.lower > 0.0;
    finding.violated = (!finding.passes).then_some([found.time, found.time]);
    Ok(named(finding, &found, evidence))
}

/// The least distance from a singular pose.
pub(super) fn singularity(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    let least = evidence.resolved.checks.singularity_min;
    let least = least.ok_or_else(|| Gap::not_requested("no distance from singular poses is required"))?;
    let found = nearest(evidence, [0.0, evidence.plan.duration()]);
    let proved = Finding::at_least(found.lower, least, Unit::One);
    let reached = Finding::at_least(found.upper, least, Unit::One);
    if !proved.passes && reached.passes {
        return Err(undecided(&found));
    }
    let mut finding = if proved.passes { proved } else { reached };
    finding.value_is_bound = finding.passes;
    let phase = evidence.phase_name(found.time);
    Ok(named(finding.by_share().at(found.time).during(phase), &found, evidence))
}

fn nearest(evidence: &Evidence<'_>, ends: [f64; 2]) -> NearestSingular {
    nearest_singular(&evidence.resolved.robot, &evidence.plan.trajectory, ends)
}

fn undecided(found: &NearestSingular) -> Gap {
    Gap::inconclusive(
        Some(found.time),
        format!(
            "the least singular value is between {} and {}, which does not tell",
            found.lower, found.upper
        ),
    )
}

fn named(finding: Finding, found: &NearestSingular, evidence: &Evidence<'_>) -> Finding {
    match found.measure {
        Measure::Elbow => {
            finding.of([evidence.joints()[1].name.as_str()]).noted("sine of the elbow's angle from straight")
        }
        Measure::SingularValue => finding
            .of(["tool"])
            .noted("least singular value of the tool's Jacobian, distances in units of the arm's length"),
    }
}

#[cfg(test)]
mod tests {
    use crate::{Basis, Outcome, fixture};

    #[test]
    fn neither_is_asked_for_without_a_path_or_a_limit() {
        let run = fixture::pick();
        assert_eq!(run.check("planned.branch").outcome, Outcome::NotRequested);
        assert_eq!(run.check("planned.singularity").outcome, Outcome::NotRequested);
    }

    #[test]
    fn a_chain_without_an_elbow_is_judged_by_its_singular_values() {
        // A lift and a turn: the columns of the Jacobian are at right angles, whatever the pose.
        let mut run = fixture::pick();
        run.resolved.checks.branch_throughout = true;
        let result = run.check("planned.branch");
        assert_eq!((result.outcome, result.basis), (Outcome::Pass, Basis::Proved), "{result:?}");
        let value = result.value.unwrap();
        run.resolved.checks.singularity_min = Some(0.9 * value);
        assert_eq!(run.check("planned.singularity").outcome, Outcome::Pass);
        run.resolved.checks.singularity_min = Some(1.1 * value);
        let result = run.check("planned.singularity");
        assert_eq!(result.outcome, Outcome::Fail, "{result:?}");
        assert!(result.note.to_string().contains("singular value"));
    }
}
