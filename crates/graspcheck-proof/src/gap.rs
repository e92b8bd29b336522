//! The certified gap of two convex solids.
//!
//! For **any** direction n of length 1, `g(n) = min_B n·p - max_A n·p` is a lower bound on the distance of A
//! and B: all of A lies on one side of a slab of this width, all of B on the other. The signed distance is
//! the largest g(n) over all n; it is negative when the solids overlap. So a search may *propose* normals as
//! it likes, and closed-form support functions *decide*: an inexact search costs tightness, never soundness.
//!
//! The proposer is the GJK search of parry on the cores. Its dispatcher is not used: `query::distance` of
//! two boxes that share an axis direction is too large (dimforge/parry#431), which is the unsafe side.
//!
//! On the other side, any two points `p_A`, `p_B` of the cores give `g(n) ≤ ‖p_B - p_A‖ - r_A - r_B` for every n,
//! which is an upper bound on the signed distance.

use nalgebra::{Matrix3, Vector3};
use parry3d::{
    math,
    query::gjk::{self, CsoPoint, GJKResult, VoronoiSimplex},
};

use crate::solid::{Core, Placed, Solid};

/// Subtracted from every gap, m: poses and support functions of an arm that reaches 8 m are rounded by less
/// than 1e-13 m, and exact joint ranges by less than 1e-12 rad.
pub const GAP_SLACK: f64 = 1e-9;

/// The narrowest difference between the bounds of a distance that may be asked for, m: more than the search
/// on polytopes leaves, and the slack.
pub const FINEST_TOLERANCE: f64 = 1e-7;

/// A certified lower bound on the signed distance of A and B, m, by the slab across `n` (of length 1, from A
/// to B). Where a solid is farther out than [`LARGEST_COORDINATE`](crate::solid::LARGEST_COORDINATE) it is minus infinity, and NaN where a
/// number is: no comparison then proves anything.
#[must_use]
pub fn gap(a: &Placed, b: &Placed, n: &Vector3<f64>) -> f64 {
    if !(a.is_near() && b.is_near()) {
        return f64::NEG_INFINITY;
    }
    n.dot(&(b.place.center - a.place.center)) - a.reach(n) - b.reach(&-n) - GAP_SLACK
}

/// A direction of length 1 from A to B to begin with, good when one of them is small or far: two steps of
/// alternating projection between the cores.
#[must_use]
pub fn first_normal(a: &Placed, b: &Placed) -> Vector3<f64> {
    let on_a = a.core_nearest(&b.core_nearest(&a.place.center));
    let across = b.core_nearest(&on_a) - on_a;
    let between = || (b.place.center - a.place.center).try_normalize(1e-12);
    across.try_normalize(1e-9).or_else(between).unwrap_or_else(Vector3::z)
}

/// What is known of the signed distance of two solids A and B.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separation {
    /// Lower bound, m: the gap across `normal`.
    pub lower: f64,
    /// Upper bound, m, by `points`.
    pub upper: f64,
    /// Direction of length 1 from A to B, in the world.
    pub normal: Vector3<f64>,
    /// A point of A and a point of B, in the world, m. While the solids are apart they are as far from each
    /// other as `upper` says.
    pub points: [Vector3<f64>; 2],
}

/// Both bounds on the signed distance of A and B; `hint` is a normal that was good a little earlier. When
/// the bounds differ by more than `tolerance` (m, at least [`FINEST_TOLERANCE`]), more normals are proposed.
/// They may still differ by more: for hulls that overlap, or overlapping curved solids.
///
/// None when it cannot be computed: a coordinate is not finite or larger than [`LARGEST_COORDINATE`](crate::solid::LARGEST_COORDINATE), or the
/// search failed. That means *not checked*, never *free*.
#[must_use]
pub fn separation(a: &Placed, b: &Placed, hint: Option<&Vector3<f64>>, tolerance: f64) -> Option<Separation> {
    if !(is_sane(a) && is_sane(b)) {
        return None;
    }
    let between = b.place.center - a.place.center;
    let start = hint.copied().unwrap_or(between);
    let start = if start.norm_squared() > 0.0 { start } else { Vector3::z() };
    let [mut core_a, mut core_b, proposed] = core_points(a, b, &start)?;

    let mut best = Best { a, b, lower: f64::NEG_INFINITY, normal: Vector3::z() };
    best.propose(&(core_b - core_a));
    best.propose(&proposed);
    let upper =
        |on_a: Vector3<f64>, on_b: Vector3<f64>| (on_b - on_a).norm() - a.solid.radius() - b.solid.radius();
    let tolerance = tolerance.max(FINEST_TOLERANCE);
    if best.lower < upper(core_a, core_b) - tolerance {
        draw_together(a, b, &mut core_a, &mut core_b);
        best.propose(&(core_b - core_a));
        best.propose(&start);
        best.propose(&between);
        best.propose_features();
    }
    let upper = upper(core_a, core_b);
    if best.lower < upper - tolerance {
        best.polish();
    }
    let normal = best.normal;
    let towards = (core_b - core_a).try_normalize(1e-12).unwrap_or(normal);
    let points = [core_a + towards * a.solid.radius(), core_b - towards * b.solid.radius()];
    let known = best.lower.is_finite() && upper.is_finite() && best.lower <= upper;
    known.then_some(Separation { lower: best.lower, upper, normal, points })
}

/// Draws a point of the core of A and one of B nearer to each other by alternating projection. The search
/// stops within some 1e-5 m on curved cores.
fn draw_together(a: &Placed, b: &Placed, on_a: &mut Vector3<f64>, on_b: &mut Vector3<f64>) {
    const STEPS: usize = 30;
    let is_hull = |solid: &Placed| matches!(solid.solid.core(), Core::Points { .. });
    for _ in 0..STEPS {
        if !is_hull(a) {
            *on_a = a.core_nearest(on_b);
        }
        if !is_hull(b) {
            *on_b = b.core_nearest(on_a);
        }
    }
}

/// A point that lies in both solids at least as deep as they then provably overlap, when that is at least
/// `depth` (m, positive): the signed distance is at most `-depth`.
///
/// If A and B, shrunken by `α` and `β` with `α + β = depth`, still share a point x, then balls of these radii
/// about x lie in A and in B, and `g(n) ≤ -α - β` for every n.
#[must_use]
pub fn overlap_of_at_least(a: &Placed, b: &Placed, depth: f64) -> Option<Vector3<f64>> {
    if !(is_sane(a) && is_sane(b)) {
        return None;
    }
    // Rounding of the common point is paid for by shrinking a little more.
    let depth = depth + GAP_SLACK;
    [0.5, 0.0, 1.0].iter().find_map(|share| {
        let shrink = |solid: &Solid, by: f64| solid.eroded(by);
        let (solid_a, solid_b) = (shrink(a.solid, share * depth)?, shrink(b.solid, (1.0 - share) * depth)?);
        let (a, b) = (Placed { solid: &solid_a, place: a.place }, Placed { solid: &solid_b, place: b.place });
        let between = b.place.center - a.place.center;
        let start = if between.norm_squared() > 0.0 { between } else { Vector3::z() };
        let [core_a, core_b, _] = core_points(&a, &b, &start)?;
        let (distance, radii) = ((core_b - core_a).norm(), solid_a.radius() + solid_b.radius());
        // A point between the cores that is no farther from each of them than its ball reaches.
        let share = if radii > 0.0 { solid_a.radius() / radii } else { 0.5 };
        (distance - radii < 0.5 * GAP_SLACK).then(|| core_a.lerp(&core_b, share))
    })
}

/// Whether the search may be called: it panics on numbers that are not finite.
fn is_sane(solid: &Placed) -> bool {
    solid.is_near() && solid.place.center.iter().chain(&solid.place.rotation).all(|x| x.is_finite())
}

/// A point of the core of A and one of the core of B, as close as the search found them (coincident when
/// the cores intersect), and the normal that it proposes. None when it fails.
fn core_points(a: &Placed, b: &Placed, start: &Vector3<f64>) -> Option<[Vector3<f64>; 3]> {
    let identity = math::Pose::IDENTITY;
    let mut simplex = VoronoiSimplex::new();
    let start = math::Vector::new(start.x, start.y, start.z);
    simplex.reset(CsoPoint::from_shapes(&identity, a, b, start));
    let vector = |v: math::Vector| Vector3::new(v.x, v.y, v.z);
    match gjk::closest_points(&identity, a, b, f64::MAX, true, &mut simplex) {
        GJKResult::ClosestPoints(on_a, on_b, normal) => Some([vector(on_a), vector(on_b), vector(normal)]),
        GJKResult::Intersection => {
            let weights = weights_of_origin(&simplex);
            let mut points = [math::Vector::ZERO; 2];
            for (i, weight) in weights.iter().enumerate().take(simplex.dimension() + 1) {
                points[0] += simplex.point(i).orig1 * *weight;
                points[1] += simplex.point(i).orig2 * *weight;
            }
            Some([vector(points[0]), vector(points[1]), Vector3::zeros()])
        }
        GJKResult::Proximity(_) | GJKResult::NoIntersection(_) => None,
    }
}

/// The weights, not negative and of sum 1, with which the vertices of the last simplex of an intersection
/// make the origin, or come close to it.
fn weights_of_origin(simplex: &VoronoiSimplex) -> [f64; 4] {
    let mut weights = [0.0; 4];
    if simplex.dimension() < 3 {
        for (i, weight) in weights.iter_mut().enumerate().take(simplex.dimension() + 1) {
            *weight = simplex.proj_coord(i);
        }
    } else {
        // The search leaves the weights of a full tetrahedron open: Σ wᵢ vᵢ = 0 with Σ wᵢ = 1.
        let vertex = |i: usize| {
            let v = simplex.point(i).point;
            Vector3::new(v.x, v.y, v.z)
        };
        let last = vertex(3);
        let edges = Matrix3::from_columns(&[vertex(0) - last, vertex(1) - last, vertex(2) - last]);
        let solved = edges.lu().solve(&-last).unwrap_or_else(Vector3::zeros);
        weights = [solved.x, solved.y, solved.z, 1.0 - solved.sum()];
    }
    let sum: f64 = weights.iter().map(|w| w.max(0.0)).sum();
    weights.map(|w| w.max(0.0) / sum)
}

/// The best normal so far.
struct Best<'a> {
    a: &'a Placed<'a>,
    b: &'a Placed<'a>,
    lower: f64,
    normal: Vector3<f64>,
}

impl Best<'_> {
    /// Takes this direction if its gap is wider; a zero or non-finite one is passed over.
    fn propose(&mut self, direction: &Vector3<f64>) {
        let length = direction.norm();
        // Shorter vectors are differences of nearly equal points, with no direction left in them.
        if !(length.is_finite() && length > 1e-12) {
            return;
        }
        let normal = direction / length;
        let lower = gap(self.a, self.b, &normal);
        if lower > self.lower {
            self.lower = lower;
            self.normal = normal;
        }
    }

    /// Proposes what separates polytopes that touch or overlap (the separating axis test): normals of faces
    /// and the products of edges; of a round solid its axis and the direction across it.
    fn propose_features(&mut self) {
        let between = self.b.place.center - self.a.place.center;
        let (axes_a, axes_b) = (axes(self.a), axes(self.b));
        for axis in axes_a.iter().chain(&axes_b).flatten() {
            self.propose_towards(axis, &between);
        }
        for solid in [self.a, self.b] {
            if matches!(solid.solid.core(), Core::Cylinder { .. } | Core::Segment { .. }) {
                let axis = solid.place.rotation.column(2).into_owned();
                self.propose(&(between - axis * axis.dot(&between)));
            }
        }
        for a in axes_a.iter().flatten() {
            for b in axes_b.iter().flatten() {
                self.propose_towards(&a.cross(b), &between);
            }
        }
    }

    /// Proposes a direction with the sign that points from A to B.
    fn propose_towards(&mut self, direction: &Vector3<f64>, between: &Vector3<f64>) {
        self.propose(&(direction * direction.dot(between).signum()));
    }

    /// Turns the normal while that widens the gap (a pattern search on the sphere; g is concave in n, so
    /// that there is one maximum).
    fn polish(&mut self) {
        const FIRST_TURN: f64 = 0.1;
        const LAST_TURN: f64 = 1e-7;
        const MOST_ROUNDS: usize = 200;
        let mut turn = FIRST_TURN;
        for _ in 0..MOST_ROUNDS {
            if turn < LAST_TURN {
                break;
            }
            let n = self.normal;
            let side = n.cross(&if n.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() }).normalize();
            let up = n.cross(&side);
            let before = self.lower;
            for way in [side, -side, up, -up, side + up, side - up, up - side, -side - up] {
                self.propose(&(n + way * turn));
            }
            let improved = self.lower > before;
            turn *= if improved { 1.0 } else { 0.5 };
        }
    }
}

/// Directions of a solid's edges in the world, which for a box are its face normals too.
fn axes(solid: &Placed) -> [Option<Vector3<f64>>; 3] {
    let column = |i: usize| Some(solid.place.rotation.column(i).into_owned());
    match solid.solid.core() {
        Core::Box { .. } => [column(0), column(1), column(2)],
        Core::Cylinder { .. } | Core::Segment { .. } => [column(2), None, None],
        Core::Point | Core::Points { .. } => [None; 3],
    }
}

#[cfg(test)]
mod tests {
    use graspcheck_model::Pose;
    use parry3d::{query, shape::Cuboid};

    use super::*;
    use crate::{
        fixtures::Draw,
        solid::{
            LARGEST_COORDINATE, Place,
            tests::{cores, point_of},
        },
    };

    fn random_place(draw: &mut Draw, half: f64) -> Place {
        let mut vector = |half: f64| Vector3::from_fn(|_, _| draw.between(-half, half));
        Place::from(&Pose::new(vector(half), vector(std::f64::consts::PI)))
    }

    fn cuboid(x: f64, y: f64, z: f64) -> Solid {
        Solid::new(Core::Box { half_extents: Vector3::new(x, y, z) }, 0.0)
    }

    /// Random points of both solids are never nearer than the lower bound, the witness points are as far
    /// apart as the upper bound, and the bounds meet: together they are the distance. One is proved by
    /// support functions and one by points, so that neither can lean on the search.
    #[test]
    fn bounds_enclose_the_distance_of_all_kinds_of_solids_and_meet() {
        let mut draw = Draw(11);
        let (mut apart, mut loosest) = (0, 0.0_f64);
        for _ in 0..150 {
            for (core_a, core_b) in
                cores(&mut draw).iter().flat_map(|a| cores(&mut Draw(5)).map(|b| (a.clone(), b)))
            {
                let solid_a = Solid::new(core_a, draw.between(0.0, 0.05));
                let solid_b = Solid::new(core_b, draw.between(0.0, 0.05));
                let a = Placed { solid: &solid_a, place: random_place(&mut draw, 0.5) };
                let b = Placed { solid: &solid_b, place: random_place(&mut draw, 0.5) };
                let known = separation(&a, &b, None, 0.0).expect("the search ends");
                assert!((known.normal.norm() - 1.0).abs() < 1e-12);
                let radii = solid_a.radius() + solid_b.radius();
                for _ in 0..20 {
                    let world = |s: &Placed, p: Vector3<f64>| s.place.center + s.place.rotation * p;
                    let p = world(&a, point_of(solid_a.core(), &mut draw));
                    let q = world(&b, point_of(solid_b.core(), &mut draw));
                    assert!((q - p).norm() - radii >= known.lower, "{known:?}");
                }
                if known.upper > 1e-9 {
                    apart += 1;
                    let [p, q] = known.points;
                    assert!(((q - p).norm() - known.upper).abs() < 1e-9, "{known:?}");
                    loosest = loosest.max(known.upper - known.lower);
                }
            }
        }
        assert!(apart > 500, "{apart}");
        assert!(loosest < 5e-7, "{loosest}");
    }

    fn parry_pose(pose: &Pose) -> math::Pose {
        let (t, r) = (pose.translation.vector, pose.rotation.scaled_axis());
        math::Pose::new(math::Vector::new(t.x, t.y, t.z), math::Vector::new(r.x, r.y, r.z))
    }

    /// Boxes as parry's shapes, by its own closest points (not its distance), as an independent witness.
    #[test]
    fn boxes_agree_with_parry_and_with_alternating_projection() {
        let mut draw = Draw(12);
        for _ in 0..300 {
            let mut half = || draw.between(0.05, 0.3);
            let (ha, hb) = (Vector3::new(half(), half(), half()), Vector3::new(half(), half(), half()));
            let (solid_a, solid_b) = (cuboid(ha.x, ha.y, ha.z), cuboid(hb.x, hb.y, hb.z));
            let pose = |draw: &mut Draw| {
                let mut vector = |half: f64| Vector3::from_fn(|_, _| draw.between(-half, half));
                Pose::new(vector(0.6), vector(3.0))
            };
            let (pose_a, pose_b) = (pose(&mut draw), pose(&mut draw));
            let a = Placed { solid: &solid_a, place: Place::from(&pose_a) };
            let b = Placed { solid: &solid_b, place: Place::from(&pose_b) };
            let known = separation(&a, &b, None, 0.0).unwrap();
            let parry = |h: Vector3<f64>| Cuboid::new(math::Vector::new(h.x, h.y, h.z));
            let found = query::closest_points(
                &parry_pose(&pose_a),
                &parry(ha),
                &parry_pose(&pose_b),
                &parry(hb),
                f64::MAX,
            );
            match found.unwrap() {
                query::ClosestPoints::WithinMargin(p, q) => {
                    assert!(((q - p).length() - known.upper).abs() < 1e-8, "{known:?}");
                    let mut on_a = a.place.center;
                    let mut on_b = b.place.center;
                    for _ in 0..20_000 {
                        on_b = b.core_nearest(&on_a);
                        on_a = a.core_nearest(&on_b);
                    }
                    let projected = (on_b - on_a).norm();
                    assert!(
                        projected >= known.lower && projected < known.upper + 1e-4,
                        "{known:?} {projected}"
                    );
                }
                _ => assert!(known.upper <= 1e-12, "{known:?}"),
            }
        }
    }

    /// The separating axis theorem gives the exact depth of overlapping boxes (Ericson, *Real-Time
    /// Collision Detection*, section 4.4.1): the least overlap over 15 axes.
    #[test]
    fn overlapping_boxes_have_the_depth_of_the_separating_axis_test() {
        let mut draw = Draw(13);
        let mut overlapping = 0;
        for _ in 0..2000 {
            let mut half = || draw.between(0.05, 0.3);
            let (ha, hb) = (Vector3::new(half(), half(), half()), Vector3::new(half(), half(), half()));
            let (solid_a, solid_b) = (cuboid(ha.x, ha.y, ha.z), cuboid(hb.x, hb.y, hb.z));
            let a = Placed { solid: &solid_a, place: random_place(&mut draw, 0.3) };
            let b = Placed { solid: &solid_b, place: random_place(&mut draw, 0.3) };
            let known = separation(&a, &b, None, 0.0).unwrap();
            if known.upper > 1e-9 {
                continue;
            }
            overlapping += 1;
            let corners = |h: Vector3<f64>, place: Place| {
                (0..8).map(move |i| {
                    let sign = |bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
                    place.center + place.rotation * Vector3::new(h.x * sign(0), h.y * sign(1), h.z * sign(2))
                })
            };
            let column = |place: &Place, i: usize| place.rotation.column(i).into_owned();
            let mut axes: Vec<Vector3<f64>> = (0..3).map(|i| column(&a.place, i)).collect();
            axes.extend((0..3).map(|i| column(&b.place, i)));
            for i in 0..3 {
                axes.extend((0..3).map(|j| column(&a.place, i).cross(&column(&b.place, j))));
            }
            let depth = axes
                .iter()
                .filter_map(|axis| axis.try_normalize(1e-6))
                .map(|n| {
                    let range = |h, place| {
                        corners(h, place).map(|p| p.dot(&n)).fold((f64::MAX, f64::MIN), |(low, high), x| {
                            (f64::min(low, x), f64::max(high, x))
                        })
                    };
                    let ((la, ua), (lb, ub)) = (range(ha, a.place), range(hb, b.place));
                    (ua - lb).min(ub - la)
                })
                .fold(f64::MAX, f64::min);
            assert!((known.lower + depth).abs() < 1e-8, "{known:?} {depth}");
            // What is shown to overlap is never deeper than it is.
            for share in [0.3, 0.9, 1.01, 2.0] {
                let shown = overlap_of_at_least(&a, &b, share * depth);
                assert!(share <= 1.0 || shown.is_none(), "{share} of {depth}");
            }
        }
        assert!(overlapping > 300, "{overlapping}");
    }

    #[test]
    fn face_to_face_overlap_is_shown_to_its_depth() {
        let (solid_a, solid_b) = (cuboid(0.1, 0.1, 0.1), cuboid(0.2, 0.2, 0.05));
        let place = |z| Place::from(&Pose::translation(0.0, 0.0, z));
        let a = Placed { solid: &solid_a, place: place(0.149) };
        let b = Placed { solid: &solid_b, place: place(0.0) };
        assert!(overlap_of_at_least(&a, &b, 0.000_99).is_some());
        assert!(overlap_of_at_least(&a, &b, 0.001_01).is_none());
    }

    /// The common point lies in both solids with a ball of its own in each, and the two balls together are as
    /// thick as asked for: no direction separates the solids by more than `-depth`.
    #[test]
    fn a_common_point_lies_in_both_solids_of_any_kind() {
        let mut draw = Draw(14);
        let mut shown = 0;
        for (kind_a, kind_b) in (0..200).flat_map(|_| (0..5).flat_map(|a| (0..5).map(move |b| (a, b)))) {
            let solid_a = Solid::new(cores(&mut draw)[kind_a].clone(), draw.between(0.01, 0.1));
            let solid_b = Solid::new(cores(&mut draw)[kind_b].clone(), draw.between(0.0, 0.01));
            let a = Placed { solid: &solid_a, place: random_place(&mut draw, 0.2) };
            let b = Placed { solid: &solid_b, place: random_place(&mut draw, 0.2) };
            let depth = draw.between(0.0, 0.03);
            let Some(point) = overlap_of_at_least(&a, &b, depth) else { continue };
            shown += 1;
            for _ in 0..50 {
                let n = Vector3::from_fn(|_, _| draw.between(-1.0, 1.0)).normalize();
                // How far the faces of A and B across n are beyond the point.
                let room =
                    |solid: &Placed, n: &Vector3<f64>| solid.reach(n) - n.dot(&(point - solid.place.center));
                let (in_a, in_b) = (room(&a, &n), room(&b, &-n));
                assert!(in_a >= -1e-12 && in_b >= -1e-12, "{kind_a} {kind_b}: {in_a} {in_b}");
                assert!(in_a + in_b >= depth, "{kind_a} {kind_b}: {in_a} {in_b} {depth}");
            }
        }
        assert!(shown > 1500, "{shown}");
    }

    /// A ball of 50 mm whose middle is 40 mm above a box: half way between the cores is outside of the box.
    #[test]
    fn the_common_point_of_a_ball_and_a_box_is_in_the_box() {
        let (solid_a, solid_b) = (cuboid(0.1, 0.1, 0.1), Solid::new(Core::Point, 0.05));
        let place = |z| Place::from(&Pose::translation(0.0, 0.0, z));
        let a = Placed { solid: &solid_a, place: place(0.0) };
        let b = Placed { solid: &solid_b, place: place(0.14) };
        for (a, b) in [(&a, &b), (&b, &a)] {
            let point = overlap_of_at_least(a, b, 0.005).expect("they overlap by 10 mm");
            assert!(point.z <= 0.1 + 1e-12 && point.z >= 0.09 - 1e-12, "{point}");
        }
    }

    /// Two boxes that differ by a yaw only: parry's `query::distance` says 0.150 m (dimforge/parry#431).
    #[test]
    fn yawed_boxes_that_parry_calls_far_are_near() {
        let (solid_a, solid_b) =
            (cuboid(0.2125, 0.06, 0.05), cuboid(0.142_175_089_331_625_18, 0.140_950_424_463_209_27, 0.3));
        let pose_a = Pose::new(Vector3::new(0.0, 0.0, 0.1), Vector3::z() * 3.8198);
        let pose_b = Pose::translation(-0.017_969_746_352_588_346, 0.335_720_742_499_299_95, 0.0);
        let a = Placed { solid: &solid_a, place: Place::from(&pose_a) };
        let b = Placed { solid: &solid_b, place: Place::from(&pose_b) };
        let known = separation(&a, &b, None, 0.0).unwrap();
        assert!(known.upper - known.lower < 2e-9 && (known.upper - 0.015_17).abs() < 1e-5, "{known:?}");
    }

    #[test]
    fn what_is_not_finite_is_not_checked() {
        let solid = cuboid(0.1, 0.1, 0.1);
        let sane = Placed { solid: &solid, place: Place::from(&Pose::identity()) };
        for x in [f64::NAN, f64::INFINITY, 2.0 * LARGEST_COORDINATE] {
            let place = Place { center: Vector3::new(x, 0.0, 0.0), ..sane.place };
            assert_eq!(separation(&sane, &Placed { solid: &solid, place }, None, 0.0), None);
        }
        let coincident = separation(&sane, &sane, None, 0.0).unwrap();
        assert!((coincident.lower + 0.2).abs() < 1e-8 && coincident.upper <= 1e-12, "{coincident:?}");
    }
}
