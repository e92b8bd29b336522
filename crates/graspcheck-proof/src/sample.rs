//! The margin at single instants, for plots. Not a proof of anything between them.

use graspcheck_model::{Pose, plan::Plan};
use nalgebra::Vector3;

use crate::{
    chain::Carrier,
    contact::{Stage, Stages},
    displacement::Moment,
    gap::{FINEST_TOLERANCE, first_normal, gap, separation},
    scene::Scene,
};

/// Evaluates the least margin at given joint positions, one instant after the other.
pub struct Sampler<'s> {
    scene: &'s Scene,
    plan: &'s Plan,
    stages: Stages,
    normals: Vec<Vector3<f64>>,
}

impl Scene {
    /// A sampler of the least margin along a plan; none when the plan lacks data.
    #[must_use]
    pub fn sampler<'s>(&'s self, plan: &'s Plan) -> Option<Sampler<'s>> {
        let stages = Stages::new(self, plan).ok()?;
        if plan.phases.is_empty() {
            return None;
        }
        Some(Sampler { scene: self, plan, stages, normals: vec![Vector3::zeros(); self.pairs.len()] })
    }

    /// The least margin at one instant; see [`Sampler::margin`], which is faster for many.
    #[must_use]
    pub fn margin_at(
        &self,
        plan: &Plan,
        t: f64,
        q: &[f64],
        opening: f64,
        world_from_object: Option<&Pose>,
    ) -> Option<f64> {
        self.sampler(plan)?.margin(t, q, opening, world_from_object)
    }
}

impl Sampler<'_> {
    /// The least margin, m (signed distance less the required one), over the pairs that may not touch in the
    /// phase of the plan at time `t` (s): at arm positions `q` (rad or m), a gripper opening (m), and the
    /// object where it was measured, or where the phase has it. It is rounded down by at most 1 µm.
    ///
    /// None when no pair counts, `q` has the wrong length, or a distance cannot be computed.
    pub fn margin(
        &mut self,
        t: f64,
        q: &[f64],
        opening: f64,
        world_from_object: Option<&Pose>,
    ) -> Option<f64> {
        if q.len() != self.scene.robot.dof() {
            return None;
        }
        let planned = self.stages.of(self.plan.phase_index_at(t));
        let measured: Stage;
        let stage = match (world_from_object, self.scene.object_part) {
            (Some(pose), Some(part)) => {
                let mut moved = planned.clone();
                moved.stand_object(self.scene, part, Carrier::World, *pose);
                measured = moved;
                &measured
            }
            _ => planned,
        };
        let mut moment = Moment::new(self.scene, stage);
        moment.set_still(stage, q, opening);
        let mut least: Option<f64> = None;
        for (index, pair) in self.scene.pairs.iter().enumerate() {
            let requirement = planned.requirement(self.scene, pair);
            if !requirement.counts() {
                continue;
            }
            let [a, b] = moment.placed(self.scene.pairs[index]);
            let normal = &mut self.normals[index];
            if *normal == Vector3::zeros() {
                *normal = first_normal(&a, &b);
            }
            if least.is_some_and(|least| gap(&a, &b, normal) - requirement.required >= least) {
                continue;
            }
            let known = separation(&a, &b, Some(normal), FINEST_TOLERANCE)?;
            *normal = known.normal;
            let margin = known.lower - requirement.required;
            least = Some(least.map_or(margin, |least| least.min(margin)));
        }
        least
    }
}
