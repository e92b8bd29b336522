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

/// Farther from the world's origin than this, m, rounding is no longer far below [`GAP_SLACK`], and nothing
/// is certified.
pub const LARGEST_COORDINATE: f64 = 1e4;

/// The narrowest difference between the bounds of a distance that may be asked for, m: more than the search
/// on polytopes leaves, and the slack.
pub const FINEST_TOLERANCE: f64 = 1e-7;

/// A certified lower bound on the signed distance of A and B, m, by the slab across `n` (of length 1, from A
/// to B).
#[must_use]
pub fn gap(a: &Placed, b: &Placed, n: &Vector3<f64>) -> f64 {
    n.dot(&(b.place.center - a.place.center)) - a.reach(n) - b.reach(&-n) - GAP_SLACK
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
/// None when it cannot be computed: a coordinate is not finite or larger than [`LARGEST_COORDINATE`], or the
/// search failed. That means *not checked*, never *free*.
#[must_use]
pub fn separation(
    a: &Placed,
    b: &Placed,
    hint: Option<&Vector3<f64>>,
    tolerance: f64,
) -> Option<Separation> {
    if !(is_sane(a) && is_sane(b)) {
        return None;
    }
    let between = b.place.center - a.place.center;
    let start = hint.copied().unwrap_or(between);
    let start = if start.norm_squared() > 0.0 { start } else { Vector3::z() };
    let [core_a, core_b, proposed] = core_points(a, b, &start)?;
    let across = core_b - core_a;
    let distance = across.norm();

    let mut best = Best { a, b, lower: f64::NEG_INFINITY, normal: Vector3::z() };
    best.propose(&across);
    best.propose(&proposed);
    let upper = distance - a.solid.radius() - b.solid.radius();
    let tolerance = tolerance.max(FINEST_TOLERANCE);
    if best.lower < upper - tolerance {
        best.propose(&start);
        best.propose(&between);
        best.propose_features();
    }
    if best.lower < upper - tolerance {
        best.polish();
    }
    let normal = best.normal;
    let points = [core_a + normal * a.solid.radius(), core_b - normal * b.solid.radius()];
    let known = best.lower.is_finite() && upper.is_finite() && best.lower <= upper;
    known.then_some(Separation { lower: best.lower, upper, normal, points })
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
        let apart = (core_b - core_a).norm() - solid_a.radius() - solid_b.radius();
        (apart < 0.5 * GAP_SLACK).then(|| 0.5 * (core_a + core_b))
    })
}

/// Whether rounding is far below the slack.
fn is_sane(solid: &Placed) -> bool {
    let place = &solid.place;
    place.center.iter().all(|x| x.abs() + solid.solid.bounding_radius() < LARGEST_COORDINATE)
        && place.rotation.iter().all(|x| x.is_finite())
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
    fn propose(&mut self, direction: &Vector3<f64>) -> bool {
        let length = direction.norm();
        // Shorter vectors are differences of nearly equal points, with no direction left in them.
        if !(length.is_finite() && length > 1e-12) {
            return false;
        }
        let normal = direction / length;
        let lower = gap(self.a, self.b, &normal);
        let better = lower > self.lower;
        if better {
            self.lower = lower;
            self.normal = normal;
        }
        better
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
            let improved = [side, -side, up, -up, side + up, side - up, up - side, -side - up]
                .iter()
                .fold(false, |any, way| self.propose(&(n + way * turn)) || any);
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
        Core::Point | Core::Points(_) => [None; 3],
    }
}
