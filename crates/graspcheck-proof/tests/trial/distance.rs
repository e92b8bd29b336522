//! The distance of two convex solids between certified bounds, by Wolfe's algorithm.
//!
//! The cores' distance is the norm of the shortest vector of the difference set `{b - a}`. Wolfe (Finding the nearest
//! point in a polytope, 1976) finds it as an active-set method: at most four of the set's points span a simplex, of which
//! the nearest point to the origin is computed; the support point across it is added until none lies nearer. The vector
//! found bounds the distance from above, as it joins two points; the support point across it from below.

use nalgebra::Vector3;

use super::solid::Placed;

/// The search ends when the bounds are this near, m.
const CLOSE: f64 = 1e-11;
/// And at the latest after so many support points: round bodies need some thirty.
const MOST_STEPS: usize = 500;
/// A corner that is linearly dependent on others to this share adds no dimension.
const DEPENDENT: f64 = 1e-13;

/// Bounds of the signed distance of two solids, m.
#[derive(Clone, Copy, Debug)]
pub struct Distance {
    /// By a slab between them; far below the depth while they overlap.
    pub lower: f64,
    /// By two points, or by a common point that lies so deep.
    pub upper: f64,
    /// A point of each core; the same where the cores meet.
    pub core_points: [Vector3<f64>; 2],
}

#[derive(Clone, Copy)]
struct Corner {
    difference: Vector3<f64>,
    on_a: Vector3<f64>,
    on_b: Vector3<f64>,
    weight: f64,
}

/// The width of the slab across a direction of length 1 from A to B: no more than the signed distance, m.
pub fn slab(a: &Placed, b: &Placed, n: &Vector3<f64>) -> f64 {
    n.dot(&(b.support(&-n) - a.support(n))) - a.solid.radius - b.solid.radius
}

/// The distance as exactly as it can be found.
pub fn distance(a: &Placed, b: &Placed) -> Distance {
    distance_above(a, b, f64::INFINITY)
}

/// As [`distance`], but once it is known to be above `claimed` (m), only to a tenth of what it is more.
pub fn distance_above(a: &Placed, b: &Placed, claimed: f64) -> Distance {
    const SHARE: f64 = 0.1;
    let corner = |towards: &Vector3<f64>| {
        let (on_a, on_b) = (a.support(towards), b.support(&-towards));
        Corner { difference: on_b - on_a, on_a, on_b, weight: 0.0 }
    };
    let radii = a.solid.radius + b.solid.radius;
    let mut simplex = Simplex::new(corner(&(b.origin - a.origin)));
    let mut lower = f64::NEG_INFINITY;
    let mut shortest = simplex.corners()[0].difference;
    for _ in 0..MOST_STEPS {
        let length = shortest.norm();
        if length < CLOSE {
            break;
        }
        let next = corner(&shortest);
        lower = lower.max(next.difference.dot(&shortest) / length);
        let more = lower - radii - claimed;
        let known = simplex.corners().iter().any(|corner| corner.difference == next.difference);
        if length - lower < CLOSE.max(SHARE * more) || known {
            break;
        }
        let before = simplex;
        if !simplex.take(next) || simplex.nearest().norm() >= length {
            simplex = before;
            break;
        }
        shortest = simplex.nearest();
    }
    let core_points = [simplex.sum(|corner| corner.on_a), simplex.sum(|corner| corner.on_b)];
    let apart = (core_points[1] - core_points[0]).norm();
    let upper = if apart < CLOSE {
        // The common point lies in both, and so does a ball about it of the lesser depth in either.
        -core_points.iter().map(|p| a.depth(p) + b.depth(p)).fold(radii, f64::max)
    } else {
        apart - radii
    };
    Distance { lower: lower - radii, upper, core_points }
}

/// At most four corners, and a fifth while it is taken in; weights are not negative and of sum 1.
#[derive(Clone, Copy)]
struct Simplex {
    all: [Corner; 5],
    count: usize,
}

impl Simplex {
    fn new(first: Corner) -> Self {
        Self { all: [Corner { weight: 1.0, ..first }; 5], count: 1 }
    }

    fn corners(&self) -> &[Corner] {
        &self.all[..self.count]
    }

    fn sum(&self, of: impl Fn(&Corner) -> Vector3<f64>) -> Vector3<f64> {
        self.corners().iter().map(|corner| of(corner) * corner.weight).sum()
    }

    fn nearest(&self) -> Vector3<f64> {
        self.sum(|corner| corner.difference)
    }

    /// Takes a corner in, and drops and weighs until the weights make the nearest point of the hull to the origin.
    /// False when that fails by rounding.
    fn take(&mut self, corner: Corner) -> bool {
        if self.count == self.all.len() {
            return false;
        }
        self.all[self.count] = corner;
        self.count += 1;
        while let Some(wanted) = weights_of_flat(self.corners()) {
            let corners = &mut self.all[..self.count];
            if wanted[..self.count].iter().all(|weight| *weight > 0.0) {
                corners.iter_mut().zip(wanted).for_each(|(corner, weight)| corner.weight = weight);
                return true;
            }
            // From the weights at hand, all of which are allowed, as far towards the wanted ones as they stay so.
            let (mut share, mut dropped) = (1.0, 0);
            for (index, (corner, wanted)) in corners.iter().zip(wanted).enumerate() {
                let until = corner.weight / (corner.weight - wanted);
                if wanted <= 0.0 && until <= share {
                    (share, dropped) = (until, index);
                }
            }
            for (corner, wanted) in corners.iter_mut().zip(wanted) {
                corner.weight = (corner.weight + share * (wanted - corner.weight)).max(0.0);
            }
            corners.copy_within(dropped + 1.., dropped);
            self.count -= 1;
            let total: f64 = self.corners().iter().map(|corner| corner.weight).sum();
            self.all[..self.count].iter_mut().for_each(|corner| corner.weight /= total);
        }
        false
    }
}

/// The weights, of sum 1, of the point nearest to the origin in the line, plane or space through the corners, by
/// Gram and Schmidt's orthogonal edges. None when the corners are dependent.
fn weights_of_flat(simplex: &[Corner]) -> Option<[f64; 5]> {
    let last = simplex[simplex.len() - 1].difference;
    let edges = simplex.len() - 1;
    if edges > 3 {
        return None;
    }
    let mut across = [Vector3::zeros(); 3];
    let mut along = [[0.0; 3]; 3];
    for j in 0..edges {
        let edge = simplex[j].difference - last;
        let mut rest = edge;
        // Twice, so that rounding of the first is taken off, too.
        for _ in 0..2 {
            for i in 0..j {
                let share = across[i].dot(&rest);
                along[i][j] += share;
                rest -= across[i] * share;
            }
        }
        let length = rest.norm();
        if length <= DEPENDENT * edge.norm() {
            return None;
        }
        along[j][j] = length;
        across[j] = rest / length;
    }
    let mut weights = [0.0; 5];
    let mut sum = 0.0;
    for i in (0..edges).rev() {
        let known: f64 = (i + 1..edges).map(|j| along[i][j] * weights[j]).sum();
        weights[i] = (-across[i].dot(&last) - known) / along[i][i];
        sum += weights[i];
    }
    weights[edges] = 1.0 - sum;
    Some(weights)
}
