//! The certificate of clearance against scene and plan, statement by statement.
//!
//! First that steps and sweeps cover every pair from the start to the end, then each step and sweep by itself,
//! in order of time: those of one interval share where everything is.

use std::collections::BTreeMap;

use crate::{
    PairName, Place, Quantity, ROUNDING, Report,
    closest::distance,
    demand::{Demands, is_equal},
    documents::{Certificate, Documents, Leaf, PairProof, Sweep, Verdict, Violation},
    motion::{Motion, SAME_INSTANT, slab},
    policy::{Required, Stage},
    scene::{BodyPair, Scene},
    sweep::Sweeps,
    vector::{UNIT_TOLERANCE, Vector},
};

/// Required distances are derived twice from the same numbers: they differ by rounding only, m.
const SAME_DISTANCE: f64 = 1e-12;

/// A witness point may be this far outside of its solid, m, and another one this far from where it should be.
const WITNESS_SLACK: f64 = 2.0 * ROUNDING;

/// Checks the certificate; what is found goes into the report.
pub(crate) fn check(documents: &Documents, report: &mut Report) {
    let scene = Scene::new(&documents.resolved);
    let stages: Vec<Stage> =
        (0..documents.plan.phases.len()).map(|phase| Stage::of(&scene, documents, phase)).collect();
    let motion = Motion::new(&scene, &documents.plan);
    let mut check = Check { documents, scene: &scene, stages: &stages, motion, report };
    check.whole();
    let sweeps = check.sweeps();
    let mut free = check.pairs(&sweeps);
    check.steps(&sweeps, &mut free);
    check.margins(&free);
}

struct Check<'d> {
    documents: &'d Documents,
    scene: &'d Scene<'d>,
    /// Of each phase.
    stages: &'d [Stage],
    motion: Motion<'d>,
    report: &'d mut Report,
}

/// A pair of solids that must be proved, by their indices.
#[derive(Clone, Copy)]
pub(crate) struct Subject<'d> {
    pub(crate) solids: [usize; 2],
    pub(crate) bodies: &'d BodyPair,
}

/// A pair that is said to be free.
struct Free<'d> {
    subject: Subject<'d>,
    leaves: &'d [Leaf],
    margin: f64,
    /// What its steps leave of the distance beyond the required one, m.
    least: f64,
}

/// One step of a proof.
enum Step<'d> {
    /// Of a pair, by its index among the free ones.
    Leaf(usize, &'d Leaf),
    Sweep(usize, &'d Sweep),
}

impl Step<'_> {
    fn interval(&self) -> [f64; 2] {
        match self {
            Self::Leaf(_, leaf) => [leaf.start, leaf.end],
            Self::Sweep(_, sweep) => [sweep.start, sweep.end],
        }
    }
}

impl<'d> Check<'d> {
    fn whole(&mut self) {
        let Certificate { duration, .. } = &self.documents.certificate;
        let planned = self.documents.plan.duration();
        let mut demands = Demands::default();
        demands.that(is_equal(*duration, planned), Quantity::Duration, *duration, planned);
        self.report(demands, [0.0, planned], || Place::Whole);
    }

    /// The sweeps of each solid; that of one solid they do not overlap.
    fn sweeps(&mut self) -> Sweeps<'d> {
        let (sweeps, misplaced) = Sweeps::of(self.documents, self.scene);
        for (sweep, demands) in misplaced {
            let interval = [sweep.start, sweep.end];
            self.report(demands, interval, || Place::Sweep(sweep.body.clone(), sweep.part));
        }
        sweeps
    }

    /// The pairs that must be proved, in order of their solids.
    fn subjects(&self) -> Vec<Subject<'d>> {
        let scene = self.scene;
        let mut subjects = Vec::new();
        for bodies in &scene.pairs {
            for a in scene.solids_of(bodies.a) {
                subjects.extend(scene.solids_of(bodies.b).map(|b| Subject { solids: [a, b], bodies }));
            }
        }
        subjects.sort_unstable_by_key(|subject| subject.solids);
        subjects
    }

    /// Every pair must be there once, or be proved by sweeps, and no other. Returns those that are said to be
    /// free.
    fn pairs(&mut self, sweeps: &Sweeps<'d>) -> Vec<Free<'d>> {
        let (scene, whole) = (self.scene, [0.0, self.documents.plan.duration()]);
        let Certificate { pair_count, pairs, .. } = &self.documents.certificate;
        let subjects = self.subjects();
        self.report.pairs = subjects.len();
        if let Some(count) = *pair_count {
            let mut demands = Demands::default();
            let is_so = count == subjects.len();
            demands.that(is_so, Quantity::PairCount, count as f64, subjects.len() as f64);
            self.report(demands, whole, || Place::Whole);
        }

        let index: BTreeMap<&str, usize> =
            scene.bodies.iter().enumerate().map(|(index, body)| (body.name, index)).collect();
        let solid = |name: &str, part: usize| scene.solids_of(*index.get(name)?).nth(part);
        let mut proofs = Vec::with_capacity(pairs.len());
        for proof in pairs {
            let PairProof { a, part_a, b, part_b, .. } = proof;
            let solids = solid(a, *part_a).zip(solid(b, *part_b)).map(|(a, b)| [a, b]);
            let subject = |solids| subjects.binary_search_by_key(&solids, |subject| subject.solids).ok();
            if let Some(subject) = solids.and_then(subject) {
                proofs.push((subject, proof));
                continue;
            }
            let mut demands = Demands::default();
            demands.occurs(1, 0);
            let name = || PairName { a: a.clone(), part_a: *part_a, b: b.clone(), part_b: *part_b };
            self.report(demands, whole, || Place::Pair(name()));
        }
        proofs.sort_by_key(|(subject, _)| *subject);

        let mut free = Vec::with_capacity(proofs.len());
        let mut next = 0;
        for (index, &subject) in subjects.iter().enumerate() {
            let count = proofs[next..].iter().take_while(|(of, _)| *of == index).count();
            let mut demands = Demands::default();
            let mut uncovered = whole;
            if count == 0 {
                uncovered[0] = sweeps.cover(scene, self.stages, subject, whole);
                demands.that(uncovered[0] >= whole[1], Quantity::Occurrences, 0.0, 1.0);
            } else {
                demands.occurs(count, 1);
            }
            self.report(demands, uncovered, || subject.place(scene));
            for (_, proof) in &proofs[next..next + count] {
                match &proof.verdict {
                    Verdict::Free { margin } => {
                        self.cover(subject, &proof.leaves, sweeps);
                        let leaves = &proof.leaves;
                        free.push(Free { subject, leaves, margin: *margin, least: f64::INFINITY });
                    }
                    Verdict::Violated(violation) => {
                        self.report.violated.push(subject.name(scene));
                        self.violation(subject, violation);
                    }
                    Verdict::Unknown {} | Verdict::NotChecked {} => {
                        self.report.undecided.push(subject.name(scene));
                    }
                }
            }
            next += count;
        }
        free
    }

    /// The steps must follow each other from 0 to the end; between them sweeps may stand in.
    fn cover(&mut self, subject: Subject<'d>, leaves: &[Leaf], sweeps: &Sweeps<'d>) {
        let scene = self.scene;
        let cover = |from: f64, until: f64| {
            if from < until { sweeps.cover(scene, self.stages, subject, [from, until]) } else { from }
        };
        let duration = self.documents.plan.duration();
        let mut covered = 0.0;
        let mut wrong = Vec::new();
        for Leaf { start, end, .. } in leaves {
            let until = cover(covered, *start);
            let mut demands = Demands::default();
            demands.that(is_equal(*start, until) && start < end, Quantity::Start, *start, until);
            wrong.push(([*start, *end], demands));
            covered = *end;
        }
        let until = cover(covered, duration);
        let mut demands = Demands::default();
        demands.that(is_equal(until, duration), Quantity::End, until, duration);
        wrong.push(([0.0, duration], demands));
        for (interval, demands) in wrong {
            self.report(demands, interval, || subject.place(scene));
        }
    }

    /// Every step by itself, those of one interval together.
    fn steps(&mut self, sweeps: &Sweeps<'d>, free: &mut [Free<'d>]) {
        let mut steps: Vec<Step> = sweeps.all().map(|(solid, sweep)| Step::Sweep(solid, sweep)).collect();
        self.report.sweeps = steps.len();
        for (index, free) in free.iter().enumerate() {
            steps.extend(free.leaves.iter().map(|leaf| Step::Leaf(index, leaf)));
        }
        self.report.leaves = steps.len();
        steps.sort_unstable_by(|x, y| {
            let ([start, end], [other_start, other_end]) = (x.interval(), y.interval());
            start.total_cmp(&other_start).then(end.total_cmp(&other_end))
        });
        let bits = |step: &Step| step.interval().map(f64::to_bits);
        for group in steps.chunk_by(|x, y| bits(x) == bits(y)) {
            let interval = group[0].interval();
            let plan = &self.documents.plan;
            let (phase, within) = plan.phase(interval);
            let stage = &self.stages[phase];
            self.motion.set(interval, stage.least_opening);
            for step in group {
                match step {
                    Step::Leaf(index, leaf) => {
                        let proved = self.leaf(free[*index].subject, leaf, stage, within);
                        free[*index].least = free[*index].least.min(proved);
                    }
                    Step::Sweep(solid, sweep) => self.sweep(*solid, sweep, stage, within),
                }
            }
        }
    }

    /// One step, in the stage of its middle, which lasts from when to when; how much is left there of the
    /// required distance, m.
    fn leaf(&mut self, subject: Subject, leaf: &Leaf, stage: &Stage, [from, until]: [f64; 2]) -> f64 {
        let scene = self.scene;
        let mut demands = Demands::default();
        demands.that(leaf.start >= from - SAME_INSTANT, Quantity::Phase, leaf.start, from);
        demands.that(leaf.end <= until + SAME_INSTANT, Quantity::Phase, leaf.end, until);
        let required = stage.required(scene, subject.bodies);
        demands.that(is_same(leaf.required, required), Quantity::Required, leaf.required, required.least);
        let length = leaf.normal.length();
        demands.that((length - 1.0).abs() <= UNIT_TOLERANCE, Quantity::Normal, length, 1.0);

        let [a, b] = subject.solids.map(|solid| self.motion.place(stage, solid));
        let is_near = a.is_near() && b.is_near() && self.motion.is_near();
        let gap = slab(&a, &b, leaf.normal) - ROUNDING;
        demands.that(leaf.gap <= gap, Quantity::Gap, leaf.gap, gap);
        let loss = self.motion.loss(subject.solids, leaf.normal, leaf.loss);
        demands.that(leaf.loss >= loss - ROUNDING, Quantity::Loss, leaf.loss, loss);
        let stated = leaf.gap - leaf.loss;
        demands.that(stated >= leaf.required, Quantity::Clearance, stated, leaf.required);
        let proved = gap - loss;
        demands.that(proved >= required.most && is_near, Quantity::Clearance, stated, proved);
        self.report(demands, [leaf.start, leaf.end], || subject.place(scene));
        proved - required.least
    }

    /// One sweep: all of the solid stays in its box.
    fn sweep(&mut self, solid: usize, sweep: &Sweep, stage: &Stage, [from, until]: [f64; 2]) {
        let mut demands = Demands::default();
        demands.that(sweep.start >= from - SAME_INSTANT, Quantity::Phase, sweep.start, from);
        demands.that(sweep.end <= until + SAME_INSTANT, Quantity::Phase, sweep.end, until);
        let placed = self.motion.place(stage, solid);
        let is_near = placed.is_near() && self.motion.is_near();
        let [low, high] = placed.bounds();
        for axis in 0..3 {
            for (sign, bound, side) in [(-1.0, low.0[axis], sweep.min), (1.0, high.0[axis], sweep.max)] {
                let (bound, side) = (sign * bound, sign * side.0[axis]);
                let n = Vector::unit(axis) * sign;
                let farthest = bound + self.motion.advance(solid, 0, n, side - bound);
                let holds = side >= farthest - ROUNDING && is_near;
                demands.that(holds, Quantity::Box, sign * side, sign * farthest);
            }
        }
        let place = || Place::Sweep(sweep.body.clone(), sweep.part);
        self.report(demands, [sweep.start, sweep.end], place);
    }

    /// No pair keeps more than its steps show.
    fn margins(&mut self, free: &[Free<'d>]) {
        let (scene, duration) = (self.scene, self.documents.plan.duration());
        for Free { subject, margin, least, .. } in free {
            let mut demands = Demands::default();
            demands.that(margin <= least, Quantity::Margin, *margin, *least);
            self.report(demands, [0.0, duration], || subject.place(scene));
        }
    }

    /// The pair must be shown to be nearer than required at some instant.
    fn violation(&mut self, subject: Subject<'d>, violation: &Violation) {
        let Violation { time, phase: phase_name, distance: stated, required: stated_required, points } =
            violation;
        let instant = [*time; 2];
        let mut demands = Demands::default();
        let plan = &self.documents.plan;
        let (phase, [from, _]) = plan.phase(instant);
        let is_there = (0.0..=plan.duration()).contains(time) && plan.phases[phase].name == *phase_name;
        demands.that(is_there, Quantity::Phase, *time, from);
        let (scene, stage) = (self.scene, &self.stages[phase]);
        let required = stage.required(scene, subject.bodies);
        let is_required = is_same(*stated_required, required);
        demands.that(is_required, Quantity::Required, *stated_required, required.least);

        self.motion.set(instant, stage.least_opening);
        let [a, b] = subject.solids.map(|solid| self.motion.place(stage, solid));
        let is_near = a.is_near() && b.is_near() && self.motion.is_near();
        let depth = |point: Vector| [a.depth(point), b.depth(point)];
        for depth in [depth(points[0])[0], depth(points[1])[1]] {
            demands.that(depth >= -WITNESS_SLACK, Quantity::Witness, 0.0, depth);
        }
        // A ball of radius r about a point of both solids that stays in one of them, and one of s that stays
        // in the other, show that they overlap by r + s.
        let middle = (points[0] + points[1]) * 0.5;
        let overlaps = [points[0], points[1], middle].map(depth);
        let overlaps = overlaps.iter().filter(|depth| depth.iter().all(|d| *d >= -WITNESS_SLACK));
        let apart = (points[1] - points[0]).length().min(distance(&a, &b)[1]);
        let shown = overlaps.map(|[a, b]| -a - b).fold(apart, f64::min);
        let is_shown = shown <= stated + WITNESS_SLACK && is_near;
        demands.that(is_shown, Quantity::WitnessDistance, *stated, shown);
        // What is stated may be rounded to the required distance; what is shown must be below it.
        let is_nearer = *stated <= required.least && shown < required.least;
        demands.that(is_nearer, Quantity::Violation, *stated, required.least);
        self.report(demands, instant, || subject.place(scene));
    }

    fn report(&mut self, demands: Demands, interval: [f64; 2], place: impl Fn() -> Place) {
        demands.report(&mut self.report.findings, interval, place);
    }
}

impl Subject<'_> {
    fn name(&self, scene: &Scene) -> PairName {
        let [(a, part_a), (b, part_b)] = self.solids.map(|solid| {
            let body = &scene.bodies[scene.solids[solid].body];
            (body.name.to_owned(), solid - body.first_solid)
        });
        PairName { a, part_a, b, part_b }
    }

    fn place(&self, scene: &Scene) -> Place {
        Place::Pair(self.name(scene))
    }
}

fn is_same(stated: f64, required: Required) -> bool {
    (required.least - SAME_DISTANCE..=required.most + SAME_DISTANCE).contains(&stated)
}
