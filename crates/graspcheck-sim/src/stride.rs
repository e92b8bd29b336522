//! How far bodies move in one step, held against how thick they are.
//!
//! Contacts are found where bodies stand at the beginning of each step. For one convex solid to pass through
//! another between two such instants, it must move by the widths of both along the way. A run in which two
//! bodies move against each other by more in one step is given up: it could have missed a collision. What
//! can still be missed is a corner that cuts a corner, by less than the way of one step.

use graspcheck_model::Pose;

use crate::plant::{Plant, Size};

/// The motion of all bodies from step to step.
pub(crate) struct Stride {
    sizes: Vec<Size>,
    /// Pairs that are held against each other, with what they are thick together, m.
    pairs: Vec<(usize, usize, f64)>,
    before: Vec<Pose>,
    moved: Vec<f64>,
}

/// Two bodies that moved too far in one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TooFar {
    pub(crate) a: usize,
    pub(crate) b: usize,
    /// At most by how much they moved against each other, m.
    pub(crate) moved: f64,
    /// What they are thick together, m.
    pub(crate) thickness: f64,
}

impl Stride {
    /// Nothing has moved from these poses.
    pub(crate) fn new(plant: &Plant, world_from_body: &[Pose]) -> Self {
        let sizes = plant.sizes().to_vec();
        let pairs = (0..sizes.len())
            .flat_map(|a| (a + 1..sizes.len()).map(move |b| (a, b)))
            .filter(|&(a, b)| plant.are_held_against_each_other(a, b))
            .map(|(a, b)| (a, b, sizes[a].thickness + sizes[b].thickness))
            .collect();
        Self { moved: vec![0.0; sizes.len()], sizes, pairs, before: world_from_body.to_vec() }
    }

    /// Takes the poses after a step; the first pair that moved too far in it.
    pub(crate) fn advance(&mut self, world_from_body: &[Pose]) -> Option<TooFar> {
        let poses = self.before.iter_mut().zip(world_from_body);
        for ((moved, size), (before, now)) in self.moved.iter_mut().zip(&self.sizes).zip(poses) {
            let origin = (now.translation.vector - before.translation.vector).norm();
            *moved = origin + size.reach * before.rotation.angle_to(&now.rotation);
            *before = *now;
        }
        self.pairs.iter().find_map(|&(a, b, thickness)| {
            let moved = self.moved[a] + self.moved[b];
            (moved > thickness).then_some(TooFar { a, b, moved, thickness })
        })
    }
}
