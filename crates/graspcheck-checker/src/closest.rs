//! The distance of two solids, by the algorithm of Gilbert, Johnson and Keerthi (IEEE J. Robotics and
//! Automation 4(2), 1988) in its plainest form.

use crate::{solid::Placed, vector::Vector};

/// The search ends when the bounds are this near to each other, m.
const CLOSE: f64 = 1e-9;

/// … or after this many steps: on curved solids it takes some dozens.
const MOST_STEPS: usize = 200;

/// A lower and an upper bound on the signed distance of two solids, m. Where they overlap, and balls around
/// segments and points are not all of it, the upper one is 0 and the lower one says nothing.
pub(crate) fn distance(a: &Placed, b: &Placed) -> [f64; 2] {
    // Points of the difference B - A, of which the one nearest to the origin is looked for.
    let farthest = |n: Vector| b.farthest(n) - a.farthest(-n);
    let balls = a.solid.ball + b.solid.ball;
    let mut corners = vec![farthest(a.world_from_solid.origin - b.world_from_solid.origin)];
    let mut nearest = corners[0];
    let mut lower = f64::NEG_INFINITY;
    for _ in 0..MOST_STEPS {
        let length = nearest.length();
        if length <= CLOSE {
            break;
        }
        let corner = farthest(-nearest);
        lower = lower.max(corner.dot(nearest) / length);
        if length - lower <= CLOSE || corners.contains(&corner) {
            break;
        }
        corners.push(corner);
        let found = nearest_of_simplex(&mut corners);
        // No step forwards is left by rounding.
        if found.length() >= length {
            break;
        }
        nearest = found;
    }
    [lower - balls, nearest.length() - balls]
}

/// The point nearest to the origin of the hull of up to four points; of them those stay of which it is a mean.
fn nearest_of_simplex(corners: &mut Vec<Vector>) -> Vector {
    let mut best = (f64::INFINITY, Vector::ZERO, Vec::new());
    for subset in 1..1_usize << corners.len() {
        let chosen: Vec<Vector> =
            (0..corners.len()).filter(|i| subset >> i & 1 == 1).map(|i| corners[i]).collect();
        let Some(point) = mean_nearest_to_origin(&chosen) else { continue };
        if point.length() < best.0 {
            best = (point.length(), point, chosen);
        }
    }
    *corners = best.2;
    best.1
}

/// The mean `Σ wᵢ pᵢ` with `Σ wᵢ = 1` that is nearest to the origin; none where a weight is negative or the
/// points do not span.
fn mean_nearest_to_origin(points: &[Vector]) -> Option<Vector> {
    let edges: Vec<Vector> = points[1..].iter().map(|p| *p - points[0]).collect();
    // Across all edges: Σⱼ (eᵢ·eⱼ) wⱼ = -eᵢ·p₀, by elimination.
    let count = edges.len();
    let mut rows: Vec<Vec<f64>> =
        edges.iter().map(|e| edges.iter().map(|f| e.dot(*f)).chain([-e.dot(points[0])]).collect()).collect();
    for i in 0..count {
        let pivot = rows[i].clone();
        // What is left of an edge that lies along the others.
        if pivot[i] <= 1e-14 * edges[i].dot(edges[i]) || pivot[i] <= 0.0 {
            return None;
        }
        for (_, row) in rows.iter_mut().enumerate().filter(|(k, _)| *k != i) {
            let factor = row[i] / pivot[i];
            for (x, y) in row.iter_mut().zip(&pivot) {
                *x -= factor * y;
            }
        }
    }
    let weights: Vec<f64> = (0..count).map(|i| rows[i][count] / rows[i][i]).collect();
    let is_inside = weights.iter().all(|w| *w >= 0.0) && weights.iter().sum::<f64>() <= 1.0;
    is_inside.then(|| edges.iter().zip(weights).fold(points[0], |sum, (e, w)| sum + *e * w))
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;
    use crate::fixture::{at, boxed, pose, read};

    fn bounds(a: (Value, Value), b: (Value, Value)) -> [f64; 2] {
        let (solid_a, solid_b) = (read(a.0), read(b.0));
        let a = Placed { solid: &solid_a, world_from_solid: read(a.1) };
        let b = Placed { solid: &solid_b, world_from_solid: read(b.1) };
        distance(&a, &b)
    }

    fn assert_distance(a: (Value, Value), b: (Value, Value), expected: f64) {
        for [lower, upper] in [bounds(a.clone(), b.clone()), bounds(b, a)] {
            assert!(lower <= expected + 1e-12 && expected - lower < 2e-9, "{lower} is not {expected}");
            assert!(upper >= expected - 1e-12 && upper - expected < 2e-9, "{upper} is not {expected}");
        }
    }

    #[test]
    fn distances_are_those_of_closed_forms() {
        let cube = || boxed(0.1, 0.1, 0.1);
        let ball = |radius: f64| json!({"sphere": {"radius": radius}});
        let rod = || json!({"cylinder": {"radius": 0.1, "half_length": 0.5}});
        let capsule = || json!({"capsule": {"radius": 0.1, "half_length": 0.5}});
        let quarter = std::f64::consts::FRAC_PI_2;
        assert_distance((ball(0.1), at(0.0, 0.0, 0.0)), (ball(0.2), at(0.3, 0.0, 0.4)), 0.2);
        // Balls that overlap, and a point inside of a segment's ball.
        assert_distance((ball(0.3), at(0.0, 0.0, 0.0)), (ball(0.3), at(0.3, 0.0, 0.4)), -0.1);
        // Face to face, edge to edge, corner to face.
        assert_distance((cube(), at(0.0, 0.0, 0.0)), (cube(), at(0.03, 0.01, 0.201)), 0.001);
        assert_distance((cube(), at(0.0, 0.0, 0.0)), (cube(), at(0.5, 0.6, 0.0)), 0.5);
        let tip = 0.1 * 3.0_f64.sqrt();
        let on_its_tip =
            pose([0.0, 0.0, 1.0], [0.5_f64.sqrt(), -0.5_f64.sqrt(), 0.0], (2.0_f64.sqrt()).atan());
        assert_distance((boxed(1.0, 1.0, 0.1), at(0.0, 0.0, 0.0)), (cube(), on_its_tip), 0.9 - tip);
        // Crossed rods and capsules, and a rod above a plate that it stands on askew.
        let crossed = || pose([0.0, 0.3, 0.0], [0.0, 1.0, 0.0], quarter);
        assert_distance((rod(), at(0.0, 0.0, 0.0)), (capsule(), crossed()), 0.1);
        assert_distance((capsule(), at(0.0, 0.0, 0.0)), (capsule(), crossed()), 0.1);
        let askew = pose([0.0, 0.0, 1.0], [1.0, 0.0, 0.0], 0.3);
        let rim = 1.0 - 0.5 * 0.3_f64.cos() - 0.1 * 0.3_f64.sin();
        assert_distance((boxed(1.0, 1.0, 0.1), at(0.0, 0.0, -0.1)), (rod(), askew), rim);
    }

    #[test]
    fn solids_that_touch_or_overlap_are_not_apart() {
        for z in [0.2, 0.199, 0.1, 0.0] {
            let [lower, upper] =
                bounds((boxed(0.1, 0.1, 0.1), at(0.0, 0.0, 0.0)), (boxed(0.5, 0.5, 0.1), at(0.1, 0.0, z)));
            assert!(lower <= 1e-12 && (-1e-12..=1e-9).contains(&upper), "{z}: {lower} {upper}");
        }
    }
}
