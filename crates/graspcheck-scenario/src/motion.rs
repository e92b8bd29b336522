//! How fast the arm moves and how hard the gripper holds: `[motion]` and `[phase.NAME]`.

use graspcheck_model::task::{Interpolation, Pace, PhasePace, SetPoints, Sync, TimeLaw};

use crate::{
    fault::{Fault, Place},
    quantity::Quantity,
    section::{Bound, Section},
};

/// Share of the velocity, acceleration and jerk limits when the scenario does not say.
pub const SHARE_DEFAULT: f64 = 0.9;

/// How long the fingers are given to close or to open when the scenario does not say, s.
pub const GRIP_DURATION_DEFAULT: f64 = 0.3;

/// The laws of time of a joint move, as the scenario names them.
const LAWS: [(&str, TimeLaw); 4] = [
    ("s_curve", TimeLaw::SCurve),
    ("quintic", TimeLaw::Quintic),
    ("cubic", TimeLaw::Cubic),
    ("trapezoid", TimeLaw::Trapezoid),
];

/// What the joints of a joint move have in common, as the scenario names it.
const SYNCS: [(&str, Sync); 2] = [("straight", Sync::Straight), ("end_times", Sync::EndTimes)];

/// How a controller interpolates, as the scenario names it.
const INTERPOLATIONS: [(&str, Interpolation); 3] =
    [("linear", Interpolation::Linear), ("cubic", Interpolation::Cubic), ("quintic", Interpolation::Quintic)];

/// `[motion]`: what holds for all phases that do not say otherwise.
pub(crate) struct Motion {
    share: Option<f64>,
    law: Option<TimeLaw>,
    sync: Option<Sync>,
    /// The inner option is none when the controller follows the plan's own polynomials.
    set_points: Option<Option<SetPoints>>,
}

/// The grip in the phases `close` and `open`.
pub(crate) struct GripPace {
    /// Force of each finger, N.
    pub(crate) force: f64,
    /// Where it stands.
    pub(crate) force_at: Place,
    /// How long the fingers are given to close, s.
    pub(crate) close: f64,
    /// How long the fingers are given to open, s.
    pub(crate) open: f64,
    /// Where these durations stand, if the scenario gives them.
    pub(crate) durations_at: [Option<Place>; 2],
}

/// `[phase.NAME]` of a phase in which the arm moves, with the place of its name.
pub(crate) struct PlacedPace<'a> {
    pub(crate) pace: PhasePace,
    pub(crate) at: &'a Place,
}

/// All of `[phase]`.
pub(crate) struct Phases<'a> {
    pub(crate) arm: Vec<PlacedPace<'a>>,
    /// The grip; none when the scenario gives no force.
    pub(crate) grip: Option<GripPace>,
    /// Which of `[phase.close]` and `[phase.open]` stand there, and where.
    pub(crate) grip_at: Vec<(&'a str, &'a Place)>,
    /// Whether the scenario gives a force, be it one that cannot be read.
    pub(crate) mentions_force: bool,
    /// Whether all of it could be read.
    complete: bool,
}

/// Reads `[motion]`: the share of the limits, and how joint moves go.
pub(crate) fn motion(scenario: &Section<'_>) -> Motion {
    let (law, sync) = (Some(TimeLaw::default()), Some(Sync::default()));
    let Some(motion) = scenario.section("motion", "a motion") else {
        return Motion { share: Some(SHARE_DEFAULT), law, sync, set_points: Some(None) };
    };
    let share = motion.measure_or("speed", Quantity::Share, Bound::UpToOne, SHARE_DEFAULT);
    let set_points = match motion.section("set_points", "set points") {
        Some(section) => set_points(section).map(Some),
        None => (!motion.has("set_points")).then_some(None),
    };
    let read = Motion {
        share,
        law: motion.word("law", &LAWS, law),
        sync: motion.word("sync", &SYNCS, sync),
        set_points,
    };
    motion.finish();
    read
}

/// Reads `[motion.set_points]`.
fn set_points(section: Section<'_>) -> Option<SetPoints> {
    let rate = section.required_measure("rate", Quantity::Frequency, Bound::Positive);
    let interpolation = section.word("interpolation", &INTERPOLATIONS, None);
    section.finish();
    Some(SetPoints { period: 1.0 / rate?, interpolation: interpolation? })
}

/// A word that a phase need not say; the flag falls when it cannot be read.
fn own_word<T: Copy>(phase: &Section<'_>, key: &str, words: &[(&str, T)], complete: &mut bool) -> Option<T> {
    if !phase.has(key) {
        // Asked for, so that it is among the keys that are known.
        phase.ask(key);
        return None;
    }
    let word = phase.word(key, words, None);
    *complete &= word.is_some();
    word
}

/// Reads `[phase.NAME]`. The names are known also where a value cannot be read.
pub(crate) fn phases<'a>(scenario: &Section<'a>) -> Phases<'a> {
    let mut arm = Vec::new();
    let mut complete = true;
    let (mut force, mut grip_at) = (None, Vec::new());
    let (mut close, mut open) = (GRIP_DURATION_DEFAULT, GRIP_DURATION_DEFAULT);
    let mut durations_at = [None, None];
    let mut mentions_force = false;
    if let Some(section) = scenario.section("phase", "the phases") {
        for (name, at, phase) in section.named_sections("a phase") {
            let duration = phase.measure("duration", Quantity::Time, Bound::Positive);
            complete &= duration.is_some() || !phase.mentions("duration");
            match name {
                "close" | "open" => {
                    grip_at.push((name, at));
                    if let Some(duration) = duration {
                        *(if name == "close" { &mut close } else { &mut open }) = duration;
                        let at = phase.place_of("duration", Quantity::Time).cloned();
                        durations_at[usize::from(name == "open")] = at;
                    }
                    if name == "close" {
                        mentions_force = phase.mentions("force");
                        let read = phase.measure_at("force", Quantity::Force, Bound::Positive);
                        force = read.map(|(value, place)| (value, place.clone()));
                    }
                }
                _ => {
                    let share = phase.measure("speed", Quantity::Share, Bound::UpToOne);
                    complete &= share.is_some() || !phase.mentions("speed");
                    both(&phase, at);
                    let law = own_word(&phase, "law", &LAWS, &mut complete);
                    let sync = own_word(&phase, "sync", &SYNCS, &mut complete);
                    let pace = PhasePace { phase: name.to_owned(), share, duration, law, sync };
                    arm.push(PlacedPace { pace, at });
                }
            }
            phase.finish();
        }
        section.finish();
    }
    complete &= force.is_some() || !mentions_force;
    let grip = force.map(|(force, force_at)| GripPace { force, force_at, close, open, durations_at });
    Phases { arm, grip, grip_at, mentions_force, complete }
}

/// A phase has a share or a duration, not both: each fixes the other.
fn both(phase: &Section<'_>, at: &Place) {
    if phase.mentions("speed") && phase.mentions("duration") {
        let title = "a phase has a speed or a duration, not both";
        phase.faults().report(Fault::new("two-units", at, title, "remove one of them"));
    }
}

/// The pace of a task; none where it could not be read.
pub(crate) fn pace(motion: &Motion, phases: &Phases<'_>) -> Option<Pace> {
    let share = motion.share.filter(|_| phases.complete)?;
    let phases = phases.arm.iter().map(|phase| phase.pace.clone()).collect();
    Some(Pace { share, law: motion.law?, sync: motion.sync?, phases, set_points: motion.set_points? })
}
