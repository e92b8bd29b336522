//! The object of an executed motion in the frame of what carries it: the hand while it is held, else the
//! world.
//!
//! Between two rows its origin follows the cubic Hermite piece through the logged positions and velocities,
//! and its rotation the cubic of cumulative form through the logged rotations and angular velocities (Kim,
//! Kim and Shin, *A general construction scheme for unit quaternion curves*, SIGGRAPH 1995):
//! `R(t) = R_i exp(β₁ w₁) exp(β₂ w₂) exp(β₃ w₃)` with `w₁ = h ω_i / 3`, `w₃ = h ω_(i+1) / 3`, `w₂` such that the
//! piece ends in `R_(i+1)`, and β rising from 0 to 1.
//!
//! How far the object goes from some pose is measured by how far any point within the object's radius r of
//! its origin goes: `d(A, B) = ‖p_A - p_B‖ + 2 r sin(θ / 2)`, with θ the angle between both. A tree over the
//! pieces bounds that for any run of them.

use graspcheck_model::Pose;
use nalgebra::{UnitQuaternion, Vector3};

use crate::logged_motion::{BodyState, piece_at};

/// The motion of the object against its carrier over a run of rows.
#[derive(Clone, Debug)]
pub(crate) struct Carried {
    /// Of the rows, s.
    times: Vec<f64>,
    /// In the carrier's frame, one a row.
    states: Vec<BodyState>,
    /// Bounds the distance of the object's points from its origin, m.
    radius: f64,
    /// Node i has the children 2i and 2i + 1; the leaves, one a piece, begin at half of the length.
    nodes: Vec<Node>,
}

/// A run of pieces: no pose of them is farther than `reach` from that of a row.
#[derive(Clone, Copy, Debug)]
struct Node {
    row: usize,
    /// m.
    reach: f64,
}

impl Carried {
    /// The motion through at least two states, in the frame of the carrier.
    pub(crate) fn new(times: Vec<f64>, states: Vec<BodyState>, radius: f64) -> Self {
        let count = times.len() - 1;
        let mut carried = Self { times, states, radius, nodes: vec![Node { row: 0, reach: 0.0 }; count] };
        for row in 0..count {
            let reach = carried.piece(row).reach(radius);
            carried.nodes.push(Node { row, reach });
        }
        for node in (1..count).rev() {
            let [left, right] = [2 * node, 2 * node + 1].map(|child| carried.nodes[child]);
            // The pose of the right one's first row lies between both, and is as near to either as may be.
            let row = right.row;
            let to_left = carried.apart(&carried.states[row].world_from_body, left.row) + left.reach;
            carried.nodes[node] = Node { row, reach: to_left.max(right.reach) };
        }
        carried
    }

    /// A pose that the object has at an instant, s.
    pub(crate) fn pose_at(&self, time: f64) -> Pose {
        let piece = piece_at(&self.times, time);
        let share = (time - self.times[piece]) / (self.times[piece + 1] - self.times[piece]);
        self.piece(piece).pose(share.clamp(0.0, 1.0))
    }

    /// A bound on how far any point of the object is between two instants (s) from where a pose has it, m.
    pub(crate) fn deviation(&self, pose: &Pose, start: f64, end: f64) -> f64 {
        let (first, last) = (piece_at(&self.times, start), piece_at(&self.times, end));
        if first == last {
            return self.deviation_in(first, pose, start, end);
        }
        let ends = [
            self.deviation_in(first, pose, start, self.times[first + 1]),
            self.deviation_in(last, pose, self.times[last], end),
        ];
        let count = self.nodes.len() / 2;
        let (mut left, mut right, mut most) = (first + 1 + count, last + count, ends[0].max(ends[1]));
        let mut take = |node: Node| most = most.max(self.apart(pose, node.row) + node.reach);
        while left < right {
            if left & 1 == 1 {
                take(self.nodes[left]);
                left += 1;
            }
            if right & 1 == 1 {
                right -= 1;
                take(self.nodes[right]);
            }
            (left, right) = (left / 2, right / 2);
        }
        most
    }

    /// The same on a part of one piece: from the middle of the part the object goes on for half of it.
    fn deviation_in(&self, piece: usize, pose: &Pose, start: f64, end: f64) -> f64 {
        let length = self.times[piece + 1] - self.times[piece];
        let curve = self.piece(piece);
        let middle = curve.pose((0.5 * (start + end) - self.times[piece]) / length);
        distance(pose, &middle, self.radius) + 0.5 * (end - start) / length * curve.fastest(self.radius)
    }

    fn apart(&self, pose: &Pose, row: usize) -> f64 {
        distance(pose, &self.states[row].world_from_body, self.radius)
    }

    fn piece(&self, row: usize) -> Piece {
        Piece::new(&self.states[row], &self.states[row + 1], self.times[row + 1] - self.times[row])
    }
}

/// How far any point within `radius` (m) of the origin is between where two poses have it, m, at most.
pub(crate) fn distance(a: &Pose, b: &Pose, radius: f64) -> f64 {
    (a.translation.vector - b.translation.vector).norm()
        + radius * chord(&(a.rotation.inverse() * b.rotation))
}

/// `2 sin(θ / 2)` of a rotation.
fn chord(rotation: &UnitQuaternion<f64>) -> f64 {
    2.0 * rotation.imag().norm()
}

/// The motion between two rows, over shares of time from 0 to 1.
struct Piece {
    /// Bézier points of the origin, m.
    points: [Vector3<f64>; 4],
    start: UnitQuaternion<f64>,
    /// The turns of the cumulative form, rad.
    turns: [Vector3<f64>; 3],
}

impl Piece {
    fn new(from: &BodyState, to: &BodyState, length: f64) -> Self {
        let (a, b) = (&from.world_from_body, &to.world_from_body);
        let [p, q] = [a, b].map(|pose| pose.translation.vector);
        let third = length / 3.0;
        let points = [p, p + from.linear * third, q - to.linear * third, q];
        let first = a.rotation.inverse() * (from.angular * third);
        let last = b.rotation.inverse() * (to.angular * third);
        let whole = a.rotation.inverse() * b.rotation;
        let between =
            UnitQuaternion::from_scaled_axis(-first) * whole * UnitQuaternion::from_scaled_axis(-last);
        Self { points, start: a.rotation, turns: [first, between.scaled_axis(), last] }
    }

    fn pose(&self, share: f64) -> Pose {
        let (s, r) = (share, 1.0 - share);
        let weights = [r * r * r, 3.0 * r * r * s, 3.0 * r * s * s, s * s * s];
        let origin: Vector3<f64> =
            self.points.iter().zip(weights).map(|(point, weight)| point * weight).sum();
        let risen = [1.0 - weights[0], weights[2] + weights[3], weights[3]];
        let turned = self.turns.iter().zip(risen).fold(self.start, |rotation, (turn, risen)| {
            rotation * UnitQuaternion::from_scaled_axis(turn * risen)
        });
        Pose::from_parts(origin.into(), turned)
    }

    /// How far any point goes from where it is at the start, m, at most: the origin stays in the hull of the
    /// Bézier points, and the three turns add up.
    fn reach(&self, radius: f64) -> f64 {
        let origin = self.points.iter().map(|point| (point - self.points[0]).norm()).fold(0.0, f64::max);
        let angle: f64 = self.turns.iter().map(Vector3::norm).sum();
        origin + 2.0 * radius * (0.5 * angle.min(std::f64::consts::PI)).sin()
    }

    /// How far any point would go in the whole piece at its greatest speed, m: derivatives of both curves
    /// are means of three times the differences of points and of three times the turns.
    fn fastest(&self, radius: f64) -> f64 {
        let step = self.points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).fold(0.0, f64::max);
        let turn = self.turns.iter().map(Vector3::norm).fold(0.0, f64::max);
        3.0 * (step + radius * turn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::Draw;

    fn states(draw: &mut Draw, count: usize) -> (Vec<f64>, Vec<BodyState>) {
        let mut vector = |size: f64| Vector3::from_fn(|_, _| draw.between(-size, size));
        let state = |_| BodyState {
            world_from_body: Pose::new(vector(0.1), vector(0.5)),
            linear: vector(3.0),
            angular: vector(10.0),
        };
        ((0..count).map(|row| 0.01 * row as f64).collect(), (0..count).map(state).collect())
    }

    #[test]
    fn the_curve_meets_poses_and_velocities_of_the_rows() {
        let mut draw = Draw(11);
        let (times, states) = states(&mut draw, 20);
        let carried = Carried::new(times.clone(), states.clone(), 0.05);
        for (row, state) in states.iter().enumerate() {
            let here = carried.pose_at(times[row]);
            assert!(distance(&here, &state.world_from_body, 0.05) < 1e-12);
            if row + 1 < states.len() {
                let step = 1e-7;
                let next = carried.pose_at(times[row] + step);
                let linear = (next.translation.vector - here.translation.vector) / step;
                let angular = (next.rotation * here.rotation.inverse()).scaled_axis() / step;
                assert!((linear - state.linear).norm() < 1e-2, "{linear} {}", state.linear);
                assert!((angular - state.angular).norm() < 1e-2, "{angular} {}", state.angular);
            }
        }
    }

    #[test]
    fn no_point_goes_farther_than_the_deviation() {
        let mut draw = Draw(12);
        let radius = 0.05;
        for _ in 0..300 {
            let (times, states) = states(&mut draw, 17);
            let carried = Carried::new(times, states, radius);
            let (from, to) = (draw.between(0.0, 0.16), draw.between(0.0, 0.16));
            let (start, end) = (from.min(to), from.max(to));
            let pose = carried.pose_at(draw.between(start, end));
            let bound = carried.deviation(&pose, start, end);
            let point = Vector3::from_fn(|_, _| draw.between(-1.0, 1.0)).normalize() * radius;
            let mut farthest = 0.0_f64;
            for step in 0..=200 {
                let then = carried.pose_at(start + (end - start) * f64::from(step) / 200.0);
                let moved = (then * nalgebra::Point3::from(point)) - (pose * nalgebra::Point3::from(point));
                farthest = farthest.max(moved.norm());
            }
            assert!(farthest <= bound + 1e-12, "{farthest} {bound}");
        }
    }

    #[test]
    fn a_short_part_of_a_piece_deviates_little_and_an_object_at_rest_not_at_all() {
        let mut draw = Draw(13);
        let (times, states) = states(&mut draw, 3);
        let carried = Carried::new(times.clone(), states.clone(), 0.05);
        let pose = carried.pose_at(0.003);
        assert!(carried.deviation(&pose, 0.003 - 5e-7, 0.003 + 5e-7) < 1e-4);
        // The same around a row.
        assert!(carried.deviation(&carried.pose_at(0.01), 0.01 - 5e-7, 0.01 + 5e-7) < 1e-4);
        let still = BodyState { linear: Vector3::zeros(), angular: Vector3::zeros(), ..states[0] };
        let carried = Carried::new(times, vec![still; 3], 0.05);
        assert!(carried.deviation(&still.world_from_body, 0.0, 0.02) < 1e-15);
    }
}
