//! The least margin of a plan, between certified bounds: best-first branch and bound over pairs and time.
//!
//! For a pair on an interval, `gap - loss - required` at the middle bounds the margin from below, witness
//! points at the middle from above. The interval with the lowest bound is halved until the lowest bound is
//! within the tolerance of the least witness.

use std::{cmp::Ordering, collections::BinaryHeap};

use graspcheck_model::plan::Plan;
use nalgebra::Vector3;

use crate::{
    certify::SHORTEST_INTERVAL,
    contact::{Requirement, Stages},
    displacement::Moment,
    gap::{first_normal, gap, overlap_of_at_least, separation},
    scene::Scene,
    solid::Placed,
    stretch::{Stretch, middle, stretches},
};

/// How near the bounds of the least margin are brought to each other, m, when nothing else is asked for.
pub const MARGIN_TOLERANCE: f64 = 1e-5;

/// How many pairs and intervals are looked at before the bounds are given as they are: a distance that
/// stays the same over a long motion needs many, and then this ends in some 50 ms.
pub const MOST_EVALUATIONS: usize = 30_000;

/// How many ordinary evaluations one search for the depth of an overlap counts as.
const OVERLAP_COST: usize = 10;

/// Certified bounds of the least margin, and where it is met.
#[derive(Clone, Debug, PartialEq)]
pub struct MarginBounds {
    /// At no instant does a judged pair have less margin, m: distance less the required distance.
    pub lower: f64,
    /// At `time` the pair `a`, `b` has at most this margin, m.
    pub upper: f64,
    /// When, s.
    pub time: f64,
    /// Name of one body.
    pub a: String,
    /// Name of the other.
    pub b: String,
    /// What is required of them then, m.
    pub required: f64,
    /// Name of the phase.
    pub phase: String,
    /// A point of each in the world, m; as far apart as `upper + required` says, while they are apart.
    pub points: [[f64; 3]; 2],
}

/// A pair on an interval, ordered so that the lowest bound is taken first.
struct Candidate {
    lower: f64,
    pair: usize,
    stretch: usize,
    start: f64,
    end: f64,
    normal: Vector3<f64>,
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        // Ties are broken by place, so that the search takes the same way everywhere.
        let place = |c: &Self| (c.pair, c.stretch);
        other
            .lower
            .total_cmp(&self.lower)
            .then_with(|| place(other).cmp(&place(self)))
            .then_with(|| other.start.total_cmp(&self.start))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}

/// The state of the search.
struct Search<'s> {
    scene: &'s Scene,
    moment: Moment<'s>,
    tolerance: f64,
    evaluations: usize,
    heap: BinaryHeap<Candidate>,
    best: Option<Witness>,
    /// The least bound of what needs no further look.
    settled: f64,
}

impl Search<'_> {
    /// Bounds the margin of a pair on an interval, at the middle of which the moment stands. None when the
    /// distance cannot be computed.
    fn look(&mut self, at: &Candidate, stretch: &Stretch, requirement: &Requirement) -> Option<()> {
        self.evaluations += 1;
        let pair = self.scene.pairs[at.pair];
        let [a, b] = self.moment.placed(pair);
        let enough = self.best.as_ref().map_or(f64::INFINITY, |best| best.upper) - self.tolerance;
        let known_normal = at.normal != Vector3::zeros();
        let hint = if known_normal { at.normal } else { first_normal(&a, &b) };
        let by_hint = gap(&a, &b, &hint) - self.moment.loss(pair, requirement, &hint) - requirement.required;
        if by_hint.max(at.lower) >= enough {
            self.settled = self.settled.min(by_hint.max(at.lower));
            return Some(());
        }
        let known = separation(&a, &b, Some(&hint), 0.25 * self.tolerance)?;
        let loss = self.moment.loss(pair, requirement, &known.normal);
        let lower = (known.lower - loss - requirement.required).max(by_hint).max(at.lower);
        let (mut upper, mut points) = (known.upper, known.points);
        let overlap_counts = known.lower - requirement.required < enough + self.tolerance;
        if known.upper <= 0.0 && known.upper - known.lower > self.tolerance && overlap_counts {
            self.evaluations += OVERLAP_COST;
            let shown = deepest_overlap(&a, &b, -known.lower, 0.25 * self.tolerance);
            if let Some((depth, common)) = shown.filter(|(depth, _)| -depth < upper) {
                (upper, points) = (-depth, [common; 2]);
            }
        }
        let upper = upper - requirement.required;
        if self.best.as_ref().is_none_or(|best| upper < best.upper) {
            let time = middle(at.start, at.end);
            let (phase, required) = (stretch.phase, requirement.required);
            self.best = Some(Witness { upper, time, pair: at.pair, phase, required, points });
        }
        self.heap.push(Candidate { lower, normal: known.normal, ..*at });
        Some(())
    }
}

/// The deepest overlap that can be shown, at most `most` (m) and found to `tolerance` (m), and a common
/// point; by bisection.
fn deepest_overlap(a: &Placed, b: &Placed, most: f64, tolerance: f64) -> Option<(f64, Vector3<f64>)> {
    let (mut shown, mut not_shown, mut found) = (0.0, most, None);
    let mut depth = most - tolerance;
    while not_shown - shown > tolerance && depth > 0.0 {
        match overlap_of_at_least(a, b, depth) {
            Some(point) => {
                shown = depth;
                found = Some((depth, point));
            }
            None => not_shown = depth,
        }
        depth = 0.5 * (shown + not_shown);
    }
    found
}

/// The least witness so far.
struct Witness {
    upper: f64,
    time: f64,
    pair: usize,
    phase: usize,
    required: f64,
    points: [Vector3<f64>; 2],
}

impl Scene {
    /// The least margin (signed distance less the required one) over all instants of a plan and all pairs
    /// that may not touch, between bounds that differ by at most `tolerance` (m). Pairs of which both stand
    /// still in the world do not count.
    ///
    /// The bounds differ by more when the search takes too long, see [`MOST_EVALUATIONS`], and where bodies
    /// overlap in a way of which the depth has no closed form. None when no pair counts, or the plan or a
    /// distance could not be judged; [`Scene::certify`] says why.
    #[must_use]
    pub fn minimum_margin(&self, plan: &Plan, tolerance: f64) -> Option<MarginBounds> {
        let stretches = stretches(plan, self.robot.dof()).ok()?;
        let stages = Stages::new(self, plan).ok()?;
        let first = stages.of(stretches.first()?.phase);
        let mut search = Search {
            scene: self,
            moment: Moment::new(self, first),
            tolerance,
            evaluations: 0,
            heap: BinaryHeap::new(),
            best: None,
            settled: f64::INFINITY,
        };
        for (index, stretch) in stretches.iter().enumerate() {
            let stage = stages.of(stretch.phase);
            search.moment.set(stage, stretch, stretch.start, stretch.end);
            for (pair, requirement) in stage.requirements.iter().enumerate() {
                if requirement.contact.is_none() && !requirement.fixed {
                    let root = Candidate {
                        lower: f64::NEG_INFINITY,
                        pair,
                        stretch: index,
                        start: stretch.start,
                        end: stretch.end,
                        normal: Vector3::zeros(),
                    };
                    search.look(&root, stretch, requirement)?;
                }
            }
        }
        while let Some(candidate) = search.heap.pop() {
            let upper = search.best.as_ref()?.upper;
            let enough = candidate.lower >= upper - tolerance;
            if enough || search.evaluations > MOST_EVALUATIONS {
                search.settled = search.settled.min(candidate.lower);
                break;
            }
            if candidate.end - candidate.start < SHORTEST_INTERVAL {
                search.settled = search.settled.min(candidate.lower);
                continue;
            }
            let half = middle(candidate.start, candidate.end);
            let stretch = &stretches[candidate.stretch];
            let stage = stages.of(stretch.phase);
            for (start, end) in [(candidate.start, half), (half, candidate.end)] {
                search.moment.set(stage, stretch, start, end);
                let child = Candidate { start, end, ..candidate };
                search.look(&child, stretch, &stage.requirements[candidate.pair])?;
            }
        }
        let best = search.best?;
        let bodies = &self.body_pairs[self.pairs[best.pair].bodies];
        Some(MarginBounds {
            lower: search.settled.min(best.upper),
            upper: best.upper,
            time: best.time,
            a: self.bodies[bodies.a].name.clone(),
            b: self.bodies[bodies.b].name.clone(),
            required: best.required,
            phase: plan.phases[best.phase].name.clone(),
            points: best.points.map(Into::into),
        })
    }
}
