//! The certificate against the scene and the plan, statement by statement.

use std::collections::BTreeMap;

use crate::{
    Finding, LARGEST, PairName, Quantity, ROUNDING, Report,
    closest::distance,
    documents::{Certificate, Documents, Leaf, PairProof, Verdict, Violation},
    motion::{Motion, SAME_INSTANT, slab},
    policy::{Required, Stage},
    scene::{BodyPair, Mount, Scene},
    solid::Placed,
    vector::{UNIT_TOLERANCE, Vector},
};

/// Required distances are derived twice from the same numbers: they differ by rounding only, m.
const SAME_DISTANCE: f64 = 1e-12;

/// A witness point may be this far outside of its solid, m, and another one this far from where it should be.
const WITNESS_SLACK: f64 = 2.0 * ROUNDING;

pub(crate) fn certificate(documents: &Documents) -> Report {
    let scene = Scene::new(&documents.resolved);
    let stages = (0..documents.plan.phases.len()).map(|phase| Stage::of(&scene, documents, phase)).collect();
    let mut check =
        Check { documents, scene: &scene, stages, motions: BTreeMap::new(), report: Report::default() };
    check.pairs();
    check.report
}

struct Check<'d> {
    documents: &'d Documents,
    scene: &'d Scene<'d>,
    /// Of each phase.
    stages: Vec<Stage>,
    /// Many pairs have steps on the same intervals; the key is the bits of both times.
    motions: BTreeMap<[u64; 2], Motion>,
    report: Report,
}

/// A pair of solids that must be proved.
struct Subject<'d> {
    name: PairName,
    bodies: &'d BodyPair,
}

/// The solids of a pair at the middle of an interval.
struct View<'d> {
    solids: [Placed<'d>; 2],
    mounts: [Mount; 2],
    /// Whether all numbers are so small that rounding is.
    is_near: bool,
}

impl<'d> Check<'d> {
    /// Every pair of the scene must be there once, and no other.
    fn pairs(&mut self) {
        let Certificate { duration, pairs, .. } = &self.documents.certificate;
        let planned = self.documents.plan.duration();
        let whole = [0.0, planned];
        let mut demands = Demands::default();
        demands.that(is_equal(*duration, planned), Quantity::Duration, *duration, planned);
        self.report(None, whole, demands);
        let mut proofs: BTreeMap<PairName, Vec<&PairProof>> = BTreeMap::new();
        for proof in pairs {
            let PairProof { a, part_a, b, part_b, .. } = proof;
            let name = PairName { a: a.clone(), part_a: *part_a, b: b.clone(), part_b: *part_b };
            proofs.entry(name).or_default().push(proof);
        }
        let once = |count: usize, expected: f64| {
            let mut demands = Demands::default();
            let count = count as f64;
            demands.that(is_equal(count, expected), Quantity::Occurrences, count, expected);
            demands
        };
        for bodies in &self.scene.pairs {
            let [a, b] = [bodies.a, bodies.b].map(|body| &self.scene.bodies[body]);
            for (part_a, part_b) in (0..a.parts.len()).flat_map(|i| (0..b.parts.len()).map(move |j| (i, j))) {
                let name = PairName { a: a.name.to_owned(), part_a, b: b.name.to_owned(), part_b };
                let found = proofs.remove(&name).unwrap_or_default();
                self.report.pairs += 1;
                self.report(Some(&name), whole, once(found.len(), 1.0));
                let subject = Subject { name, bodies };
                found.into_iter().for_each(|proof| self.proof(&subject, proof));
            }
        }
        for (name, found) in proofs {
            self.report(Some(&name), whole, once(found.len(), 0.0));
        }
    }

    fn proof(&mut self, subject: &Subject<'d>, proof: &PairProof) {
        match &proof.verdict {
            Verdict::Free { margin } => self.free(subject, *margin, &proof.leaves),
            Verdict::Violated(violation) => {
                self.report.violated.push(subject.name.clone());
                self.violation(subject, violation);
            }
            Verdict::Unknown {} | Verdict::NotChecked {} => self.report.undecided.push(subject.name.clone()),
        }
    }

    /// The steps must follow each other from 0 to the end, and each must hold.
    fn free(&mut self, subject: &Subject<'d>, margin: f64, leaves: &[Leaf]) {
        let duration = self.documents.plan.duration();
        let (mut until, mut least) = (0.0, f64::INFINITY);
        for leaf in leaves {
            least = least.min(self.leaf(subject, leaf, until));
            until = leaf.end;
        }
        let mut demands = Demands::default();
        demands.that(is_equal(until, duration), Quantity::End, until, duration);
        demands.that(margin <= least, Quantity::Margin, margin, least);
        self.report(Some(&subject.name), [0.0, duration], demands);
    }

    /// One step, which must begin where the one before ended; how much is left there of the required
    /// distance, m.
    fn leaf(&mut self, subject: &Subject<'d>, leaf: &Leaf, begins: f64) -> f64 {
        self.report.leaves += 1;
        let interval = [leaf.start, leaf.end];
        let mut demands = Demands::default();
        let follows = is_equal(leaf.start, begins) && leaf.start < leaf.end;
        demands.that(follows, Quantity::Start, leaf.start, begins);
        let (phase, [from, until]) = self.phase(interval);
        demands.that(leaf.start >= from - SAME_INSTANT, Quantity::Phase, leaf.start, from);
        demands.that(leaf.end <= until + SAME_INSTANT, Quantity::Phase, leaf.end, until);
        let required = self.stages[phase].required(self.scene, subject.bodies);
        demands.that(is_same(leaf.required, required), Quantity::Required, leaf.required, required.least);
        let length = leaf.normal.length();
        demands.that((length - 1.0).abs() <= UNIT_TOLERANCE, Quantity::Normal, length, 1.0);

        let scene = self.scene;
        let (motion, view) = self.view(subject, interval, phase);
        let [a, b] = &view.solids;
        let gap = slab(a, b, leaf.normal) - ROUNDING;
        demands.that(leaf.gap <= gap, Quantity::Gap, leaf.gap, gap);
        let loss = motion.loss(scene, [a, b], view.mounts, leaf.normal);
        demands.that(leaf.loss >= loss - ROUNDING, Quantity::Loss, leaf.loss, loss);
        let stated = leaf.gap - leaf.loss;
        demands.that(stated >= leaf.required, Quantity::Clearance, stated, leaf.required);
        let proved = gap - loss;
        demands.that(proved >= required.most && view.is_near, Quantity::Clearance, stated, proved);
        self.report(Some(&subject.name), interval, demands);
        proved - required.least
    }

    /// The pair must be shown to be nearer than required at some instant.
    fn violation(&mut self, subject: &Subject<'d>, violation: &Violation) {
        let Violation { time, phase: phase_name, distance: stated, required: stated_required, points } =
            violation;
        let instant = [*time; 2];
        let mut demands = Demands::default();
        let (phase, [from, _]) = self.phase(instant);
        let plan = &self.documents.plan;
        let is_there = (0.0..=plan.duration()).contains(time) && plan.phases[phase].name == *phase_name;
        demands.that(is_there, Quantity::Phase, *time, from);
        let required = self.stages[phase].required(self.scene, subject.bodies);
        demands.that(
            is_same(*stated_required, required),
            Quantity::Required,
            *stated_required,
            required.least,
        );

        let (_, view) = self.view(subject, instant, phase);
        let [a, b] = &view.solids;
        let depth = |point: Vector| [a.depth(point), b.depth(point)];
        for depth in [depth(points[0])[0], depth(points[1])[1]] {
            demands.that(depth >= -WITNESS_SLACK, Quantity::Witness, 0.0, depth);
        }
        // A ball of radius r about a point of both solids that stays in one of them, and one of s that stays
        // in the other, show that they overlap by r + s.
        let middle = (points[0] + points[1]) * 0.5;
        let overlaps = [points[0], points[1], middle].map(depth);
        let overlaps = overlaps.iter().filter(|depth| depth.iter().all(|d| *d >= -WITNESS_SLACK));
        let apart = (points[1] - points[0]).length().min(distance(a, b)[1]);
        let shown = overlaps.map(|[a, b]| -a - b).fold(apart, f64::min);
        let is_shown = shown <= stated + WITNESS_SLACK && view.is_near;
        demands.that(is_shown, Quantity::WitnessDistance, *stated, shown);
        // What is stated may be rounded to the required distance; what is shown must be below it.
        let is_nearer = *stated <= required.least && shown < required.least;
        demands.that(is_nearer, Quantity::Violation, *stated, required.least);
        self.report(Some(&subject.name), instant, demands);
    }

    /// The phase in the middle of an interval, and from when to when it lasts, s: from the end of the one
    /// before, and the last to the end of the plan.
    fn phase(&self, [start, end]: [f64; 2]) -> (usize, [f64; 2]) {
        let plan = &self.documents.plan;
        let phase = plan.phase_at(0.5 * (start + end));
        let from = if phase == 0 { 0.0 } else { plan.phases[phase - 1].end };
        let until = if phase + 1 == plan.phases.len() { plan.duration() } else { plan.phases[phase].end };
        (phase, [from, until])
    }

    /// The motion on an interval, and the solids of a pair at its middle.
    fn view(&mut self, subject: &Subject<'d>, interval: [f64; 2], phase: usize) -> (&Motion, View<'d>) {
        let (scene, stage) = (self.scene, &self.stages[phase]);
        let motion = self
            .motions
            .entry(interval.map(f64::to_bits))
            .or_insert_with(|| Motion::new(scene, &self.documents.plan, interval, stage.least_opening));
        let place = |body: usize, part: usize| {
            let mount = stage.mount(scene, body);
            let (body_from_solid, solid) = scene.bodies[body].parts[part];
            let world_from_solid =
                motion.world_from(mount.carrier) * mount.carrier_from_body * body_from_solid;
            (mount, Placed { solid, world_from_solid })
        };
        let (mount_a, a) = place(subject.bodies.a, subject.name.part_a);
        let (mount_b, b) = place(subject.bodies.b, subject.name.part_b);
        let is_near =
            a.is_near() && b.is_near() && motion.joints.iter().all(|span| span.middle.abs() < LARGEST);
        (motion, View { solids: [a, b], mounts: [mount_a, mount_b], is_near })
    }

    fn report(&mut self, pair: Option<&PairName>, interval: [f64; 2], demands: Demands) {
        let finding = |(quantity, stated, recomputed)| Finding {
            pair: pair.cloned(),
            interval,
            quantity,
            stated,
            recomputed,
        };
        self.report.findings.extend(demands.0.into_iter().map(finding));
    }
}

/// What was demanded of a statement and does not hold: which quantity, as stated and as found.
#[derive(Default)]
struct Demands(Vec<(Quantity, f64, f64)>);

impl Demands {
    /// Conditions are written so that they are false where a number is NaN.
    fn that(&mut self, holds: bool, quantity: Quantity, stated: f64, found: f64) {
        if !holds {
            self.0.push((quantity, stated, found));
        }
    }
}

fn is_same(stated: f64, required: Required) -> bool {
    (required.least - SAME_DISTANCE..=required.most + SAME_DISTANCE).contains(&stated)
}

#[expect(clippy::float_cmp, reason = "times of one plan are copies of each other, and counts are whole")]
fn is_equal(a: f64, b: f64) -> bool {
    a == b
}
