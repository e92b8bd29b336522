//! `executed.stability`: no joint's control loop swings from one effort limit to the other and back.
//!
//! Gains that are too high for the controller's period, or a command that acts too late, make a loop grow until its
//! torque is limited; then it beats between both limits. A torque that is limited on one side for long, or on both sides once
//! for each motion, is saturation and nothing else; see `executed.saturation`.

use crate::{
    evidence::Evidence,
    finding::{Finding, Gap},
    stream::{self, JointStream},
    verdict::Unit,
};

/// So many swings from beyond one limit to beyond the other, each soon after the one before, are a loop that has
/// lost its stability. A motion swings once when it begins to brake.
const SWINGS_MAX: f64 = 7.0;

/// A swing comes soon within so many commands of the controller, …
const SOON_COMMANDS: f64 = 50.0;

/// … or within so many periods of its bandwidth.
const SOON_PERIODS: f64 = 1.0;

/// The swings of one joint that follow each other.
#[derive(Clone, Copy, Debug, Default)]
struct Train {
    /// Sign of the effort that was last beyond its limit, and when, s.
    last: Option<(bool, f64)>,
    swings: u32,
    start: f64,
    longest: u32,
    /// When the longest began and ended, s.
    span: [f64; 2],
}

impl Train {
    /// Takes an effort beyond its limit.
    fn beyond(&mut self, is_positive: bool, time: f64, soon: f64) {
        if let Some((was_positive, since)) = self.last {
            if time - since > soon {
                self.swings = 0;
            } else if was_positive != is_positive {
                if self.swings == 0 {
                    self.start = since;
                }
                self.swings += 1;
            }
            if self.swings > self.longest {
                self.longest = self.swings;
                self.span = [self.start, time];
            }
        }
        self.last = Some((is_positive, time));
    }
}

/// The longest train of swings of a joint.
pub(super) fn stability(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    stream::requested(evidence)?;
    let Some(execution) = &evidence.resolved.execution else {
        return Err(Gap::not_requested("the run was not executed"));
    };
    let bandwidth_period =
        execution.controller.gains().map_or(0.0, |(bandwidth, _)| std::f64::consts::TAU / bandwidth);
    let soon = f64::max(SOON_COMMANDS * execution.command_period(), SOON_PERIODS * bandwidth_period);
    let mut trains = vec![Train::default(); evidence.joints().len()];
    for sample in JointStream::commanded(evidence)?.samples() {
        if sample.effort.abs() > evidence.joints()[sample.joint].limits.effort {
            trains[sample.joint].beyond(sample.effort > 0.0, sample.time, soon);
        }
    }
    let worst = (0..trains.len())
        .reduce(|worst, joint| if trains[joint].longest > trains[worst].longest { joint } else { worst });
    let joint = worst.ok_or_else(|| Gap::inconclusive(None, "the arm has no joint"))?;
    let train = trains[joint];
    let mut finding = Finding::at_most(f64::from(train.longest), SWINGS_MAX, Unit::Count);
    if train.longest > 0 {
        finding = finding
            .at(train.span[0])
            .of([evidence.joints()[joint].name.as_str()])
            .during(evidence.phase_name(train.span[0]));
        if !finding.passes {
            finding.violated = Some(train.span);
        }
    }
    Ok(finding)
}

#[cfg(test)]
mod tests {
    use crate::{
        Outcome, Unit,
        fixture::{self, DT, Run},
    };

    /// The arm's second joint (limit 50) asks for 60 with a sign that changes at these rows.
    fn swinging(rows: impl Iterator<Item = usize>) -> Run {
        let mut run = fixture::pick();
        for (index, row) in rows.enumerate() {
            run.recording.reference.effort[4 * row + 1] = if index % 2 == 0 { 60.0 } else { -60.0 };
        }
        run
    }

    #[test]
    fn a_loop_that_beats_between_both_limits_fails_from_where_it_begins() {
        let result = swinging(100..130).check("executed.stability");
        assert_eq!((result.outcome, result.value), (Outcome::Fail, Some(29.0)), "{result:?}");
        assert_eq!(result.unit, Unit::Count);
        assert_eq!(result.place.subjects, ["turn"]);
        assert!((result.time.unwrap() - 100.0 * DT).abs() < 1e-9);
    }

    #[test]
    fn saturation_that_does_not_swing_soon_or_often_passes() {
        let none = fixture::pick().check("executed.stability");
        assert_eq!((none.outcome, none.value), (Outcome::Pass, Some(0.0)));
        // Seven swings in a row.
        assert_eq!(swinging(100..108).check("executed.stability").outcome, Outcome::Pass);
        assert_eq!(swinging(100..109).check("executed.stability").outcome, Outcome::Fail);
        // More of them, with rests longer than 50 commands.
        let rare = swinging((0..10).map(|k| 5 + 55 * k));
        let result = rare.check("executed.stability");
        assert_eq!((result.outcome, result.value), (Outcome::Pass, Some(0.0)));
        // Always on the same side.
        let mut run = fixture::pick();
        for row in 100..160 {
            run.recording.reference.effort[4 * row + 1] = 60.0;
        }
        assert_eq!(run.check("executed.stability").outcome, Outcome::Pass);
    }

    #[test]
    fn a_plan_that_is_not_executed_is_not_asked() {
        let mut run = fixture::pick();
        run.resolved.execution = None;
        run.recording = Default::default();
        assert_eq!(run.check("executed.stability").outcome, Outcome::NotRequested);
    }
}
