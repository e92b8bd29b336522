//! How fast each phase goes: the pace of the whole motion and what phases say otherwise.

use graspcheck_model::task::{Pace, PhasePace};

use crate::joint_move::Pacing;

/// Why a pace makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PaceError {
    /// A share of the limits is not in (0, 1].
    #[error("{phase}: share {value} of the limits is not above 0 and at most 1")]
    Share {
        /// Name of the phase, or `all phases`.
        phase: String,
        /// The share.
        value: f64,
    },
    /// A duration is not positive or not finite.
    #[error("{phase}: duration {value} s is not positive")]
    Duration {
        /// Name of the phase.
        phase: String,
        /// The duration, s.
        value: f64,
    },
    /// No phase has this name.
    #[error("phase {phase}: the task has no such phase, only {}", known.join(", "))]
    UnknownPhase {
        /// The name.
        phase: String,
        /// Names of the phases that the task can have.
        known: Vec<String>,
    },
    /// A law of time or a synchronisation is given for a phase that is no joint move.
    #[error(
        "phase {phase}: it is no joint move, so that its law of time cannot be chosen; those that are: {}",
        if joint_moves.is_empty() { "none".to_owned() } else { joint_moves.join(", ") }
    )]
    LawOfLed {
        /// The name.
        phase: String,
        /// Names of the joint moves of the task.
        joint_moves: Vec<String>,
    },
    /// Two entries are for the same phase.
    #[error("phase {phase}: its pace is given twice")]
    Twice {
        /// The name.
        phase: String,
    },
}

/// The pace of a motion, known to be sound.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CheckedPace<'a>(&'a Pace);

/// The phases that a task can have.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PhaseNames<'a> {
    /// All of them.
    pub(crate) all: &'a [&'a str],
    /// Those of them that are joint moves, whose law of time may be chosen.
    pub(crate) joint_moves: &'a [&'a str],
}

impl<'a> CheckedPace<'a> {
    /// `pace`, if it is sound for a task that has phases of these names.
    ///
    /// # Errors
    /// The first thing that is not.
    pub(crate) fn new(pace: &'a Pace, phases: PhaseNames<'_>) -> Result<Self, PaceError> {
        check_share("all phases", pace.share)?;
        for (index, PhasePace { phase, share, duration, law, sync }) in pace.phases.iter().enumerate() {
            if !phases.all.contains(&phase.as_str()) {
                let known = phases.all.iter().map(ToString::to_string).collect();
                return Err(PaceError::UnknownPhase { phase: phase.clone(), known });
            }
            if pace.phases[..index].iter().any(|earlier| earlier.phase == *phase) {
                return Err(PaceError::Twice { phase: phase.clone() });
            }
            if (law.is_some() || sync.is_some()) && !phases.joint_moves.contains(&phase.as_str()) {
                let joint_moves = phases.joint_moves.iter().map(ToString::to_string).collect();
                return Err(PaceError::LawOfLed { phase: phase.clone(), joint_moves });
            }
            if let Some(share) = share {
                check_share(phase, *share)?;
            }
            if let Some(value) = *duration
                && !(value > 0.0 && value.is_finite())
            {
                return Err(PaceError::Duration { phase: phase.clone(), value });
            }
        }
        Ok(Self(pace))
    }

    /// Share of the limits that a phase uses.
    pub(crate) fn share(&self, phase: &str) -> f64 {
        self.of(phase).and_then(|own| own.share).unwrap_or(self.0.share)
    }

    /// The exact duration that a phase is given, s.
    pub(crate) fn duration(&self, phase: &str) -> Option<f64> {
        self.of(phase).and_then(|own| own.duration)
    }

    /// How the joint move of a phase goes.
    pub(crate) fn pacing(&self, phase: &str) -> Pacing {
        let own = self.of(phase);
        Pacing {
            share: self.share(phase),
            duration: self.duration(phase),
            law: own.and_then(|own| own.law).unwrap_or(self.0.law),
            sync: own.and_then(|own| own.sync).unwrap_or(self.0.sync),
        }
    }

    fn of(&self, phase: &str) -> Option<&PhasePace> {
        self.0.phases.iter().find(|own| own.phase == phase)
    }
}

fn check_share(phase: &str, value: f64) -> Result<(), PaceError> {
    if value > 0.0 && value <= 1.0 {
        Ok(())
    } else {
        Err(PaceError::Share { phase: phase.to_owned(), value })
    }
}

#[cfg(test)]
mod tests {
    use graspcheck_model::task::{Sync, TimeLaw};

    use super::*;

    fn pace(share: f64, phases: Vec<PhasePace>) -> Pace {
        Pace { share, law: Default::default(), sync: Default::default(), phases, set_points: None }
    }

    fn names<'a>(all: &'a [&'a str]) -> PhaseNames<'a> {
        PhaseNames { all, joint_moves: &["carry"] }
    }

    fn of(phase: &str, share: Option<f64>, duration: Option<f64>) -> PhasePace {
        PhasePace { phase: phase.to_owned(), share, duration, ..PhasePace::default() }
    }

    #[test]
    fn a_phase_overrides_what_it_says_and_nothing_else() {
        let pace = pace(0.9, vec![of("lift", Some(0.5), None), of("carry", None, Some(0.41))]);
        let checked = CheckedPace::new(&pace, names(&["lift", "carry", "lower"])).unwrap();
        assert_eq!((checked.share("lift"), checked.duration("lift")), (0.5, None));
        assert_eq!((checked.share("carry"), checked.duration("carry")), (0.9, Some(0.41)));
        assert_eq!((checked.share("lower"), checked.duration("lower")), (0.9, None));
    }

    #[test]
    fn unsound_paces_are_errors_that_name_the_phase() {
        let error = |pace: &Pace| CheckedPace::new(pace, names(&["lift"])).unwrap_err().to_string();
        assert_eq!(
            error(&pace(1.2, vec![])),
            "all phases: share 1.2 of the limits is not above 0 and at most 1"
        );
        assert!(error(&pace(f64::NAN, vec![])).contains("share NaN"));
        assert_eq!(
            error(&pace(1.0, vec![of("lift", None, Some(0.0))])),
            "lift: duration 0 s is not positive"
        );
        assert_eq!(
            error(&pace(1.0, vec![of("lfit", None, None)])),
            "phase lfit: the task has no such phase, only lift"
        );
        assert_eq!(
            error(&pace(1.0, vec![of("lift", None, None), of("lift", None, None)])),
            "phase lift: its pace is given twice"
        );
    }

    #[test]
    fn a_law_is_for_joint_moves_alone() {
        let mut pace = pace(1.0, vec![of("carry", None, None)]);
        pace.sync = Sync::EndTimes;
        pace.phases[0].law = Some(TimeLaw::Quintic);
        let checked = CheckedPace::new(&pace, names(&["lift", "carry"])).unwrap();
        let carry = checked.pacing("carry");
        assert_eq!((carry.law, carry.sync), (TimeLaw::Quintic, Sync::EndTimes));
        assert_eq!(checked.pacing("lift").law, TimeLaw::SCurve);
        pace.phases[0].phase = "lift".to_owned();
        let error = CheckedPace::new(&pace, names(&["lift", "carry"])).unwrap_err().to_string();
        assert!(
            error.starts_with("phase lift: it is no joint move") && error.ends_with("are: carry"),
            "{error}"
        );
    }
}
