//! The proof of clearance: bisection of time until every pair is decided.
//!
//! On an interval, with `g` the gap of a pair at the middle across some normal and `loss` the bound on what
//! motion takes from it, `g - loss ≥ required` proves the whole interval. Two witness points nearer than
//! required disprove it. Otherwise both halves are looked at. Each node of the search computes the places of
//! the solids once for all pairs that are still open there.
//!
//! In a cell of many bodies most pairs are far apart, and not even looked at one by one: on an interval a box
//! around everything that a solid of the robot or the object sweeps over proves all bodies of the cell that
//! are far enough from it (a [`Sweep`]), and only the near ones become pairs of the search. While there are
//! many of those and the box is wide for the motion's sake, it too is halved in time.

use graspcheck_model::plan::Plan;
use nalgebra::Vector3;

use crate::{
    bounds::Bounds,
    certificate::{
        CERTIFICATE_SCHEMA, Certificate, Doubt, Leaf, PairCertificate, PairVerdict, Sweep, Violation,
    },
    contact::{Requirement, Stage, Stages},
    displacement::Moment,
    gap::{GAP_SLACK, Separation, first_normal, gap, overlap_of_at_least, separation},
    scene::{PartPair, Scene},
    solid::Placed,
    stretch::{Stretch, middle, stretches},
};

/// Intervals that cannot be decided and are shorter than this, s, end the search for their pair. An arm at
/// 10 m/s moves 10 nm in it, far less than anything a clearance is known to.
pub const SHORTEST_INTERVAL: f64 = 1e-9;

/// Once a pair is undecided at some instant it cannot be proved free, but it may be violated at another. For
/// that it is looked at again down to intervals of this length, s, so that a distance that stays exactly at
/// the required one for long does not make the search endless.
pub const SHORTEST_IN_DOUBT: f64 = 1e-3;

/// A cell with fewer solids than this is proved without sweeps: a sweep costs as much as some ten pairs that
/// one look decides.
pub const FEWEST_FOR_SWEEPS: usize = 24;

/// A sweep with no more near bodies of the cell than this is not halved in time: their pairs cost less.
pub(crate) const FEW_NEAR: usize = 4;

/// A sweep is not halved in time either when motion makes its box longer by less than this share of what the
/// solid itself measures: a shorter interval would not make it much smaller.
const SHARE_OF_MOTION: f64 = 0.5;

/// At an interval's middle the distance is found to this share of what motion can take from it: finer would
/// not decide more.
const SHARE_OF_LOSS: f64 = 0.05;

/// When motion can take more than this many times what the normal at hand leaves over, a better normal would
/// seldom do for the whole interval, and looking for it costs more than to halve the interval.
const HOPELESS: f64 = 1.4;

/// Marks a pair that the search has not met.
const NOT_MET: u32 = u32::MAX;

/// A pair that is not decided at some node, with the normal that was best at the node above.
#[derive(Clone, Copy)]
struct Open {
    /// Index into [`Search::met`].
    met: u32,
    normal: Vector3<f64>,
}

/// An interval. Its open pairs and solids begin at an index of the common stacks and go to their ends.
struct Node {
    start: f64,
    end: f64,
    first_open: usize,
    first_wide: usize,
}

/// A pair that the search looks at.
struct Met {
    /// Index into [`Scene::pairs`].
    pair: usize,
    verdict: Option<PairVerdict>,
    /// What separated it last, or zero.
    normal: Vector3<f64>,
    leaf_count: usize,
}

/// What is known of a pair at one node.
enum Step {
    Proved(Leaf),
    Open(Vector3<f64>),
    Settled(PairVerdict),
}

impl Scene {
    /// Proves for every pair of solids that it keeps its required distance at every instant of a plan, or
    /// that it does not.
    ///
    /// A pair that is violated at one instant is not looked at any further; one that cannot be decided at one
    /// instant is looked at for a violation at another, down to [`SHORTEST_IN_DOUBT`]. A plan that
    /// does not fit the robot or contradicts itself gives a certificate that says *not checked* of every
    /// pair.
    #[must_use]
    pub fn certify(&self, plan: &Plan) -> Certificate {
        let certificate = |pairs, sweeps| Certificate {
            schema: CERTIFICATE_SCHEMA,
            duration: plan.duration(),
            pair_count: self.pairs.len(),
            pairs,
            sweeps,
        };
        match self.prove(plan) {
            Ok((pairs, sweeps)) => certificate(pairs, sweeps),
            Err(reason) => {
                let verdict = || PairVerdict::NotChecked { reason: reason.clone() };
                let pairs = self.pairs.iter().map(|pair| self.pair_certificate(pair, verdict(), 0));
                certificate(pairs.collect(), Vec::new())
            }
        }
    }

    fn prove(&self, plan: &Plan) -> Result<(Vec<PairCertificate>, Vec<Sweep>), String> {
        let stretches = stretches(plan, self.robot.dof())?;
        let stages = Stages::new(self, plan)?;
        let mut search = Search::new(self, stages.of(0));
        for stretch in &stretches {
            search.go_through(stretch, stages.of(stretch.phase), &plan.phases[stretch.phase].name);
        }
        Ok(search.finish())
    }

    fn pair_certificate(&self, pair: &PartPair, verdict: PairVerdict, leaf_count: usize) -> PairCertificate {
        let bodies = &self.body_pairs[pair.bodies];
        let (a, b) = (&self.bodies[bodies.a], &self.bodies[bodies.b]);
        PairCertificate {
            a: a.name.clone(),
            part_a: pair.a - a.first_part,
            b: b.name.clone(),
            part_b: pair.b - b.first_part,
            verdict,
            leaves: Vec::with_capacity(leaf_count),
        }
    }

    /// Whether sweeps are worth their while.
    pub(crate) fn has_sweeps(&self) -> bool {
        self.parts.len() - self.first_cell_part >= FEWEST_FOR_SWEEPS
    }
}

/// The state of the search.
struct Search<'s> {
    scene: &'s Scene,
    moment: Moment<'s>,
    met: Vec<Met>,
    /// For each of [`Scene::pairs`] its index among those met, or [`NOT_MET`].
    met_of: Vec<u32>,
    /// Steps, each with the index of its pair among those met.
    leaves: Vec<(u32, Leaf)>,
    sweeps: Vec<Sweep>,
    nodes: Vec<Node>,
    open: Vec<Open>,
    still_open: Vec<Open>,
    /// Solids of the robot and the object whose sweeps are too wide.
    wide: Vec<usize>,
    still_wide: Vec<usize>,
    /// Pairs of a solid with what is near to its sweep.
    near: Vec<usize>,
}

impl<'s> Search<'s> {
    fn new(scene: &'s Scene, stage: &'s Stage) -> Self {
        let mut search = Self {
            scene,
            moment: Moment::new(scene, stage),
            met: Vec::new(),
            met_of: vec![NOT_MET; scene.pairs.len()],
            leaves: Vec::with_capacity(128),
            sweeps: Vec::new(),
            nodes: Vec::with_capacity(32),
            open: Vec::with_capacity(128),
            still_open: Vec::with_capacity(64),
            wide: Vec::new(),
            still_wide: Vec::new(),
            near: Vec::new(),
        };
        if scene.has_sweeps() {
            for &pair in &scene.pairs_without_cell {
                search.meet(pair);
            }
        } else {
            search.met.reserve_exact(scene.pairs.len());
            (0..scene.pairs.len()).for_each(|pair| {
                search.meet(pair);
            });
        }
        search
    }

    /// The index of a pair among those met, which it belongs to from now on.
    fn meet(&mut self, pair: usize) -> u32 {
        let met = &mut self.met_of[pair];
        if *met == NOT_MET {
            *met = u32::try_from(self.met.len()).expect("pairs are numbered by 32 bits");
            self.met.push(Met { pair, verdict: None, normal: Vector3::zeros(), leaf_count: 0 });
        }
        *met
    }

    /// Proves all pairs on a stretch of the plan, or finds out what they lack.
    fn go_through(&mut self, stretch: &Stretch, stage: &'s Stage, phase: &str) {
        self.open.clear();
        let every_time =
            if self.scene.has_sweeps() { self.scene.pairs_without_cell.len() } else { self.met.len() };
        for met in 0..every_time {
            self.open_again(met as u32);
        }
        if self.scene.has_sweeps() {
            self.wide.extend(0..self.scene.first_cell_part);
        }
        self.nodes.push(Node { start: stretch.start, end: stretch.end, first_open: 0, first_wide: 0 });
        while let Some(node) = self.nodes.pop() {
            self.moment.set(stage, stretch, node.start, node.end);
            self.sweep(&node, stage);
            self.look(&node, stage, phase);
            self.open.truncate(node.first_open);
            self.wide.truncate(node.first_wide);
            if self.still_open.is_empty() && self.still_wide.is_empty() {
                continue;
            }
            // The later half lies below the earlier one, so that time runs forwards.
            let half = middle(node.start, node.end);
            for [start, end] in [[half, node.end], [node.start, half]] {
                let (first_open, first_wide) = (self.open.len(), self.wide.len());
                self.open.extend_from_slice(&self.still_open);
                self.wide.extend_from_slice(&self.still_wide);
                self.nodes.push(Node { start, end, first_open, first_wide });
            }
        }
    }

    /// Makes a pair open at the node in hand unless it is settled.
    fn open_again(&mut self, met: u32) {
        let Met { verdict, normal, .. } = &self.met[met as usize];
        if !is_settled(verdict.as_ref()) {
            self.open.push(Open { met, normal: *normal });
        }
    }

    /// Sweeps of the solids at a node: what is near becomes open, unless the sweep is halved.
    fn sweep(&mut self, node: &Node, stage: &Stage) {
        self.still_wide.clear();
        for index in node.first_wide..self.wide.len() {
            let part = self.wide[index];
            let bounds = self.moment.sweep(part);
            let near = &mut self.near;
            near.clear();
            self.scene.near_to_sweep(stage, part, &bounds, 0.0, |pair, _| near.push(pair));
            let is_long = node.end - node.start > SHORTEST_IN_DOUBT;
            if near.len() > FEW_NEAR && is_long && is_wide(&mut self.moment, part, &bounds) {
                self.still_wide.push(part);
                continue;
            }
            let known = &self.scene.parts[part];
            let body = &self.scene.bodies[known.body];
            self.sweeps.push(Sweep {
                start: node.start,
                end: node.end,
                body: body.name.clone(),
                part: part - body.first_part,
                min: bounds.low.into(),
                max: bounds.high.into(),
            });
            for index in 0..self.near.len() {
                let met = self.meet(self.near[index]);
                self.open_again(met);
            }
        }
    }

    /// One look at every open pair of a node.
    fn look(&mut self, node: &Node, stage: &Stage, phase: &str) {
        self.still_open.clear();
        for &Open { met: index, normal } in &self.open[node.first_open..] {
            let met = &mut self.met[index as usize];
            if is_settled(met.verdict.as_ref()) {
                continue;
            }
            let in_doubt = met.verdict.is_some();
            let pair = self.scene.pairs[met.pair];
            let view = View {
                pair,
                requirement: stage.requirement(self.scene, &pair),
                interval: [node.start, node.end],
                phase,
                shortest: if in_doubt { SHORTEST_IN_DOUBT } else { SHORTEST_INTERVAL },
            };
            match view.step(&mut self.moment, &normal) {
                Step::Proved(leaf) => {
                    met.normal = Vector3::from(leaf.normal);
                    met.leaf_count += 1;
                    self.leaves.push((index, leaf));
                }
                Step::Open(normal) => self.still_open.push(Open { met: index, normal }),
                // The first doubt stands until something graver is found.
                Step::Settled(PairVerdict::Unknown(_)) if in_doubt => {}
                Step::Settled(verdict) => met.verdict = Some(verdict),
            }
        }
    }

    fn finish(mut self) -> (Vec<PairCertificate>, Vec<Sweep>) {
        let mut order: Vec<u32> = (0..self.met.len() as u32).collect();
        order.sort_unstable_by_key(|&met| self.met[met as usize].pair);
        let mut place_of = self.met_of;
        let mut pairs = Vec::with_capacity(order.len());
        for (place, met) in (0..).zip(order) {
            place_of[met as usize] = place;
            let Met { pair, verdict, leaf_count, .. } = &mut self.met[met as usize];
            let verdict = verdict.take().unwrap_or(PairVerdict::Free { margin: f64::INFINITY });
            pairs.push(self.scene.pair_certificate(&self.scene.pairs[*pair], verdict, *leaf_count));
        }
        for (met, leaf) in self.leaves {
            let pair: &mut PairCertificate = &mut pairs[place_of[met as usize] as usize];
            pair.leaves.push(leaf);
            if let PairVerdict::Free { margin } = &mut pair.verdict {
                *margin = margin.min(leaf.gap - leaf.loss - leaf.required);
            }
        }
        (pairs, self.sweeps)
    }
}

/// Whether motion makes up much of the box of a sweep.
pub(crate) fn is_wide(moment: &mut Moment, part: usize, sweep: &Bounds) -> bool {
    let own = Bounds::of(&moment.place(part)).extent().sum();
    sweep.extent().sum() - own > SHARE_OF_MOTION * own
}

/// A pair on an interval.
struct View<'v> {
    pair: PartPair,
    requirement: Requirement,
    interval: [f64; 2],
    phase: &'v str,
    /// An undecided interval shorter than this, s, is not halved.
    shortest: f64,
}

/// Whether a pair needs no further look: it is neither open nor merely in doubt.
fn is_settled(verdict: Option<&PairVerdict>) -> bool {
    matches!(verdict, Some(PairVerdict::Violated(_) | PairVerdict::NotChecked { .. }))
}

impl View<'_> {
    /// Looks at the pair once. `hint` is a normal, or zero where none is known.
    fn step(&self, moment: &mut Moment, hint: &Vector3<f64>) -> Step {
        let required = self.requirement.required;
        let [start, end] = self.interval;
        let first = self.requirement.first_joint;
        let [a, b] = moment.placed(self.pair);
        let hint = if *hint == Vector3::zeros() { first_normal(&a, &b) } else { *hint };
        // Most pairs are decided by the normal of a moment ago.
        let hint_gap = gap(&a, &b, &hint);
        let room = hint_gap - required;
        let hint_loss = moment.loss(self.pair, first, &hint, room);
        if hint_gap - hint_loss >= required {
            return Step::Proved(self.leaf(&hint, hint_gap, hint_loss));
        }
        // A search for a better normal can wait for a shorter interval; nothing is violated at this instant.
        if room > 0.0 && hint_loss > HOPELESS * room && end - start >= self.shortest {
            return Step::Open(hint);
        }
        // Nor need it be found by a search, often.
        let across = first_normal(&a, &b);
        let across_gap = gap(&a, &b, &across);
        if across_gap > hint_gap {
            let across_loss = moment.loss(self.pair, first, &across, across_gap - required);
            if across_gap - across_loss >= required {
                return Step::Proved(self.leaf(&across, across_gap, across_loss));
            }
        }
        let Some(known) = separation(&a, &b, Some(&hint), SHARE_OF_LOSS * hint_loss) else {
            let time = middle(start, end);
            let reason = format!("phase {}, t = {time} s: the distance cannot be computed", self.phase);
            return Step::Settled(PairVerdict::NotChecked { reason });
        };
        if let Some(violation) = self.violation(&a, &b, &known) {
            return Step::Settled(PairVerdict::Violated(violation));
        }
        let loss = moment.loss(self.pair, first, &known.normal, known.lower - required);
        if known.lower - loss >= required {
            return Step::Proved(self.leaf(&known.normal, known.lower, loss));
        }
        if end - start < self.shortest {
            let distance = [known.lower, known.upper];
            let phase = self.phase.to_owned();
            return Step::Settled(PairVerdict::Unknown(Doubt {
                interval: [start, end],
                phase,
                distance,
                required,
            }));
        }
        Step::Open(known.normal)
    }

    fn leaf(&self, normal: &Vector3<f64>, gap: f64, loss: f64) -> Leaf {
        let [start, end] = self.interval;
        Leaf { start, end, normal: (*normal).into(), gap, loss, required: self.requirement.required }
    }

    fn violation(&self, a: &Placed, b: &Placed, known: &Separation) -> Option<Violation> {
        let required = self.requirement.required;
        // Witness points are rounded too, so that they must be nearer by the slack.
        let (distance, points) = if known.upper + GAP_SLACK < required {
            (known.upper, known.points)
        } else if known.lower < required && known.upper <= GAP_SLACK {
            // The cores overlap: where that is required not to be so deep, it must be shown to be deeper.
            let depth = (-required).max(GAP_SLACK);
            (-depth, [overlap_of_at_least(a, b, depth)?; 2])
        } else {
            return None;
        };
        Some(Violation {
            time: middle(self.interval[0], self.interval[1]),
            phase: self.phase.to_owned(),
            distance,
            required,
            points: points.map(Into::into),
        })
    }
}

#[cfg(test)]
mod tests {
    use graspcheck_model::{robot::JointKind, shape::Shape};
    use graspcheck_motion::Trajectory;

    use super::*;
    use crate::{
        certificate::ProofOutcome,
        fixtures::{self, at, boxed},
        minimum::MARGIN_TOLERANCE,
    };

    const REACH: f64 = 1.0;
    const BALL: f64 = 0.01;

    /// A ball on an arm of 1 m without thickness that turns about z from -1 rad to 1 rad, and one obstacle.
    fn whirling_ball(
        obstacle: Shape,
        place: graspcheck_model::Pose,
        required: f64,
        duration: f64,
    ) -> (Scene, Plan) {
        let joints = vec![fixtures::joint(
            "pivot",
            JointKind::Revolute,
            graspcheck_model::Pose::identity(),
            Vector3::z(),
        )];
        let ball = Shape::Sphere { radius: BALL };
        let mut robot =
            fixtures::robot(joints, vec![fixtures::link("tip", vec![(at(REACH, 0.0, 0.0), ball)])]);
        for finger in &mut robot.gripper.fingers {
            finger.link.shapes.clear();
        }
        let cell = fixtures::cell(required, vec![("obstacle", obstacle, place)]);
        let scene = Scene::new(&robot, &cell, None).unwrap();
        (scene, fixtures::rest_to_rest(&[-1.0], &[1.0], duration))
    }

    #[test]
    fn a_thin_rod_between_samples_is_found() {
        // The ball passes the rod at 75 m/s: 22 mm wide together, less than one sample of 1 kHz apart.
        let rod = Shape::Cylinder { radius: 0.001, half_length: 0.5 };
        let turn: f64 = 0.021;
        let (scene, plan) = whirling_ball(rod, at(turn.cos(), turn.sin(), 0.0), 0.0, 0.05);
        let mut sampler = scene.sampler(&plan).unwrap();
        let sampled = (0..=50).map(|ms| {
            let t = f64::from(ms) / 1000.0;
            sampler.margin(t, &plan.trajectory.eval(t.min(plan.duration())).q, 0.05, None).unwrap()
        });
        assert!(sampled.fold(f64::INFINITY, f64::min) > 0.0, "the rod is met by a sample; move it");
        let certificate = scene.certify(&plan);
        assert_eq!(certificate.outcome(), ProofOutcome::Violated);
        let (pair, violation) = certificate.violations().next().unwrap();
        assert_eq!((pair.a.as_str(), pair.b.as_str()), ("tip", "obstacle"));
        let angle = plan.trajectory.eval(violation.time).q[0];
        let gap = 2.0 * (0.5 * (angle - turn)).sin().abs() - BALL - 0.001;
        assert!(gap < 0.0, "at {} s the true distance is {gap} m", violation.time);
        // When the axes meet the overlap is 11 mm; what can be shown of it is the ball's radius.
        let least = scene.minimum_margin(&plan, MARGIN_TOLERANCE).unwrap();
        assert!(least.lower <= -0.011 + 1e-9 && least.upper <= -0.01 + 1e-5, "{least:?}");
    }

    #[test]
    fn grazing_by_fifty_micrometres_is_told_from_missing_by_fifty() {
        for (beside, free) in [(5e-5, true), (-5e-5, false)] {
            let wall = boxed(0.05, 0.3, 0.1);
            let place = at(REACH + BALL + beside + 0.05, 0.0, 0.0);
            let (scene, plan) = whirling_ball(wall, place, 0.0, 1.0);
            let certificate = scene.certify(&plan);
            assert_eq!(certificate.is_free(), free, "{certificate:?}");
            assert_eq!(certificate.outcome() == ProofOutcome::Violated, !free);
            let least = scene.minimum_margin(&plan, 1e-6).unwrap();
            assert!(least.lower <= beside && beside <= least.upper + 1e-9, "{least:?}");
            assert!(least.upper - least.lower <= 1e-6, "{least:?}");
            assert!((least.time - 0.5).abs() < 0.01, "{least:?}");
        }
    }

    #[test]
    fn a_required_distance_that_is_met_exactly_is_unknown() {
        let (scene, plan) =
            whirling_ball(boxed(0.05, 0.3, 0.1), at(REACH + BALL + 0.002 + 0.05, 0.0, 0.0), 0.002, 1.0);
        let certificate = scene.certify(&plan);
        assert_eq!(certificate.outcome(), ProofOutcome::Unknown);
        let PairVerdict::Unknown(doubt) = &certificate.pairs[0].verdict else {
            panic!("{:?}", certificate.pairs[0].verdict)
        };
        assert!(doubt.distance.iter().all(|d| (d - 0.002).abs() < 1e-8), "{doubt:?}");
        assert!(doubt.interval[0] <= 0.5 + 1e-4 && doubt.interval[1] >= 0.5 - 1e-4, "{doubt:?}");
    }

    /// Where the distance falls through the required one, no interval around that instant is decided. What
    /// comes after is a violation all the same.
    #[test]
    fn a_doubt_on_the_way_to_an_overlap_does_not_hide_it() {
        let (place, required) = (at(2.0_f64.cos(), 2.0_f64.sin(), 0.0), 0.002);
        let (scene, mut plan) = whirling_ball(Shape::Sphere { radius: 0.05 }, place, required, 1.0);
        // At the instant of exactly the required distance a motion ends, so that it is looked at closely.
        let touch = 2.0 * ((0.05 + BALL + required) / 2.0).asin();
        let (from, there, to) = (0.0, 2.0 - touch, 2.0);
        let pieces = [[from, there], [there, there], [there, to]]
            .map(|[a, b]| graspcheck_motion::Polynomial::quintic_hermite([a, 0.0, 0.0], [b, 0.0, 0.0], 1.0));
        plan.trajectory = Trajectory::new(1, vec![0.0, 1.0, 2.0, 3.0], pieces.to_vec()).unwrap();
        plan.opening = Trajectory::hold(&[0.05], 3.0).unwrap();
        plan.phases[0].end = 3.0;
        let certificate = scene.certify(&plan);
        assert_eq!(certificate.outcome(), ProofOutcome::Violated, "{certificate:?}");
        // Without the last motion the doubt is all that there is.
        plan.trajectory = Trajectory::new(1, vec![0.0, 1.0, 2.0], pieces[..2].to_vec()).unwrap();
        plan.opening = Trajectory::hold(&[0.05], 2.0).unwrap();
        plan.phases[0].end = 2.0;
        assert_eq!(scene.certify(&plan).outcome(), ProofOutcome::Unknown);
    }

    /// The leaves of a free pair follow each other from 0 to the end without a gap, and each holds.
    #[test]
    #[expect(clippy::float_cmp, reason = "neighbours share the very same number")]
    fn leaves_cover_the_whole_motion() {
        let post = ("post", boxed(0.05, 0.05, 0.2), at(0.75, 0.2, 0.2));
        let scene = Scene::new(&fixtures::scara(), &fixtures::cell(0.001, vec![post]), None).unwrap();
        let there = fixtures::rest_to_rest(&[-1.0, 0.2, 0.0, 0.0], &[-0.2, 1.0, 0.05, 3.0], 0.7);
        let back = fixtures::rest_to_rest(&[-0.2, 1.0, 0.05, 3.0], &[-1.5, 0.1, 0.0, 9.0], 1.1);
        let mut plan = fixtures::rest_to_rest(&[0.0; 4], &[0.0; 4], 1.8);
        plan.trajectory = there.trajectory.then(&back.trajectory).unwrap();
        plan.phases[0].end = plan.trajectory.duration();
        let certificate = scene.certify(&plan);
        assert_eq!(certificate.outcome(), ProofOutcome::Free, "{certificate:?}");
        for pair in &certificate.pairs {
            let mut time = 0.0;
            let PairVerdict::Free { margin } = pair.verdict else { panic!("{pair:?}") };
            for leaf in &pair.leaves {
                assert_eq!(leaf.start, time, "{pair:?}");
                assert!(leaf.end > leaf.start && leaf.gap - leaf.loss >= leaf.required);
                assert!(leaf.gap - leaf.loss - leaf.required >= margin);
                time = leaf.end;
            }
            assert_eq!(time, plan.duration());
        }
    }

    #[test]
    fn the_same_plan_gives_the_same_certificate_and_json_keeps_it() {
        let (scene, plan) = whirling_ball(boxed(0.05, 0.3, 0.1), at(1.1, 0.0, 0.0), 0.0, 1.0);
        let certificate = scene.certify(&plan);
        assert_eq!(certificate, scene.certify(&plan));
        let json = serde_json::to_string(&certificate).unwrap();
        assert_eq!(serde_json::from_str::<Certificate>(&json).unwrap(), certificate);
        assert!(json.starts_with("{\"schema\":2,"), "{json}");
    }

    /// A SCARA among boxes of which most are far, some near, and some in its way.
    fn crowded() -> (Scene, Plan, Vec<(String, Shape, graspcheck_model::Pose)>) {
        let mut draw = fixtures::Draw(41);
        let some_box = |index: usize| {
            let mut coordinate = |half: f64| draw.between(-half, half);
            let place = at(coordinate(1.0), coordinate(1.0), 0.3 + coordinate(0.3));
            (format!("box_{index}"), boxed(0.02, 0.03, 0.01), place)
        };
        let bodies: Vec<_> = (0..80).map(some_box).collect();
        let plan = fixtures::rest_to_rest(&[-0.6, 0.4, 0.0, 0.0], &[0.6, 1.6, -0.05, 3.0], 1.0);
        (among(&bodies), plan, bodies)
    }

    fn among(bodies: &[(String, Shape, graspcheck_model::Pose)]) -> Scene {
        let bodies = bodies.iter().map(|(name, shape, place)| (name.as_str(), shape.clone(), *place));
        Scene::new(&fixtures::scara(), &fixtures::cell(0.002, bodies.collect()), None).unwrap()
    }

    /// The documented rule, by itself: what is free is covered by leaves and by sweeps whose box is far enough.
    #[test]
    #[expect(clippy::float_cmp, reason = "neighbours share the very same number")]
    fn leaves_and_sweeps_together_cover_the_whole_motion() {
        let (scene, plan, _) = crowded();
        let certificate = scene.certify(&plan);
        assert_eq!(certificate.pair_count, scene.pairs.len());
        assert!(certificate.sweeps.len() > 10 && certificate.pairs.len() < scene.pairs.len() / 2);
        assert!(certificate.sweeps.is_sorted_by(|a, b| a.start <= b.start));
        let (mut by_sweeps_alone, mut by_both) = (0, 0);
        for pair in &scene.pairs {
            let named = scene.pair_certificate(pair, PairVerdict::Free { margin: 0.0 }, 0);
            let is_same = |listed: &&PairCertificate| {
                (&listed.a, listed.part_a, &listed.b) == (&named.a, named.part_a, &named.b)
            };
            let listed = certificate.pairs.iter().find(is_same);
            if listed.is_some_and(|listed| !matches!(listed.verdict, PairVerdict::Free { .. })) {
                continue;
            }
            let leaves = listed.map_or(&[][..], |listed| &listed.leaves);
            let mut covered: Vec<[f64; 2]> = leaves.iter().map(|leaf| [leaf.start, leaf.end]).collect();
            for sweep in certificate
                .sweeps
                .iter()
                .filter(|sweep| (&sweep.body, sweep.part) == (&named.a, named.part_a))
            {
                let bounds = Bounds { low: sweep.min.into(), high: sweep.max.into() };
                if pair.b >= scene.first_cell_part
                    && bounds.distance(&Bounds::of(&scene.still(pair.b))) > 0.002 + GAP_SLACK
                {
                    covered.push([sweep.start, sweep.end]);
                }
            }
            by_sweeps_alone += usize::from(leaves.is_empty());
            by_both += usize::from(!leaves.is_empty() && covered.len() > leaves.len());
            covered.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let mut time = 0.0;
            for [start, end] in covered {
                assert_eq!(start, time, "{named:?}");
                time = end;
            }
            assert_eq!(time, plan.duration(), "{named:?}");
        }
        assert!(by_sweeps_alone > 100 && by_both > 10, "{by_sweeps_alone} {by_both}");
    }

    /// Each body by itself is proved without sweeps. All together must come out the same.
    #[test]
    fn many_bodies_are_judged_as_each_by_itself() {
        let (scene, plan, bodies) = crowded();
        let certificate = scene.certify(&plan);
        let violated: Vec<_> =
            certificate.violations().map(|(pair, _)| (pair.a.clone(), pair.b.clone())).collect();
        let mut expected = Vec::new();
        let mut least: Option<crate::MarginBounds> = None;
        for body in &bodies {
            let alone = among(std::slice::from_ref(body));
            assert!(!alone.has_sweeps());
            let proof = alone.certify(&plan);
            assert!(proof.sweeps.is_empty() && proof.pairs.len() == alone.pairs.len());
            expected.extend(proof.violations().map(|(pair, _)| (pair.a.clone(), pair.b.clone())));
            let found = alone.minimum_margin(&plan, 1e-5).unwrap();
            if least.as_ref().is_none_or(|least| found.upper < least.upper) {
                least = Some(found);
            }
        }
        expected.sort();
        let mut sorted = violated.clone();
        sorted.sort();
        assert_eq!(sorted, expected);
        assert!(violated.len() > 2 && certificate.outcome() == ProofOutcome::Violated, "{}", violated.len());
        let (found, least) = (scene.minimum_margin(&plan, 1e-5).unwrap(), least.unwrap());
        assert_eq!((&found.a, &found.b), (&least.a, &least.b));
        assert!((found.upper - least.upper).abs() < 2e-5, "{found:?} {least:?}");

        // Without what is in the way the plan is free, and its least margin is that of the nearest body.
        let others: Vec<_> =
            bodies.iter().filter(|body| !violated.iter().any(|(_, b)| *b == body.0)).cloned().collect();
        let scene = among(&others);
        assert!(scene.has_sweeps() && scene.certify(&plan).is_free());
        let found = scene.minimum_margin(&plan, 1e-5).unwrap();
        let alone =
            others.iter().map(|body| among(std::slice::from_ref(body)).minimum_margin(&plan, 1e-5).unwrap());
        let least = alone.min_by(|a, b| a.upper.total_cmp(&b.upper)).unwrap();
        assert!(
            (found.upper - least.upper).abs() < 2e-5 && found.lower <= found.upper,
            "{found:?} {least:?}"
        );
        assert!(found.lower >= scene.certify(&plan).proved_margin() - 1e-12);
    }

    /// A body that no box bounds is near to everything.
    #[test]
    fn one_of_many_bodies_that_cannot_be_judged_is_not_checked() {
        let (_, plan, mut bodies) = crowded();
        bodies.truncate(FEWEST_FOR_SWEEPS);
        bodies[0].2 = at(1e5, 0.0, 0.0);
        let scene = among(&bodies);
        assert!(scene.has_sweeps());
        let certificate = scene.certify(&plan);
        let not_checked = |pair: &&PairCertificate| matches!(pair.verdict, PairVerdict::NotChecked { .. });
        assert!(certificate.pairs.iter().filter(not_checked).all(|pair| pair.b == "box_0"));
        // Four links and two fingers; the base of this arm has no solid.
        assert_eq!(certificate.pairs.iter().filter(not_checked).count(), 6);
        assert!(scene.minimum_margin(&plan, 1e-5).is_none());
    }

    #[test]
    fn a_plan_that_does_not_fit_is_not_checked() {
        let (scene, good) = whirling_ball(boxed(0.05, 0.3, 0.1), at(1.1, 0.0, 0.0), 0.0, 1.0);
        let mut plans = [good.clone(), good.clone(), good.clone(), good.clone(), good.clone()];
        plans[0].trajectory = Trajectory::hold(&[0.0, 0.0], 1.0).unwrap();
        plans[1].opening = Trajectory::hold(&[0.05], 2.0).unwrap();
        plans[2].phases[0].end = 0.9;
        plans[3].phases.clear();
        plans[4].phases[0].start = 0.1;
        for plan in &plans {
            let certificate = scene.certify(plan);
            assert_eq!(certificate.outcome(), ProofOutcome::NotChecked, "{certificate:?}");
            assert!(scene.minimum_margin(plan, 1e-5).is_none());
        }
        assert_eq!(scene.certify(&good).outcome(), ProofOutcome::Free);
    }

    #[test]
    fn numbers_that_are_too_large_are_not_checked() {
        let (scene, mut plan) = whirling_ball(boxed(0.05, 0.3, 0.1), at(1.1, 0.0, 0.0), 0.0, 1.0);
        plan.trajectory = Trajectory::hold(&[1e300], 1.0).unwrap();
        assert_eq!(scene.certify(&plan).outcome(), ProofOutcome::Free, "an angle is an angle");
        let (scene, plan) = whirling_ball(boxed(0.05, 0.3, 0.1), at(1e5, 0.0, 0.0), 0.0, 1.0);
        assert_eq!(scene.certify(&plan).outcome(), ProofOutcome::NotChecked);
    }

    #[test]
    fn nothing_to_check_is_not_free() {
        let robot = fixtures::robot(
            vec![fixtures::joint("pivot", JointKind::Revolute, at(0.0, 0.0, 0.0), Vector3::z())],
            vec![fixtures::link("tip", vec![])],
        );
        let scene = Scene::new(&robot, &fixtures::cell(0.0, vec![]), None).unwrap();
        let certificate = scene.certify(&fixtures::rest_to_rest(&[0.0], &[1.0], 1.0));
        assert_eq!(certificate.outcome(), ProofOutcome::NotChecked);
    }
}
