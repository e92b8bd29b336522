//! The ways to do a task that planning looked at, as a document in the log.
//!
//! It says why the motion is the one that was executed. Nothing is judged by it.

use graspcheck_model::task::Elbow;
use graspcheck_planner::{Candidate, CandidateOutcome, candidate::BranchChoice};
use graspcheck_recording::Attachment;
use serde::Serialize;

/// Name of the document.
pub const CANDIDATES_JSON: &str = "candidates.json";

/// Version of its form.
const SCHEMA: u32 = 1;

#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    /// The chosen one, those that can be reached from the fastest to the slowest, those that cannot.
    candidates: Vec<Way<'a>>,
}

#[derive(Serialize)]
struct Way<'a> {
    handle: &'a str,
    half_turn: bool,
    grasp: Option<Branch<'a>>,
    place: Option<Branch<'a>>,
    /// How far planning got.
    stage: String,
    /// Time that the arm moves, s.
    moving: Option<f64>,
    outcome: &'static str,
    /// In words, SI.
    because: String,
}

#[derive(Serialize)]
struct Branch<'a> {
    elbow: Elbow,
    /// Whole turns of the last joint away from (−π, π].
    turn: i32,
    /// Joint positions, rad or m.
    q: &'a [f64],
}

impl<'a> From<&'a BranchChoice> for Branch<'a> {
    fn from(choice: &'a BranchChoice) -> Self {
        Self { elbow: choice.elbow, turn: choice.turn, q: &choice.q }
    }
}

impl<'a> From<&'a Candidate> for Way<'a> {
    fn from(candidate: &'a Candidate) -> Self {
        let outcome = match &candidate.outcome {
            CandidateOutcome::Chosen => "chosen",
            CandidateOutcome::Slower { .. } => "not_faster",
            CandidateOutcome::TooNear { .. } => "refuted",
            CandidateOutcome::Undecided { .. } => "undecided",
            _ => "unreachable",
        };
        Self {
            handle: &candidate.handle,
            half_turn: candidate.half_turn,
            grasp: candidate.grasp.as_ref().map(Branch::from),
            place: candidate.place.as_ref().map(Branch::from),
            stage: candidate.stage.to_string(),
            moving: candidate.moving,
            outcome,
            because: candidate.outcome.to_string(),
        }
    }
}

/// The document [`CANDIDATES_JSON`]; none when there was nothing to choose.
pub(crate) fn document(candidates: &[Candidate]) -> Option<Attachment> {
    if candidates.is_empty() {
        return None;
    }
    let document = Document { schema: SCHEMA, candidates: candidates.iter().map(Way::from).collect() };
    let data = serde_json::to_vec_pretty(&document).expect("a tree of structs and numbers has a JSON form");
    Some(Attachment { name: CANDIDATES_JSON.to_owned(), media_type: "application/json".to_owned(), data })
}
