//! Boxes that hold a moving solid for a while, and prove it to be away from everything that is far from them.

use std::collections::BTreeMap;

use crate::{
    Quantity, ROUNDING,
    clearance::Subject,
    demand::Demands,
    documents::{Documents, Sweep},
    policy::Stage,
    scene::{Role, Scene},
    solid::Placed,
    vector::Vector,
};

/// Least and largest coordinates, m.
type Bounds = [Vector; 2];

/// The sweeps of a certificate, by solid and in order of time.
pub(crate) struct Sweeps<'d> {
    documents: &'d Documents,
    /// The solids that have some, in order, and where theirs begin among all.
    of_solid: Vec<Vec<&'d Sweep>>,
    /// Around each solid of the cell; nothing around others.
    bounds: Vec<Option<Bounds>>,
    /// More than any two solids must keep apart, m.
    most_required: f64,
}

impl<'d> Sweeps<'d> {
    /// Sorts the sweeps of a certificate. Also returned are those that are of no moving solid, do not last, or
    /// begin before one of the same solid has ended, with what is wrong.
    pub(crate) fn of(documents: &'d Documents, scene: &Scene) -> (Self, Vec<(&'d Sweep, Demands)>) {
        let sweeps = &documents.certificate.sweeps;
        let mut all = Self {
            documents,
            of_solid: vec![Vec::new(); scene.solids.len()],
            bounds: Vec::new(),
            most_required: Stage::most_required(documents),
        };
        let mut wrong = Vec::new();
        if sweeps.is_empty() {
            return (all, wrong);
        }
        let is_of_cell = |body: usize| scene.bodies[body].role == Role::Cell;
        let bounds = scene.solids.iter().map(|it| {
            let world_from_solid = scene.bodies[it.body].mount.carrier_from_body * it.body_from_solid;
            is_of_cell(it.body).then(|| Placed { solid: it.solid, world_from_solid }.bounds())
        });
        all.bounds = bounds.collect();
        let index: BTreeMap<&str, usize> =
            scene.bodies.iter().enumerate().map(|(index, body)| (body.name, index)).collect();
        for sweep in sweeps {
            let body = index.get(sweep.body.as_str()).copied().filter(|body| !is_of_cell(*body));
            if let Some(solid) = body.and_then(|body| scene.solids_of(body).nth(sweep.part)) {
                all.of_solid[solid].push(sweep);
            } else {
                let mut demands = Demands::default();
                demands.occurs(1, 0);
                wrong.push((sweep, demands));
            }
        }
        for sweeps in &mut all.of_solid {
            sweeps.sort_by(|x, y| x.start.total_cmp(&y.start));
            let mut until = 0.0;
            for &sweep in sweeps.iter() {
                let mut demands = Demands::default();
                let follows = sweep.start >= until && sweep.start < sweep.end;
                demands.that(follows, Quantity::Start, sweep.start, until);
                wrong.push((sweep, demands));
                until = sweep.end;
            }
        }
        (all, wrong)
    }

    /// Every sweep of a solid that there is, with the index of the solid.
    pub(crate) fn all(&self) -> impl Iterator<Item = (usize, &'d Sweep)> {
        let of_solid = self.of_solid.iter().enumerate();
        of_solid.flat_map(|(solid, sweeps)| sweeps.iter().map(move |sweep| (solid, *sweep)))
    }

    /// Until when sweeps that follow each other prove a pair, s, from a time on and not beyond another.
    pub(crate) fn cover(
        &self,
        scene: &Scene,
        stages: &[Stage],
        subject: Subject,
        [from, until]: [f64; 2],
    ) -> f64 {
        let [moving, other] = subject.solids;
        let Some(Some(bounds)) = self.bounds.get(other) else { return from };
        let sweeps = &self.of_solid[moving];
        let mut covered = from;
        let first = sweeps.partition_point(|sweep| sweep.end <= from);
        for sweep in &sweeps[first..] {
            if covered >= until || sweep.start > covered {
                break;
            }
            let apart = distance([sweep.min, sweep.max], *bounds) - ROUNDING;
            if apart <= self.most_required {
                let (phase, _) = self.documents.plan.phase([sweep.start, sweep.end]);
                let required = stages[phase].required(scene, subject.bodies).most;
                if !(apart > 0.0 && apart >= required) {
                    break;
                }
            }
            covered = sweep.end.min(until);
        }
        covered
    }
}

/// How far two boxes are apart, m; 0 where they touch or overlap.
fn distance([low, high]: Bounds, [other_low, other_high]: Bounds) -> f64 {
    let apart =
        |axis: usize| (other_low.0[axis] - high.0[axis]).max(low.0[axis] - other_high.0[axis]).max(0.0);
    Vector([0, 1, 2].map(apart)).length()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_apart_by_their_nearest_sides_edges_or_corners() {
        let cube = |x: f64, y: f64, z: f64| [Vector([x, y, z]), Vector([x + 1.0, y + 1.0, z + 1.0])];
        let from_origin = |other| distance(cube(0.0, 0.0, 0.0), other);
        for (other, expected) in [
            (cube(4.0, 0.5, -0.5), 3.0),
            (cube(0.0, -5.0, 5.0), 32.0_f64.sqrt()),
            (cube(3.0, 3.0, 2.0), 3.0),
            (cube(0.9, 0.5, 0.5), 0.0),
        ] {
            assert!((from_origin(other) - expected).abs() < 1e-15, "{other:?}");
        }
    }
}
