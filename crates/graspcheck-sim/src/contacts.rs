//! What touches what: one row for each pair of bodies that presses or overlaps.

use graspcheck_model::Pose;
use nalgebra::Vector3;

use crate::{convert, plant::Plant};

/// A contact between two bodies in one step.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Contact {
    /// Index of the body whose name comes first in the alphabet.
    pub(crate) a: usize,
    /// Index of the other.
    pub(crate) b: usize,
    /// How deep they overlap at the beginning of the step, m; negative while apart.
    pub(crate) depth: f64,
    /// Sum of the normal forces of all contact points, N: the mean over the step.
    pub(crate) force: f64,
    /// The deepest contact point in the world, m.
    pub(crate) point: [f64; 3],
    /// Unit normal from a to b in the world.
    pub(crate) normal: [f64; 3],
}

/// The contacts of one step, kept to be filled again.
pub(crate) struct Contacts {
    rows: Vec<Contact>,
    /// Place of each body in the alphabet.
    rank: Vec<usize>,
}

impl Contacts {
    /// No contacts yet between bodies of these names.
    pub(crate) fn new(names: &[String]) -> Self {
        let mut order: Vec<usize> = (0..names.len()).collect();
        order.sort_by(|left, right| names[*left].cmp(&names[*right]));
        let mut rank = vec![0; names.len()];
        for (place, body) in order.into_iter().enumerate() {
            rank[body] = place;
        }
        Self { rows: Vec::new(), rank }
    }

    /// Reads the contacts of the step that was just made. Rapier finds contacts at the beginning of a
    /// step and then solves for the forces, so `world_from_body` are the poses *before* the step, and
    /// `dt` its length, s.
    pub(crate) fn collect(&mut self, plant: &Plant, world_from_body: &[Pose], dt: f64) {
        self.rows.clear();
        for pair in plant.contact_pairs() {
            let (body_1, body_from_collider) = plant.collider(pair.collider1);
            let (body_2, _) = plant.collider(pair.collider2);
            for manifold in pair.manifolds() {
                let Some(deepest) = manifold.find_deepest_contact() else { continue };
                let impulse: f64 = manifold.points.iter().map(|point| point.data.impulse).sum();
                if impulse <= 0.0 && deepest.dist >= 0.0 {
                    continue;
                }
                let world_from_collider = world_from_body[body_1] * body_from_collider;
                let local_point = convert::vector_from_rapier(deepest.local_p1);
                let normal_1_to_2 =
                    world_from_collider.rotation * convert::vector_from_rapier(manifold.local_n1);
                self.add(Contact {
                    a: body_1,
                    b: body_2,
                    depth: -deepest.dist,
                    force: impulse / dt,
                    point: (world_from_collider * nalgebra::Point3::from(local_point)).into(),
                    normal: normal_1_to_2.into(),
                });
            }
        }
        let rank = &self.rank;
        self.rows.sort_unstable_by_key(|row| (rank[row.a], rank[row.b]));
    }

    /// Adds the contact of two colliders to the row of its pair of bodies.
    fn add(&mut self, mut contact: Contact) {
        if self.rank[contact.a] > self.rank[contact.b] {
            std::mem::swap(&mut contact.a, &mut contact.b);
            contact.normal = (-Vector3::from(contact.normal)).into();
        }
        match self.rows.iter_mut().find(|row| (row.a, row.b) == (contact.a, contact.b)) {
            None => self.rows.push(contact),
            Some(row) => {
                contact.force += row.force;
                if contact.depth > row.depth {
                    *row = contact;
                } else {
                    row.force = contact.force;
                }
            }
        }
    }

    /// The contacts, in the order of the bodies' names.
    pub(crate) fn rows(&self) -> &[Contact] {
        &self.rows
    }

    /// The normal force between two bodies, N; 0 without contact.
    pub(crate) fn force_between(&self, first: usize, second: usize) -> f64 {
        self.rows
            .iter()
            .find(|row| (row.a, row.b) == (first, second) || (row.a, row.b) == (second, first))
            .map_or(0.0, |row| row.force)
    }
}
