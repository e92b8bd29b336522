//! The least margin of a plan, between certified bounds: best-first branch and bound over pairs and time.
//!
//! For a pair on an interval, `gap - loss - required` at the middle bounds the margin from below, witness
//! points at the middle from above. The interval with the lowest bound is halved until the lowest bound is
//! within the tolerance of the least witness. In a cell of many bodies a solid of the robot or the object
//! stands for all its pairs with the cell at first: the box of its sweep bounds their margin, and only the
//! bodies that are near enough to it to matter become pairs.

use std::{cmp::Ordering, collections::BinaryHeap};

use graspcheck_model::plan::Plan;
use nalgebra::Vector3;

use crate::{
    bounds::Bounds,
    certify::{FEW_NEAR, SHORTEST_INTERVAL, is_wide},
    contact::{Stage, Stages},
    displacement::Moment,
    gap::{first_normal, gap, overlap_of_at_least, separation},
    scene::Scene,
    solid::{LARGEST_COORDINATE, Placed},
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

/// When motion can take more than this many times what the normal at hand leaves over, another normal would
/// not make the interval much shorter on which the pair is settled.
const HOPELESS: f64 = 2.0;

/// The first distance, m, in which something is looked for that is near to a solid. It grows by
/// [`REACH_GROWTH`] until there is something.
const FIRST_REACH: f64 = 0.05;
const REACH_GROWTH: f64 = 4.0;

/// What has a margin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Subject {
    /// A solid of the robot or the object against all of the cell, by its index.
    Part(usize),
    /// A pair, by its index.
    Pair(usize),
}

/// A subject on an interval, ordered so that the lowest bound is taken first.
#[derive(Clone, Copy)]
struct Candidate {
    lower: f64,
    subject: Subject,
    stretch: usize,
    start: f64,
    end: f64,
    /// What separated a pair last, or zero.
    normal: Vector3<f64>,
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        // Ties are broken by place, so that the search takes the same way everywhere.
        let place = |c: &Self| (c.subject, c.stretch);
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
    /// Pairs that are near to a sweep, and how much farther apart than required the boxes are.
    near: Vec<(usize, f64)>,
}

impl<'s> Search<'s> {
    /// The margin that no witness undercuts so far, m.
    fn upper(&self) -> f64 {
        self.best.as_ref().map_or(f64::INFINITY, |best| best.upper)
    }

    fn settle(&mut self, lower: f64) {
        self.settled = self.settled.min(lower);
    }

    /// Bounds the margin of a subject on an interval, at the middle of which the moment stands. None when a
    /// distance cannot be computed.
    fn look(&mut self, at: &Candidate, stretch: &Stretch, stage: &'s Stage) -> Option<()> {
        match at.subject {
            Subject::Part(part) => self.look_at_part(part, at, stretch, stage),
            Subject::Pair(pair) => self.look_at_pair(pair, at, stretch, stage),
        }
    }

    fn look_at_part(
        &mut self,
        part: usize,
        at: &Candidate,
        stretch: &Stretch,
        stage: &'s Stage,
    ) -> Option<()> {
        self.evaluations += 1;
        if self.best.is_none() {
            self.look_at_nearest(part, at, stretch, stage)?;
        }
        // What is farther than the least witness does not matter.
        let Some(best) = &self.best else { return Some(()) };
        let more = (best.upper - self.tolerance).max(0.0);
        let sweep = self.moment.sweep(part);
        let mut near = std::mem::take(&mut self.near);
        self.find_near(part, stage, &sweep, more, &mut near);
        let long = at.end - at.start > SHORTEST_INTERVAL;
        if near.len() > FEW_NEAR && long && is_wide(&mut self.moment, part, &sweep) {
            let lower = near.iter().map(|(_, room)| *room).fold(more, f64::min);
            self.heap.push(Candidate { lower: lower.max(at.lower), ..*at });
        } else {
            self.settle(more);
            for &(pair, room) in &near {
                let lower = room.max(at.lower);
                self.look_at_pair(
                    pair,
                    &Candidate { lower, subject: Subject::Pair(pair), ..*at },
                    stretch,
                    stage,
                )?;
            }
        }
        self.near = near;
        Some(())
    }

    /// Looks at the pair of a solid with what is nearest to it at the middle of an interval, as a witness to
    /// begin with; at none if nothing is there.
    fn look_at_nearest(
        &mut self,
        part: usize,
        at: &Candidate,
        stretch: &Stretch,
        stage: &'s Stage,
    ) -> Option<()> {
        let bounds = Bounds::of(&self.moment.place(part));
        let mut near = std::mem::take(&mut self.near);
        let mut reach = FIRST_REACH;
        near.clear();
        while near.is_empty() && reach < 4.0 * LARGEST_COORDINATE {
            self.find_near(part, stage, &bounds, reach, &mut near);
            reach *= REACH_GROWTH;
        }
        let nearest = near.iter().min_by(|(_, a), (_, b)| a.total_cmp(b)).copied();
        self.near = near;
        let Some((pair, _)) = nearest else { return Some(()) };
        self.look_at_pair(pair, &Candidate { subject: Subject::Pair(pair), ..*at }, stretch, stage)
    }

    /// The pairs of a solid that count and are near to a box around it.
    fn find_near(&self, part: usize, stage: &Stage, sweep: &Bounds, more: f64, near: &mut Vec<(usize, f64)>) {
        near.clear();
        self.scene.near_to_sweep(stage, part, sweep, more, |pair, room| {
            if stage.requirement(self.scene, &self.scene.pairs[pair]).counts() {
                near.push((pair, room));
            }
        });
    }

    fn look_at_pair(
        &mut self,
        index: usize,
        at: &Candidate,
        stretch: &Stretch,
        stage: &'s Stage,
    ) -> Option<()> {
        let pair = self.scene.pairs[index];
        let requirement = stage.requirement(self.scene, &pair);
        if !requirement.counts() {
            return Some(());
        }
        self.evaluations += 1;
        let [a, b] = self.moment.placed(pair);
        let enough = self.upper() - self.tolerance;
        let hint = if at.normal == Vector3::zeros() { first_normal(&a, &b) } else { at.normal };
        let now = gap(&a, &b, &hint) - requirement.required;
        let loss = self.moment.loss(pair, requirement.first_joint, &hint, now - enough);
        let by_hint = (now - loss).max(at.lower);
        if by_hint >= enough {
            self.settle(by_hint);
            return Some(());
        }
        // At this instant the pair is no witness, and on half of the interval the normal will do better.
        if now >= self.upper() && loss > HOPELESS * (now - enough) {
            self.heap.push(Candidate { lower: by_hint, normal: hint, ..*at });
            return Some(());
        }
        let known = separation(&a, &b, Some(&hint), 0.25 * self.tolerance)?;
        let now = known.lower - requirement.required;
        let loss = self.moment.loss(pair, requirement.first_joint, &known.normal, now - enough);
        let lower = (now - loss).max(by_hint);
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
        if upper < self.upper() {
            let time = middle(at.start, at.end);
            let (phase, required) = (stretch.phase, requirement.required);
            self.best = Some(Witness { upper, time, pair: index, phase, required, points });
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
            near: Vec::new(),
        };
        for (index, stretch) in stretches.iter().enumerate() {
            let stage = stages.of(stretch.phase);
            search.moment.set(stage, stretch, stretch.start, stretch.end);
            let mut look = |subject| {
                let root = Candidate {
                    lower: f64::NEG_INFINITY,
                    subject,
                    stretch: index,
                    start: stretch.start,
                    end: stretch.end,
                    normal: Vector3::zeros(),
                };
                search.look(&root, stretch, stage)
            };
            if self.has_sweeps() {
                self.pairs_without_cell.iter().try_for_each(|&pair| look(Subject::Pair(pair)))?;
                (0..self.first_cell_part).try_for_each(|part| look(Subject::Part(part)))?;
            } else {
                (0..self.pairs.len()).try_for_each(|pair| look(Subject::Pair(pair)))?;
            }
        }
        while let Some(candidate) = search.heap.pop() {
            let enough = candidate.lower >= search.upper() - tolerance;
            if enough || search.evaluations > MOST_EVALUATIONS {
                search.settle(candidate.lower);
                break;
            }
            if candidate.end - candidate.start < SHORTEST_INTERVAL {
                search.settle(candidate.lower);
                continue;
            }
            let half = middle(candidate.start, candidate.end);
            let stretch = &stretches[candidate.stretch];
            let stage = stages.of(stretch.phase);
            for (start, end) in [(candidate.start, half), (half, candidate.end)] {
                search.moment.set(stage, stretch, start, end);
                search.look(&Candidate { start, end, ..candidate }, stretch, stage)?;
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
