//! A pose that the tool goes to and leaves on straight lines, and the branches on which it can.

use graspcheck_model::{
    Pose,
    plan::{PlannedPath, TrackedPoint},
};
use graspcheck_motion::Trajectory;

use crate::{
    arm::Arm,
    candidate::{BranchChoice, CandidateOutcome, Stage},
    cartesian::{LineError, line_of, start_of_line},
    error::PlanError,
    pace::CheckedPace,
    path::motion::PATH_TOLERANCE,
};

/// A pose of the tool with the straight lines to it and away from it.
pub(crate) struct Stop {
    /// Where the line to the stop begins; the stop itself when there is none.
    pub(crate) world_from_before: Pose,
    /// The stop.
    pub(crate) world_from_tool: Pose,
    /// Where the line away from it ends; the stop itself when there is none.
    pub(crate) world_from_after: Pose,
    /// What fails when the pose, the line to it or the line away from it does.
    pub(crate) stages: [Stage; 3],
    /// Names of the phases of both lines.
    pub(crate) phases: [&'static str; 2],
}

/// A straight line as it is planned.
pub(crate) struct Line {
    /// The joints.
    pub(crate) motion: Trajectory,
    /// The path with its law of time.
    pub(crate) planned: PlannedPath,
}

/// A stop reached on one branch.
pub(crate) struct Reached {
    /// The solution at the stop.
    pub(crate) choice: BranchChoice,
    /// Joint positions before the line to the stop.
    pub(crate) before: Vec<f64>,
    /// Joint positions at the stop, as the line ends there.
    pub(crate) at: Vec<f64>,
    /// Joint positions after the line away from it.
    pub(crate) after: Vec<f64>,
    /// The motion to the stop; none when there is no line.
    pub(crate) arriving: Option<Line>,
    /// The motion away from it; none when there is no line.
    pub(crate) leaving: Option<Line>,
}

/// A branch on which a stop cannot be reached, or not left.
pub(crate) struct Rejected {
    /// The solution at the stop; none when there is none at all.
    pub(crate) choice: Option<BranchChoice>,
    /// What fails.
    pub(crate) stage: Stage,
    /// Why.
    pub(crate) outcome: CandidateOutcome,
}

impl Stop {
    /// All branches and turns: those on which the tool can go to the stop and leave it, and the others.
    ///
    /// # Errors
    /// When a line fails for a reason that another branch would not mend.
    pub(crate) fn branches(
        &self,
        arm: &Arm,
        pace: &CheckedPace,
    ) -> Result<Vec<Result<Reached, Rejected>>, PlanError> {
        let stage = self.stages[0];
        match arm.inverse.solve(&self.world_from_tool) {
            Err(bound) => {
                Ok(vec![Err(Rejected { choice: None, stage, outcome: CandidateOutcome::OutOfReach(bound) })])
            }
            Ok(solutions) => solutions
                .into_iter()
                .map(|solution| {
                    let worst =
                        solution.violations.iter().max_by(|a, b| a.excess.total_cmp(&b.excess)).copied();
                    let choice = BranchChoice { elbow: solution.elbow, turn: solution.turn, q: solution.q };
                    let Some(worst) = worst else { return self.reach(arm, pace, choice) };
                    let outcome = CandidateOutcome::Limit {
                        joint: arm.robot.joints[worst.joint].name.clone(),
                        value: worst.value,
                        limit: worst.limit,
                        excess: worst.excess,
                    };
                    Ok(Err(Rejected { choice: Some(choice), stage, outcome }))
                })
                .collect(),
        }
    }

    /// The lines to the stop and away from it on the branch of `choice`.
    fn reach(
        &self,
        arm: &Arm,
        pace: &CheckedPace,
        choice: BranchChoice,
    ) -> Result<Result<Reached, Rejected>, PlanError> {
        let line = |phase: &str, from: &[f64], goal: &Pose| {
            let (path, found) = line_of(arm, from, goal, pace.share(phase), pace.duration(phase))?;
            let end = found.motion.eval(found.motion.duration()).q;
            let tolerance = PATH_TOLERANCE.position;
            let (phase, point) = (phase.to_owned(), TrackedPoint::Tool);
            let planned = PlannedPath { phase, path, point, law: found.law, tolerance };
            Ok((Line { motion: found.motion, planned }, end))
        };
        let mut before = choice.q.clone();
        let mut at = choice.q.clone();
        let mut arriving = None;
        if self.world_from_before != self.world_from_tool {
            // The beginning is found backwards, so that the line ends on the branch of the choice.
            let found = start_of_line(arm, &self.world_from_before, &choice.q).and_then(|start| {
                let (motion, end) = line(self.phases[0], &start, &self.world_from_tool)?;
                Ok((start, motion, end))
            });
            match found {
                Ok((start, motion, end)) => (before, arriving, at) = (start, Some(motion), end),
                Err(error) => return self.reject(0, choice, error),
            }
        }
        let mut after = at.clone();
        let mut leaving = None;
        if self.world_from_after != self.world_from_tool {
            match line(self.phases[1], &at, &self.world_from_after) {
                Ok((motion, end)) => (leaving, after) = (Some(motion), end),
                Err(error) => return self.reject(1, choice, error),
            }
        }
        Ok(Ok(Reached { choice, before, at, after, arriving, leaving }))
    }

    /// A branch is rejected when it cannot be followed; any other error is one of the plan.
    fn reject(
        &self,
        line: usize,
        choice: BranchChoice,
        error: LineError,
    ) -> Result<Result<Reached, Rejected>, PlanError> {
        match error {
            LineError::Branch { at, fault } => Ok(Err(Rejected {
                choice: Some(choice),
                stage: self.stages[line + 1],
                outcome: CandidateOutcome::Line { at, fault },
            })),
            error => Err(PlanError::Line { phase: self.phases[line].to_owned(), error }),
        }
    }
}

impl Reached {
    /// How long both lines take, s.
    pub(crate) fn moving(&self) -> f64 {
        self.arriving.iter().chain(&self.leaving).map(|line| line.motion.duration()).sum()
    }
}
