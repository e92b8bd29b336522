//! The proof of clearance: bisection of time until every pair is decided.
//!
//! On an interval, with `g` the gap of a pair at the middle across some normal and `loss` the bound on what
//! motion takes from it, `g - loss ≥ required` proves the whole interval. Two witness points nearer than
//! required disprove it. Otherwise both halves are looked at. Each node of the search computes the places of
//! the solids once for all pairs that are still open there.

use graspcheck_model::plan::Plan;
use nalgebra::Vector3;

use crate::{
    certificate::{CERTIFICATE_SCHEMA, Certificate, Doubt, Leaf, PairCertificate, PairVerdict, Violation},
    contact::{Requirement, Stages},
    displacement::Moment,
    gap::{GAP_SLACK, Separation, first_normal, gap, overlap_of_at_least, separation},
    scene::{PartPair, Scene},
    solid::Placed,
    stretch::{middle, stretches},
};

/// Intervals that cannot be decided and are shorter than this, s, end the search for their pair. An arm at
/// 10 m/s moves 10 nm in it, far less than anything a clearance is known to.
pub const SHORTEST_INTERVAL: f64 = 1e-9;

/// Once a pair is undecided at some instant it cannot be proved free, but it may be violated at another. For
/// that it is looked at again down to intervals of this length, s, so that a distance that stays exactly at
/// the required one for long does not make the search endless.
pub const SHORTEST_IN_DOUBT: f64 = 1e-3;

/// At an interval's middle the distance is found to this share of what motion can take from it: finer would
/// not decide more.
const SHARE_OF_LOSS: f64 = 0.05;

/// When motion can take more than this many times what the normal at hand leaves over, no other normal will
/// do for the whole interval.
const HOPELESS: f64 = 4.0;

/// A pair that is not decided at some node, with the normal that was best at the node above.
#[derive(Clone, Copy)]
struct Open {
    pair: usize,
    normal: Vector3<f64>,
}

/// An interval whose open pairs begin at an index of the common stack and go to its end.
struct Node {
    start: f64,
    end: f64,
    first_open: usize,
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
        let mut verdicts: Vec<Option<PairVerdict>> = vec![None; self.pairs.len()];
        let mut leaves: Vec<(usize, Leaf)> = Vec::with_capacity(4 * self.pairs.len());
        if let Err(reason) = self.prove(plan, &mut verdicts, &mut leaves) {
            verdicts.fill(Some(PairVerdict::NotChecked { reason }));
            leaves.clear();
        }
        let mut pairs: Vec<PairCertificate> = self
            .pairs
            .iter()
            .zip(verdicts)
            .map(|(pair, verdict)| {
                let bodies = &self.body_pairs[pair.bodies];
                let (a, b) = (&self.bodies[bodies.a], &self.bodies[bodies.b]);
                PairCertificate {
                    a: a.name.clone(),
                    part_a: pair.a - a.first_part,
                    b: b.name.clone(),
                    part_b: pair.b - b.first_part,
                    verdict: verdict.unwrap_or(PairVerdict::Free { margin: f64::INFINITY }),
                    leaves: Vec::new(),
                }
            })
            .collect();
        for (pair, leaf) in leaves {
            pairs[pair].leaves.push(leaf);
            if let PairVerdict::Free { margin } = &mut pairs[pair].verdict {
                *margin = margin.min(leaf.gap - leaf.loss - leaf.required);
            }
        }
        Certificate { schema: CERTIFICATE_SCHEMA, duration: plan.duration(), pairs }
    }

    fn prove(
        &self,
        plan: &Plan,
        verdicts: &mut [Option<PairVerdict>],
        leaves: &mut Vec<(usize, Leaf)>,
    ) -> Result<(), String> {
        let stretches = stretches(plan, self.robot.dof())?;
        let stages = Stages::new(self, plan)?;
        let mut moment = Moment::new(self, stages.of(0));
        let mut normals: Vec<Option<Vector3<f64>>> = vec![None; self.pairs.len()];
        let mut nodes: Vec<Node> = Vec::new();
        let mut open: Vec<Open> = Vec::new();
        let mut still_open: Vec<Open> = Vec::new();
        for stretch in &stretches {
            let phase = &plan.phases[stretch.phase];
            let stage = stages.of(stretch.phase);
            open.clear();
            for (pair, normal) in normals.iter().enumerate() {
                if !is_settled(verdicts[pair].as_ref()) {
                    let normal = normal.unwrap_or_else(Vector3::zeros);
                    open.push(Open { pair, normal });
                }
            }
            nodes.push(Node { start: stretch.start, end: stretch.end, first_open: 0 });
            while let Some(node) = nodes.pop() {
                moment.set(stage, stretch, node.start, node.end);
                still_open.clear();
                for &Open { pair, normal } in &open[node.first_open..] {
                    if is_settled(verdicts[pair].as_ref()) {
                        continue;
                    }
                    let in_doubt = verdicts[pair].is_some();
                    let view = View {
                        pair: self.pairs[pair],
                        requirement: &stage.requirements[pair],
                        interval: [node.start, node.end],
                        phase: &phase.name,
                        shortest: if in_doubt { SHORTEST_IN_DOUBT } else { SHORTEST_INTERVAL },
                    };
                    match view.step(&mut moment, &normal) {
                        Step::Proved(leaf) => {
                            normals[pair] = Some(Vector3::from(leaf.normal));
                            leaves.push((pair, leaf));
                        }
                        Step::Open(normal) => still_open.push(Open { pair, normal }),
                        // The first doubt stands until something graver is found.
                        Step::Settled(PairVerdict::Unknown(_)) if in_doubt => {}
                        Step::Settled(verdict) => verdicts[pair] = Some(verdict),
                    }
                }
                open.truncate(node.first_open);
                if !still_open.is_empty() {
                    // The later half lies below the earlier one, so that time runs forwards.
                    let half = middle(node.start, node.end);
                    open.extend_from_slice(&still_open);
                    nodes.push(Node { start: half, end: node.end, first_open: node.first_open });
                    nodes.push(Node { start: node.start, end: half, first_open: open.len() });
                    open.extend_from_slice(&still_open);
                }
            }
        }
        Ok(())
    }
}

/// A pair on an interval.
struct View<'v> {
    pair: PartPair,
    requirement: &'v Requirement,
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
        let [a, b] = moment.placed(self.pair);
        let first_look = *hint == Vector3::zeros();
        let hint = if first_look { first_normal(&a, &b) } else { *hint };
        // Most pairs are decided by the normal of a moment ago.
        let hint_loss = moment.loss(self.pair, self.requirement, &hint);
        let hint_gap = gap(&a, &b, &hint);
        if hint_gap - hint_loss >= required {
            return Step::Proved(self.leaf(&hint, hint_gap, hint_loss));
        }
        // A shorter interval is needed in any case: a search for a better normal can wait.
        let hopeless = hint_loss > HOPELESS * (hint_gap - required);
        if !first_look && hint_gap > required && hopeless && end - start >= self.shortest {
            return Step::Open(hint);
        }
        let Some(known) = separation(&a, &b, Some(&hint), SHARE_OF_LOSS * hint_loss) else {
            let time = middle(start, end);
            let reason = format!("phase {}, t = {time} s: the distance cannot be computed", self.phase);
            return Step::Settled(PairVerdict::NotChecked { reason });
        };
        if let Some(violation) = self.violation(&a, &b, &known) {
            return Step::Settled(PairVerdict::Violated(violation));
        }
        let loss = moment.loss(self.pair, self.requirement, &known.normal);
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
        assert!(json.starts_with("{\"schema\":1,"), "{json}");
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
