//! The proof of clearance: bisection of time until every pair is decided.
//!
//! On an interval, with `g` the gap of a pair at the middle across some normal and `loss` the bound on what
//! motion takes from it, `g - loss ≥ required` proves the whole interval. Two witness points nearer than
//! required disprove it. Otherwise both halves are looked at. Each node of the search computes the places of
//! the solids once for all pairs that are still open there.

use graspcheck_model::plan::{Holding, Plan};
use nalgebra::Vector3;

use crate::{
    certificate::{
        CERTIFICATE_SCHEMA, Certificate, Doubt, Leaf, PairCertificate, PairVerdict, Violation,
    },
    contact::{Requirement, Stage},
    displacement::Moment,
    gap::{self, Separation, gap, separation},
    scene::{PartPair, Scene},
    solid::Placed,
    stretch::{Stretch, middle, stretches},
};

/// Intervals that cannot be decided and are shorter than this, s, end the search for their pair. An arm at
/// 10 m/s moves 10 nm in it, far less than anything a clearance is known to.
pub const SHORTEST_INTERVAL: f64 = 1e-9;

/// At an interval's middle the distance is found to this share of what motion can take from it: finer would
/// not decide more.
const SHARE_OF_LOSS: f64 = 0.05;

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
    /// A pair that is violated or cannot be decided at one instant is not looked at any further. A plan that
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
        let mut moment = Moment::new(self, stages.of(plan.phases[0].holding));
        let mut normals: Vec<Option<Vector3<f64>>> = vec![None; self.pairs.len()];
        let mut nodes: Vec<Node> = Vec::new();
        let mut open: Vec<Open> = Vec::new();
        let mut still_open: Vec<Open> = Vec::new();
        for stretch in &stretches {
            let phase = &plan.phases[stretch.phase];
            let stage = stages.of(phase.holding);
            open.clear();
            for (pair, normal) in normals.iter().enumerate() {
                if verdicts[pair].is_none() {
                    let normal = normal.unwrap_or_else(Vector3::zeros);
                    open.push(Open { pair, normal });
                }
            }
            nodes.push(Node { start: stretch.start, end: stretch.end, first_open: 0 });
            while let Some(node) = nodes.pop() {
                moment.set(stage, stretch, node.start, node.end);
                still_open.clear();
                for &Open { pair, normal } in &open[node.first_open..] {
                    if verdicts[pair].is_some() {
                        continue;
                    }
                    let view = View {
                        pair: self.pairs[pair],
                        requirement: &stage.requirements[pair],
                        interval: [node.start, node.end],
                        phase: &phase.name,
                    };
                    match view.step(&mut moment, &normal) {
                        Step::Proved(leaf) => {
                            normals[pair] = Some(Vector3::from(leaf.normal));
                            leaves.push((pair, leaf));
                        }
                        Step::Open(normal) => still_open.push(Open { pair, normal }),
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
}

impl View<'_> {
    /// Looks at the pair once. `hint` is a normal, or zero where none is known.
    fn step(&self, moment: &mut Moment, hint: &Vector3<f64>) -> Step {
        let required = self.requirement.required;
        let [a, b] = moment.placed(self.pair);
        let mut hint = *hint;
        if hint == Vector3::zeros() {
            hint = first_normal(&a, &b);
        }
        // Most pairs are decided by the normal of a moment ago.
        let hint_loss = moment.loss(self.pair, self.requirement, &hint);
        let hint_gap = gap(&a, &b, &hint);
        if hint_gap - hint_loss >= required {
            return Step::Proved(self.leaf(&hint, hint_gap, hint_loss));
        }
        let Some(known) = separation(&a, &b, Some(&hint), SHARE_OF_LOSS * hint_loss) else {
            let [start, end] = self.interval;
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
        let [start, end] = self.interval;
        if end - start < SHORTEST_INTERVAL {
            let distance = [known.lower, known.upper];
            let phase = self.phase.to_owned();
            return Step::Settled(PairVerdict::Unknown(Doubt { interval: [start, end], phase, distance, required }));
        }
        Step::Open(known.normal)
    }

    fn leaf(&self, normal: &Vector3<f64>, gap: f64, loss: f64) -> Leaf {
        let [start, end] = self.interval;
        Leaf { start, end, normal: (*normal).into(), gap, loss, required: self.requirement.required }
    }

    fn violation(&self, a: &Placed, b: &Placed, known: &Separation) -> Option<Violation> {
        let required = self.requirement.required;
        let (distance, points) = if known.upper < required {
            (known.upper, known.points)
        } else if required < 0.0 && known.lower < required {
            let common = gap::overlap_of_at_least(a, b, -required)?;
            (required, [common; 2])
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

/// A normal to begin with: from the point of one solid's bounding ball to the other's.
pub(crate) fn first_normal(a: &Placed, b: &Placed) -> Vector3<f64> {
    (b.place.center - a.place.center).try_normalize(1e-12).unwrap_or_else(Vector3::z)
}

/// The scene in every kind of holding that a plan has.
pub(crate) struct Stages(Vec<(Holding, Stage)>);

impl Stages {
    pub(crate) fn new(scene: &Scene, plan: &Plan) -> Result<Self, String> {
        let mut stages: Vec<(Holding, Stage)> = Vec::with_capacity(6);
        for phase in &plan.phases {
            if stages.iter().all(|(holding, _)| *holding != phase.holding) {
                stages.push((phase.holding, Stage::new(scene, plan, phase.holding)?));
            }
        }
        Ok(Self(stages))
    }

    /// # Panics
    /// When the plan has no phase that holds the object so.
    pub(crate) fn of(&self, holding: Holding) -> &Stage {
        let found = self.0.iter().find(|(known, _)| *known == holding);
        &found.expect("there is a stage for the holding of every phase of the plan").1
    }
}

/// A pair, the stretch of the plan and the interval: kept together by the search for the least margin.
pub(crate) fn stage_of<'s>(stages: &'s Stages, plan: &Plan, stretch: &Stretch) -> &'s Stage {
    stages.of(plan.phases[stretch.phase].holding)
}
