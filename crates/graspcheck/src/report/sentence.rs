//! One finding as one sentence: place, quantity, value, verb, limit, time.

use graspcheck_verify::{CheckResult, Note, NotePart, Outcome};

use super::quantity::{Rounding, against, instant, margin, margin_between, quantity};

/// The word of a check without the motion it judges: `jerk` of `planned.jerk`, `place angle` of
/// `executed.place_angle`.
#[must_use]
pub fn word(check: &str) -> String {
    check.split_once('.').map_or(check, |(_, word)| word).replace('_', " ")
}

/// The motion that a check judges: `planned` of `planned.jerk`.
#[must_use]
pub fn motion(check: &str) -> &str {
    check.split_once('.').map_or("", |(motion, _)| motion)
}

/// The subjects of a finding: `shoulder`, or `cube - wall` for a pair; `–` when it names none.
#[must_use]
pub fn subject(result: &CheckResult) -> String {
    if result.place.subjects.is_empty() { "–".to_owned() } else { result.place.subjects.join(" - ") }
}

/// Which way a bound on the value must be rounded: towards the limit, so that it stays a bound.
#[must_use]
pub(super) fn rounding(result: &CheckResult) -> Rounding {
    match (result.value_is_bound, is_lower_limit(result)) {
        (false, _) => Rounding::Nearest,
        (true, true) => Rounding::Down,
        (true, false) => Rounding::Up,
    }
}

/// Whether the value must stay above its limit (a clearance) rather than below it (a jerk).
#[must_use]
pub fn is_lower_limit(result: &CheckResult) -> bool {
    match (result.value, result.limit, result.margin) {
        (Some(value), Some(limit), Some(margin)) => (value >= limit) == (margin >= 0.0),
        _ => false,
    }
}

/// The margin of a finding with its sign, fitting the value and the limit that stand beside it.
#[must_use]
pub(super) fn room(result: &CheckResult) -> Option<String> {
    let room = result.margin?;
    Some(match (result.value, result.limit) {
        (Some(value), Some(limit)) if !result.margin_is_share => {
            margin_between(value, limit, room, result.unit, rounding(result))
        }
        _ => margin(room, result.margin_is_share, result.unit),
    })
}

/// The finding as a sentence, e.g.
/// `shoulder: jerk 41505 °/s³ exceeds 40000 °/s³ by 3.8 % at t = 1.529 s (carry)`.
#[must_use]
pub fn sentence(result: &CheckResult) -> String {
    let mut text = String::new();
    if !result.place.subjects.is_empty() {
        text.push_str(&subject(result));
        text.push_str(": ");
    }
    text.push_str(&word(&result.check));
    match (result.outcome, result.value, result.limit) {
        (Outcome::Fail, Some(value), Some(limit)) => {
            let by = room(result).filter(|_| result.margin.is_some_and(|margin| margin < 0.0));
            let (value, limit) = against(value, limit, result.unit, rounding(result));
            let verb = if is_lower_limit(result) { "is below" } else { "exceeds" };
            text.push_str(&format!(" {value} {verb} {limit}"));
            if let Some(by) = by {
                text.push_str(&format!(" by {}", by.trim_start_matches(['-', '+'])));
            }
        }
        (Outcome::Pass, Some(value), Some(limit)) => {
            let (value, limit) = against(value, limit, result.unit, rounding(result));
            text.push_str(&format!(" {value}, limit {limit}"));
        }
        (_, Some(value), None) => {
            text.push_str(&format!(" {}", quantity(value, result.unit, rounding(result))));
        }
        (Outcome::Inconclusive, ..) => text.push_str(" could not be decided"),
        (Outcome::NotRequested, ..) => text.push_str(" was not requested"),
        (Outcome::Fail, ..) => text.push_str(" fails"),
        (Outcome::Pass, ..) => text.push_str(" holds"),
    }
    if let Some(t) = result.time {
        text.push_str(&format!(" at t = {}", instant(t)));
    }
    if let Some(phase) = &result.place.phase {
        text.push_str(&format!(" ({phase})"));
    }
    if !result.note.is_empty() && result.outcome != Outcome::Pass {
        text.push_str("; ");
        text.push_str(&note(&result.note));
    }
    text
}

/// A note with its quantities in the units for people.
#[must_use]
pub fn note(note: &Note) -> String {
    let part = |part: &NotePart| match part {
        NotePart::Words(words) => words.clone(),
        NotePart::Quantity { value, unit } => quantity(*value, *unit, Rounding::Nearest),
    };
    note.parts.iter().map(part).collect()
}

#[cfg(test)]
mod tests {
    use graspcheck_verify::{Basis, Note, Place, Unit};

    use super::*;

    fn jerk() -> CheckResult {
        CheckResult {
            check: "planned.jerk".into(),
            outcome: Outcome::Fail,
            value: Some(41_505_f64.to_radians()),
            limit: Some(40_000_f64.to_radians()),
            unit: Unit::RadianPerSecond3,
            margin: Some(-0.037_625),
            margin_is_share: true,
            value_is_bound: false,
            time: Some(1.5287),
            violated: Some([1.5287, 1.719]),
            place: Place { subjects: vec!["shoulder".into()], phase: Some("carry".into()) },
            basis: Basis::Exact,
            note: Note::default(),
            stretch: None,
        }
    }

    #[test]
    fn an_upper_limit_is_exceeded() {
        assert_eq!(
            sentence(&jerk()),
            "shoulder: jerk 41505 °/s³ exceeds 40000 °/s³ by 3.8 % at t = 1.529 s (carry)"
        );
    }

    #[test]
    fn a_clearance_is_below_what_is_required() {
        let clearance = CheckResult {
            check: "planned.clearance".into(),
            value: Some(0.004_069),
            limit: Some(0.005),
            unit: Unit::Meter,
            margin: Some(-0.000_931),
            margin_is_share: false,
            place: Place { subjects: vec!["cube".into(), "wall".into()], phase: Some("lower".into()) },
            basis: Basis::Proved,
            ..jerk()
        };
        assert_eq!(
            sentence(&clearance),
            "cube - wall: clearance 4.07 mm is below 5.00 mm by 0.93 mm at t = 1.529 s (lower)"
        );
    }
}
