//! Lanes of phases and checks, and the log of events.

use graspcheck_recording::Level;
use rerun::{
    EntityPath, EntityPathPart, RecordingStream, RecordingStreamError, StateChange, StateConfiguration,
    TextLog, TextLogLevel,
};

use crate::{
    PALETTE, RED, Run, color, nanoseconds, set_time,
    verdict::{Check, Outcome},
};

/// Lanes of checks; more would not fit, and those that fail have one in any case.
const MOST_CHECKS: usize = 4;

/// The least share of the run that a violation is shown with: 7 ms of 3 s would be one pixel.
const LEAST_SHOWN: f64 = 0.015;

/// Darker than the red of a violation, which is what must be seen.
const OK: u32 = 0x002c_5a3c;
const UNDECIDED: u32 = 0x00b0_8a1e;

/// The state after the end of the run, which is not shown. (A lane could also end without a state, but the
/// viewer's own verification does not accept that.)
const ENDED: &str = "ended";

pub(crate) fn log(stream: &RecordingStream, run: &Run) -> Result<(), RecordingStreamError> {
    log_phases(stream, run)?;
    if let Some(verdict) = run.verdict {
        let shown = |(rank, check): &(usize, &Check)| *rank < MOST_CHECKS || check.outcome != Outcome::Pass;
        for (_, check) in verdict.ranked().into_iter().enumerate().filter(shown) {
            log_check(stream, run, check)?;
        }
    }
    log_events(stream, run)
}

fn log_phases(stream: &RecordingStream, run: &Run) -> Result<(), RecordingStreamError> {
    let phases: Vec<_> = run.recording.events.iter().filter(|event| event.source == "phase").collect();
    if phases.is_empty() {
        return Ok(());
    }
    // Each name once, in order of its first use, with the colour of its stretch of the planned path.
    let mut colors: Vec<(&str, rerun::Color)> = Vec::new();
    for phase in &phases {
        if colors.iter().all(|(name, _)| *name != phase.message) {
            let path = run
                .recording
                .markers
                .iter()
                .find(|marker| marker.namespace == "plan" && marker.name == phase.message);
            let fallback = color(PALETTE[colors.len() % PALETTE.len()]);
            colors.push((&phase.message, path.map_or(fallback, crate::scene::marker_color)));
        }
    }
    stream.log_static("state/phase", &look(&colors))?;
    for phase in phases {
        set_time(stream, phase.time_ns);
        stream.log("state/phase", &StateChange::single(&*phase.message))?;
    }
    end_lane(stream, run, &"state/phase".into())
}

/// Two states only, since the viewer merges short neighbours of several colours into grey.
fn log_check(stream: &RecordingStream, run: &Run, check: &Check) -> Result<(), RecordingStreamError> {
    let entity: EntityPath =
        ["state", "verdict", &*check.check].map(EntityPathPart::new).into_iter().collect::<Vec<_>>().into();
    let violated = match (check.outcome, check.interval()) {
        (Outcome::Fail, Some([first, last])) => {
            let text = if first < last { format!("{first:.4}-{last:.4} s") } else { format!("{first:.4} s") };
            Some((text, widened([nanoseconds(first), nanoseconds(last)], run.end_ns)))
        }
        _ => None,
    };
    let (calm, calm_color) = match (check.outcome, &violated) {
        (Outcome::Inconclusive, _) => ("undecided", UNDECIDED),
        // It fails without an instant: the whole run does.
        (Outcome::Fail, None) => ("violated", RED),
        _ => ("ok", OK),
    };
    let mut states = vec![(calm, color(calm_color))];
    states.extend(violated.iter().map(|(text, _)| (text.as_str(), color(RED))));
    stream.log_static(entity.clone(), &look(&states))?;

    let change = |time_ns: i64, state: &str| {
        set_time(stream, time_ns);
        stream.log(entity.clone(), &StateChange::single(state))
    };
    match &violated {
        None => change(0, calm)?,
        Some((text, [first, last])) => {
            if *first > 0 {
                change(0, calm)?;
            }
            change(*first, text)?;
            if *last < run.end_ns {
                change(*last, calm)?;
            }
        }
    }
    end_lane(stream, run, &entity)
}

/// An interval of at least [`LEAST_SHOWN`] of the run about the same middle, inside the run; ns.
fn widened([first, last]: [i64; 2], end: i64) -> [i64; 2] {
    let missing = ((LEAST_SHOWN * end as f64) as i64 - (last - first)).max(0);
    let first = (first - missing / 2).clamp(0, end);
    [first, (last + missing - missing / 2).clamp(first, end)]
}

/// Ends a lane with the run.
fn end_lane(stream: &RecordingStream, run: &Run, entity: &EntityPath) -> Result<(), RecordingStreamError> {
    set_time(stream, run.end_ns);
    stream.log(entity.clone(), &StateChange::single(ENDED))
}

/// How the states of a lane look.
fn look(states: &[(&str, rerun::Color)]) -> StateConfiguration {
    let ended = (ENDED, color(0));
    let all = || states.iter().chain([&ended]);
    StateConfiguration::new()
        .with_values(all().map(|(name, _)| *name))
        .with_colors(all().map(|(_, color)| *color))
        .with_visible(all().map(|(name, _)| *name != ENDED))
}

fn log_events(stream: &RecordingStream, run: &Run) -> Result<(), RecordingStreamError> {
    for event in &run.recording.events {
        let level = match event.level {
            Level::Info => TextLogLevel::INFO,
            Level::Warn => TextLogLevel::WARN,
            Level::Error => TextLogLevel::ERROR,
        };
        set_time(stream, event.time_ns);
        let text = format!("{}: {}", event.source, event.message);
        stream.log("events", &TextLog::new(text).with_level(level))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_violation_is_widened_inside_the_run() {
        assert_eq!(widened([1000, 1002], 2000), [986, 1016]);
        assert_eq!(widened([0, 2], 2000), [0, 16]);
        assert_eq!(widened([1999, 2000], 2000), [1985, 2000]);
        assert_eq!(widened([500, 900], 2000), [500, 900]);
        assert_eq!(widened([0, 0], 0), [0, 0]);
    }
}
