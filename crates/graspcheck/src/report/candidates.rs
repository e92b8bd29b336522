//! The ways to do a task that planning looked at, as a table.

use comfy_table::{ContentArrangement, Table, presets};
use graspcheck_model::{
    inverse::Unreachable,
    robot::{JointKind, RobotModel},
    task::Elbow,
};
use graspcheck_planner::{
    branch::BranchFault,
    candidate::{BranchChoice, Candidate, CandidateOutcome},
};
use graspcheck_verify::Unit;

use super::quantity::{Rounding, against, instant, quantity};

/// The candidates in their order: handle, branch, joint positions, how far planning got, what became of them.
/// Unless `every` one is asked for, those that differ in the handle and in the turns of the last joint alone
/// share a row.
#[must_use]
pub(super) fn table(candidates: &[Candidate], robot: &RobotModel, every: bool) -> String {
    let mut rows: Vec<Row> = Vec::new();
    for candidate in candidates {
        let row = Row::new(candidate, robot);
        match rows.iter_mut().find(|other| !every && other.is_like(&row)) {
            Some(other) => other.add(row),
            None => rows.push(row),
        }
    }
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Disabled);
    let joints = robot.joints.iter().map(|joint| joint.name.clone());
    let words = |words: &[&str]| words.iter().map(|&word| word.to_owned()).collect::<Vec<_>>();
    table.add_row(
        words(&["", "ways", "handle", "branch"])
            .into_iter()
            .chain(joints)
            .chain(words(&["stage", "outcome"])),
    );
    let grouped = rows.len() < candidates.len();
    for row in rows {
        table.add_row(row.cells(robot));
    }
    let mut text: String = table.lines().map(|line| format!("{}\n", line.trim_end())).collect();
    if grouped {
        text.push_str("    (-v lists every one)\n");
    }
    text
}

/// The chosen way to do the task in one line, and what became of the others: `side x, half turn, elbow left,
/// wrist turn 0; best of 24: 18 unreachable, 2 refuted, 3 not faster`. None when the task left nothing to
/// choose. When none `is_clear` of collision, the fastest is chosen all the same.
#[must_use]
pub(super) fn choice(candidates: &[Candidate], is_clear: bool) -> Option<String> {
    let chosen = candidates.iter().find(|candidate| candidate.outcome == CandidateOutcome::Chosen)?;
    let mut text = handle(chosen);
    match (&chosen.grasp, &chosen.place) {
        (Some(grasp), Some(place)) if (grasp.elbow, grasp.turn) != (place.elbow, place.turn) => {
            text.push_str(&format!(", grasped {}, placed {}", branch(grasp), branch(place)));
        }
        (Some(way), _) | (None, Some(way)) => text.push_str(&format!(", {}", branch(way))),
        (None, None) => {}
    }
    let count = |is: fn(&CandidateOutcome) -> bool| {
        candidates.iter().filter(|candidate| is(&candidate.outcome)).count()
    };
    let counts = [
        (count(CandidateOutcome::is_unreachable), "unreachable"),
        (count(|outcome| matches!(outcome, CandidateOutcome::TooNear { .. })), "refuted"),
        (count(|outcome| matches!(outcome, CandidateOutcome::Undecided { .. })), "undecided"),
        (count(|outcome| matches!(outcome, CandidateOutcome::Slower { .. })), "not faster"),
    ];
    let others: Vec<String> = counts
        .iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, word)| format!("{count} {word}"))
        .collect();
    let chosen_as = if is_clear { "best" } else { "none is proved clear, the fastest" };
    text.push_str(&format!("; {chosen_as} of {}", candidates.len()));
    if !others.is_empty() {
        text.push_str(&format!(": {}", others.join(", ")));
    }
    Some(text)
}

/// `elbow left, wrist turn 0`.
fn branch(choice: &BranchChoice) -> String {
    format!("{}, wrist turn {}", elbow(choice.elbow), choice.turn)
}

/// Candidates that differ in the handle and in the turns of the last joint alone.
struct Row {
    ways: usize,
    handles: Vec<String>,
    branch: String,
    /// Positions of all joints but the last.
    joints: Vec<String>,
    /// Least and largest position of the last joint, rad or m.
    last: Option<[f64; 2]>,
    stage: String,
    outcome: String,
}

impl Row {
    fn new(candidate: &Candidate, robot: &RobotModel) -> Self {
        let choice = candidate.place.as_ref().or(candidate.grasp.as_ref());
        let positions = robot.joints.iter().enumerate().map(|(k, joint)| {
            choice.map_or_else(|| "–".to_owned(), |choice| position(choice.q[k], joint.kind))
        });
        let last = choice.and_then(|choice| choice.q.last().copied());
        Self {
            ways: 1,
            handles: vec![handle(candidate)],
            branch: choice.map_or("–", |choice| elbow(choice.elbow)).to_owned(),
            joints: positions.take(robot.joints.len().saturating_sub(1)).collect(),
            last: last.map(|last| [last, last]),
            stage: candidate.stage.to_string(),
            outcome: outcome(&candidate.outcome, robot),
        }
    }

    fn is_like(&self, other: &Self) -> bool {
        self.branch == other.branch
            && self.joints == other.joints
            && self.stage == other.stage
            && self.outcome == other.outcome
    }

    fn add(&mut self, other: Self) {
        self.ways += other.ways;
        for handle in other.handles {
            if !self.handles.contains(&handle) {
                self.handles.push(handle);
            }
        }
        self.last = match (self.last, other.last) {
            (Some([a, b]), Some([c, d])) => Some([a.min(c), b.max(d)]),
            (one, other) => one.or(other),
        };
    }

    fn cells(self, robot: &RobotModel) -> Vec<String> {
        let handles = match self.handles.len() {
            0..=2 => self.handles.join("; "),
            more => format!("{more} grips"),
        };
        let last = match (self.last, robot.joints.last()) {
            (Some([least, most]), Some(joint)) if least < most => {
                format!("{} … {}", position(least, joint.kind), position(most, joint.kind))
            }
            (Some([only, _]), Some(joint)) => position(only, joint.kind),
            _ => "–".to_owned(),
        };
        let mut cells = vec![String::new(), self.ways.to_string(), handles, self.branch];
        cells.extend(self.joints);
        cells.extend([last, self.stage, self.outcome]);
        cells
    }
}

/// `side x`, or `side x, half turn`.
fn handle(candidate: &Candidate) -> String {
    let turned = if candidate.half_turn { ", half turn" } else { "" };
    format!("{}{turned}", candidate.handle)
}

fn elbow(elbow: Elbow) -> &'static str {
    match elbow {
        Elbow::Left => "elbow left",
        Elbow::Right => "elbow right",
    }
}

fn position(value: f64, kind: JointKind) -> String {
    quantity(value, Unit::of_derivative(kind, 0), Rounding::Nearest)
}

/// What became of a candidate, in the units for people.
fn outcome(outcome: &CandidateOutcome, robot: &RobotModel) -> String {
    match outcome {
        // Less than what is shown: ways that are mirror images of each other.
        CandidateOutcome::Slower { by } if *by < 5e-4 => "as fast as the chosen one".to_owned(),
        CandidateOutcome::Slower { by } => format!("{} slower than the chosen one", instant(*by)),
        CandidateOutcome::TooNear { a, b, distance, required, time, phase } => {
            let (distance, required) = against(*distance, *required, Unit::Meter, Rounding::Nearest);
            format!("{a} - {b}: {distance} is below {required} at t = {}, {phase}", instant(*time))
        }
        CandidateOutcome::Limit { joint, value, limit, excess } => {
            beyond(joint, *value, *limit, *excess, robot)
        }
        CandidateOutcome::Line { fault: BranchFault::Limit { joint, value, limit, excess, .. }, .. } => {
            beyond(joint, *value, *limit, *excess, robot)
        }
        CandidateOutcome::Line {
            fault: BranchFault::NearSingular { .. } | BranchFault::BranchChange { .. },
            ..
        } => "the arm is nearly straight or folded on the way".to_owned(),
        CandidateOutcome::Line { fault: BranchFault::OtherBranch { joint, value, limit, .. }, .. } => {
            beyond(joint, *value, *limit, (value - limit).abs(), robot)
        }
        CandidateOutcome::Line { at, fault: BranchFault::OutOfReach { .. } } => {
            format!("out of reach from {:.0} % of the way", at * 100.0)
        }
        CandidateOutcome::OutOfReach(Unreachable::TooFar { reach, excess, .. }) => {
            format!("wrist {} beyond {} from the first axis", length(*excess), length(*reach))
        }
        CandidateOutcome::OutOfReach(Unreachable::TooNear { hole, shortfall, .. }) => {
            format!("wrist {} within {} of the first axis", length(*shortfall), length(*hole))
        }
        other => other.to_string(),
    }
}

fn length(value: f64) -> String {
    quantity(value, Unit::Meter, Rounding::Nearest)
}

/// `elbow 8.9° above 120.0°`.
fn beyond(joint: &str, value: f64, limit: f64, excess: f64, robot: &RobotModel) -> String {
    let kind = robot.joints.iter().find(|other| other.name == *joint).map_or(JointKind::Revolute, |j| j.kind);
    let side = if value > limit { "above" } else { "below" };
    format!("{joint} {} {side} {}", position(excess, kind), position(limit, kind))
}
