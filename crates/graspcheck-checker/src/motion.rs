//! Where everything is at the middle of an interval of time, and how far it can move from there.
//!
//! Let the joints go from where they are at the middle to where they are at any other time of the interval, one
//! after the other. A revolute joint then moves a point by a chord of `2 r sin(δ/2)`, across its axis, when it
//! turns by up to `δ ≤ π` and the point is `r` from the axis; a prismatic one along its axis by `δ`. Two bounds
//! on how far a solid gets along a direction n follow, and the smaller one counts.
//!
//! # By chords
//!
//! Chords count along n with `‖n × axis‖`, slides with `n · axis`.
//!
//! - Where no joint turns the axis of another, the innermost goes first. Then every axis points where it did
//!   and every point is as far from it as at the middle, for inner joints move both. Only a finger must go
//!   before all joints, as its axis is turned by them; what it moves the point across an axis adds to `r`.
//! - Else the outermost goes first. Then each axis is still where it was at the middle, but the point is not:
//!   what the outer joints moved it adds to `r`.
//!
//! # By tangents
//!
//! Let the outermost go first. Joint j, with the axis a through o, finds the point at `x'`, where the outer ones
//! have brought it from x, and turns it by δ to `x' + sin δ a × (x' - o) + (1 - cos δ) a × (a × (x' - o))`
//! (Rodrigues). With `w = n × a` that is along n, exactly,
//! `sin δ w·(x - o) + sin δ w·(x' - x) + (1 - cos δ) n·(a × (a × (x' - o)))`.
//!
//! The first term is what the joint would do alone, in a tangent's direction: linear in x, so that all joints
//! together take the solid farthest at one of its corners. It has a sign: what moves away, or along, costs
//! nothing. The others are of second order: `‖w‖` times the chords of the outer joints and `w · axis` times
//! their slides, and `(1 - cos δ) ‖w‖ r`. A slide adds `δ n·a`, and nothing of second order of its own.
//!
//! # Which joints
//!
//! Of two moving bodies only joints that do not move both count: seen from the last link that carries both,
//! the others do nothing.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::{
    documents::{JointKind, Plan, Trajectory},
    policy::Stage,
    polynomial::{range, value},
    scene::{Carrier, Mount, Scene},
    solid::{Placed, Slope},
    vector::{Pose, Vector},
};

/// Pieces of a trajectory that share less time than this, s, with an interval are not of it: nothing moves
/// farther than rounding in it.
pub(crate) const SAME_INSTANT: f64 = 1e-12;

/// Where a joint is at the middle of an interval, and how far it goes from there, rad or m.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Span {
    pub(crate) middle: f64,
    pub(crate) below: f64,
    pub(crate) above: f64,
}

impl Span {
    /// Of a joint of a trajectory on an interval: over all pieces that the interval touches.
    pub(crate) fn of(trajectory: &Trajectory, joint: usize, [start, end]: [f64; 2]) -> Self {
        let Trajectory { knots, coefficients } = trajectory;
        let last = coefficients.len() - 1;
        let piece_at = |time: f64| knots.partition_point(|knot| *knot <= time).clamp(1, last + 1) - 1;
        let time = 0.5 * (start + end);
        let central = piece_at(time);
        let middle = value(&coefficients[central][joint], time - knots[central]);
        let (mut low, mut high) = (middle, middle);
        for piece in piece_at(start)..=piece_at(end) {
            let zero = knots[piece];
            let until = if piece == last { end } else { end.min(knots[piece + 1]) };
            let from = start.max(zero);
            if piece == central || until - from > SAME_INSTANT {
                let [lowest, highest] = range(&coefficients[piece][joint], from - zero, until - zero);
                (low, high) = (low.min(lowest), high.max(highest));
            }
        }
        Self { middle, below: middle - low, above: high - middle }
    }

    /// Of a finger, which goes to half of the opening, but no nearer to the middle than half of `least`.
    fn of_finger(opening: Self, least: f64) -> Self {
        let stop = |opening: f64| 0.5 * opening.max(least);
        let middle = stop(opening.middle);
        let (low, high) = (stop(opening.middle - opening.below), stop(opening.middle + opening.above));
        Self { middle, below: middle - low, above: high - middle }
    }

    fn farthest(self) -> f64 {
        self.below.max(self.above)
    }

    /// How far a slide moves things along a direction with which its axis has this product.
    fn along(self, product: f64) -> f64 {
        (product * self.above).max(-product * self.below)
    }
}

/// A joint on the interval.
#[derive(Clone, Copy)]
struct JointState {
    kind: JointKind,
    span: Span,
    /// How far it goes, rad or m.
    farthest: f64,
    /// Of a revolute joint the longest chord of a point at 1 m from the axis, the largest sines of the angles
    /// below and above, and the largest `1 - cos`; 0 of a prismatic one.
    chord: f64,
    sines: [f64; 2],
    bend: f64,
    /// The link behind it at the middle.
    world_from_link: Pose,
    /// Its axis at the middle, in the world.
    axis: Vector,
}

/// A solid on the interval, with what counts of it for each joint.
#[derive(Clone, Copy)]
struct SolidState {
    /// The setting at which this was computed.
    setting: u64,
    world_from_solid: Pose,
    carrier: Carrier,
}

/// A solid and a revolute joint.
#[derive(Clone, Copy, Default)]
struct Turn {
    /// The longest chord of its points, m, for the bound by chords.
    chord: f64,
    /// How far its points are from the axis at most when the outer joints have moved them, m.
    radius: f64,
    /// What the chords of the outer joints come to, m.
    outer_chords: f64,
}

/// The robot and the object on an interval of time; one is moved from interval to interval.
pub(crate) struct Motion<'d> {
    scene: &'d Scene<'d>,
    plan: &'d Plan,
    joints: Vec<JointState>,
    finger: Span,
    world_from_finger: [Pose; 2],
    finger_axes: [Vector; 2],
    solids: Vec<SolidState>,
    /// `[solid][joint]`.
    turns: Vec<Turn>,
    /// Of the joints that move a solid; kept for its space.
    slopes: Vec<Slope>,
    setting: u64,
}

impl<'d> Motion<'d> {
    /// At rest at the beginning; to be set.
    pub(crate) fn new(scene: &'d Scene<'d>, plan: &'d Plan) -> Self {
        let joint = JointState {
            kind: JointKind::Prismatic,
            span: Span::default(),
            farthest: 0.0,
            chord: 0.0,
            sines: [0.0; 2],
            bend: 0.0,
            world_from_link: Pose::IDENTITY,
            axis: Vector::ZERO,
        };
        let solid = SolidState { setting: 0, world_from_solid: Pose::IDENTITY, carrier: Carrier::World };
        let dof = scene.robot.joints.len();
        Self {
            scene,
            plan,
            joints: vec![joint; dof],
            finger: Span::default(),
            world_from_finger: [Pose::IDENTITY; 2],
            finger_axes: [Vector::ZERO; 2],
            solids: vec![solid; scene.solids.len()],
            turns: vec![Turn::default(); scene.solids.len() * dof],
            slopes: Vec::with_capacity(dof + 1),
            setting: 0,
        }
    }

    /// Moves to an interval.
    pub(crate) fn set(&mut self, interval: [f64; 2], least_opening: f64) {
        self.setting += 1;
        let robot = self.scene.robot;
        let mut world_from_parent = robot.world_from_base;
        for (i, (state, joint)) in self.joints.iter_mut().zip(&robot.joints).enumerate() {
            let span = Span::of(&self.plan.trajectory, i, interval);
            let farthest = span.farthest();
            *state = JointState {
                kind: joint.kind,
                span,
                farthest,
                chord: 0.0,
                sines: [0.0; 2],
                bend: 0.0,
                ..*state
            };
            let moved = match joint.kind {
                JointKind::Revolute => {
                    let turned = farthest.min(PI);
                    state.chord = 2.0 * (0.5 * turned).sin();
                    // 1 - cos δ = ½ (2 sin(δ/2))², without cancellation.
                    state.bend = 0.5 * state.chord * state.chord;
                    state.sines = [span.below, span.above].map(|angle| angle.min(FRAC_PI_2).sin());
                    Pose::turn(joint.axis, span.middle)
                }
                JointKind::Prismatic => Pose::shift(joint.axis.0 * span.middle),
            };
            world_from_parent = world_from_parent * joint.parent_from_joint * moved;
            state.axis = world_from_parent.vector(joint.axis.0);
            state.world_from_link = world_from_parent;
        }
        self.finger = Span::of_finger(Span::of(&self.plan.opening, 0, interval), least_opening);
        for (i, finger) in robot.gripper.fingers.iter().enumerate() {
            let open = Pose::shift(finger.axis.0 * self.finger.middle);
            self.world_from_finger[i] = world_from_parent * finger.link_from_finger * open;
            self.finger_axes[i] = self.world_from_finger[i].vector(finger.axis.0);
        }
    }

    /// Whether no joint is so far from 0 that its sine is rounded coarsely.
    pub(crate) fn is_near(&self) -> bool {
        self.joints.iter().all(|joint| joint.span.middle.abs() < crate::LARGEST)
    }

    /// Where a carrier is at the middle.
    pub(crate) fn world_from(&self, carrier: Carrier) -> Pose {
        match carrier {
            Carrier::World => Pose::IDENTITY,
            Carrier::Link(link) => self.joints[link].world_from_link,
            Carrier::Finger(finger) => self.world_from_finger[finger],
        }
    }

    /// A solid, by its index, where it is at the middle in a stage.
    pub(crate) fn place(&mut self, stage: &Stage, solid: usize) -> Placed<'d> {
        let known = &self.scene.solids[solid];
        if self.solids[solid].setting != self.setting {
            let Mount { carrier, carrier_from_body } = stage.mount(self.scene, known.body);
            let body = self.world_from(carrier) * carrier_from_body;
            let world_from_solid = body * known.body_from_solid;
            self.solids[solid] = SolidState { setting: self.setting, world_from_solid, carrier };
            self.measure(&Placed { solid: known.solid, world_from_solid }, solid, carrier);
        }
        Placed { solid: known.solid, world_from_solid: self.solids[solid].world_from_solid }
    }

    fn slide_of(&self, carrier: Carrier) -> Option<Vector> {
        match carrier {
            Carrier::Finger(finger) => Some(self.finger_axes[finger]),
            Carrier::World | Carrier::Link(_) => None,
        }
    }

    /// Chords and radii of a solid about every joint that turns it.
    fn measure(&mut self, placed: &Placed, solid: usize, carrier: Carrier) {
        let slide = self.slide_of(carrier);
        let (count, keeps_axes) = (self.scene.joints_of(carrier), self.scene.keeps_axes);
        let dof = self.joints.len();
        let turns = &mut self.turns[solid * dof..(solid + 1) * dof];
        let mut outer_chords = 0.0;
        for i in (0..count).rev() {
            let JointState { kind, farthest, chord, axis, world_from_link, .. } = self.joints[i];
            turns[i] = Turn { outer_chords, ..Turn::default() };
            if kind == JointKind::Prismatic || farthest <= 0.0 {
                continue;
            }
            let by_finger = slide.map_or(0.0, |along| self.finger.farthest() * along.cross(axis).length());
            let alone = placed.distance_from_line(world_from_link.origin, axis) + by_finger;
            let mut radius = alone + outer_chords;
            if !keeps_axes {
                for outer in self.joints[i + 1..count].iter().filter(|it| it.kind == JointKind::Prismatic) {
                    radius += outer.farthest * outer.axis.cross(axis).length();
                }
            }
            let chord = chord * if keeps_axes { alone } else { radius };
            turns[i] = Turn { chord, radius, outer_chords };
            outer_chords += chord;
        }
    }

    /// How much nearer along `n`, from A to B and of length 1, the solids A and B can come than they are at
    /// the middle, m. What is not above `enough` is not made smaller. Both must have been placed.
    pub(crate) fn loss(&mut self, [a, b]: [usize; 2], n: Vector, enough: f64) -> f64 {
        let joints = [a, b].map(|solid| self.scene.joints_of(self.solids[solid].carrier));
        let common = joints[0].min(joints[1]);
        let by_chords = [self.by_chords(a, common, n), self.by_chords(b, common, -n)];
        if by_chords[0] + by_chords[1] <= enough {
            return by_chords[0] + by_chords[1];
        }
        by_chords[0].min(self.by_tangents(a, common, n)) + by_chords[1].min(self.by_tangents(b, common, -n))
    }

    /// How far the joints after the first `common` ones can move a solid along `n`, m: by chords, and where that
    /// is above `enough`, by tangents.
    pub(crate) fn advance(&mut self, solid: usize, common: usize, n: Vector, enough: f64) -> f64 {
        let by_chords = self.by_chords(solid, common, n);
        if by_chords <= enough { by_chords } else { by_chords.min(self.by_tangents(solid, common, n)) }
    }

    fn by_chords(&self, solid: usize, common: usize, n: Vector) -> f64 {
        let carrier = self.solids[solid].carrier;
        let mut along = self.slide_of(carrier).map_or(0.0, |axis| self.finger.along(n.dot(axis)));
        let turns = &self.turns[solid * self.joints.len()..];
        let joints = self.joints[..self.scene.joints_of(carrier)].iter().zip(turns);
        for (JointState { kind, span, axis, .. }, turn) in joints.skip(common) {
            along += match kind {
                JointKind::Prismatic => span.along(n.dot(*axis)),
                JointKind::Revolute if turn.chord > 0.0 => turn.chord * n.cross(*axis).length(),
                JointKind::Revolute => 0.0,
            };
        }
        along
    }

    fn by_tangents(&mut self, solid: usize, common: usize, n: Vector) -> f64 {
        let SolidState { world_from_solid, carrier, .. } = self.solids[solid];
        let count = self.scene.joints_of(carrier);
        let turns = &self.turns[solid * self.joints.len()..];
        let slide = self.slide_of(carrier);
        self.slopes.clear();
        self.slopes.extend(slide.map(|axis| Slope {
            at_origin: n.dot(axis),
            gradient: Vector::ZERO,
            below: self.finger.below,
            above: self.finger.above,
        }));
        let mut second = 0.0;
        for (i, (joint, turn)) in self.joints[..count].iter().zip(turns).enumerate().skip(common) {
            let JointState { kind, span, farthest, sines, bend, axis, world_from_link, .. } = joint;
            if *farthest <= 0.0 {
                continue;
            }
            self.slopes.push(match kind {
                JointKind::Prismatic => Slope {
                    at_origin: n.dot(*axis),
                    gradient: Vector::ZERO,
                    below: span.below,
                    above: span.above,
                },
                JointKind::Revolute => {
                    let w = n.cross(*axis);
                    let length = w.length();
                    let mut moved = length * turn.outer_chords;
                    for outer in self.joints[i + 1..count].iter().filter(|it| it.kind == JointKind::Prismatic)
                    {
                        moved += w.dot(outer.axis).abs() * outer.farthest;
                    }
                    moved += slide.map_or(0.0, |axis| w.dot(axis).abs() * self.finger.farthest());
                    second += sines[0].max(sines[1]) * moved + bend * length * turn.radius;
                    Slope {
                        at_origin: w.dot(world_from_solid.origin - world_from_link.origin),
                        gradient: world_from_solid.vector_back(w),
                        below: sines[0],
                        above: sines[1],
                    }
                }
            });
        }
        let solid = self.scene.solids[solid].solid;
        solid.advance(world_from_solid.vector_back(n), &self.slopes) + second
    }
}

/// How wide the slab across `n` (of length 1) is that has all of A on one side and all of B on the other, m:
/// a lower bound on their distance for any n.
pub(crate) fn slab(a: &Placed, b: &Placed, n: Vector) -> f64 {
    -b.reach(-n) - a.reach(n)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use serde_json::{Value, json};

    use super::*;
    use crate::{
        documents::Resolved,
        fixture::{at, boxed, gantry, joint, link, one_piece, plan, pose, read, rest_to_rest, robot},
        scene::Role,
        solid::Solid,
    };

    const HALF: [f64; 3] = [0.1, 0.05, 0.2];

    /// One moving joint with a box on it whose middle is 0.5 m from its axis.
    fn one_joint(kind: &str) -> Value {
        let joints = vec![joint(kind, at(0.0, 0.0, 0.0), [0.0, 0.0, 1.0])];
        let mut document = gantry();
        document["robot"] =
            robot(joints, vec![link("arm", &[(at(0.5, 0.0, 0.0), boxed(HALF[0], HALF[1], HALF[2]))])]);
        document
    }

    /// How far a link of a robot can move along `n` on a part of a plan from 0 to 1 s: by chords, and at best.
    fn advance(
        document: &Value,
        link: usize,
        trajectory: Value,
        interval: [f64; 2],
        n: [f64; 3],
    ) -> [f64; 2] {
        let resolved: Resolved = read(document.clone());
        let scene = Scene::new(&resolved);
        let mut plan = plan(&["nothing"]);
        plan["trajectory"] = trajectory;
        let plan: Plan = read(plan);
        let mut motion = Motion::new(&scene, &plan);
        motion.set(interval, 0.0);
        let solid = scene.bodies[link + 1].first_solid;
        motion.place(&Stage::without_object(), solid);
        [f64::INFINITY, 0.0].map(|enough| motion.advance(solid, 0, Vector(n), enough))
    }

    /// A mast on the axis of the first joint, which the second one lays down: only then the first moves it.
    #[test]
    fn what_outer_joints_move_a_point_from_an_axis_counts() {
        let turn = |axis| joint("revolute", at(0.0, 0.0, 0.0), axis);
        let (spin, tilt) = (turn([0.0, 0.0, 1.0]), turn([1.0, 0.0, 0.0]));
        let tip = [(at(0.0, 0.0, 1.0), boxed(1e-3, 1e-3, 1e-3))];
        let mut document = gantry();
        document["robot"] = robot(vec![spin, tilt], vec![link("pan", &[]), link("mast", &tip)]);
        let from_minus_1_to_1 = [-1.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let loss = advance(&document, 1, one_piece(&[from_minus_1_to_1; 2]), [0.0, 1.0], [1.0, 0.0, 0.0]);
        // Tilted and then turned by 1 rad the tip is at x = sin² 1.
        let true_way = 1.0_f64.sin().powi(2);
        for loss in loss {
            assert!(loss >= true_way && loss < 2.0 * true_way, "{loss} for {true_way}");
        }
    }

    #[test]
    fn one_joint_moves_a_box_by_the_chord_or_the_slide() {
        let radius = 0.6_f64.hypot(0.05);
        let arm = one_joint("revolute");
        let trajectory = || one_piece(&[[0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]]);
        let chord = 2.0 * radius * 0.25_f64.sin();
        let close =
            |a: [f64; 2], b: f64| assert!((a[0] - b).abs() < 1e-12 && a[1] <= a[0], "{a:?} is not {b}");
        close(advance(&arm, 0, trajectory(), [0.0, 1.0], [1.0, 0.0, 0.0]), chord);
        close(advance(&arm, 0, trajectory(), [0.0, 1.0], [0.6, 0.0, 0.8]), 0.6 * chord);
        close(advance(&arm, 0, trajectory(), [0.0, 1.0], [0.0, 0.0, 1.0]), 0.0);
        // More than half a turn: the diameter, and no more.
        let spin = one_piece(&[[0.0, 50.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]]);
        close(advance(&arm, 0, spin, [0.0, 1.0], [1.0, 0.0, 0.0]), 2.0 * radius);
        // It turns back in the middle: 1/4 rad there, 0 at the ends.
        let hill = one_piece(&[[0.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0]]);
        close(advance(&arm, 0, hill, [0.0, 1.0], [0.0, 1.0, 0.0]), 2.0 * radius * 0.125_f64.sin());
        // A slide counts with its sign.
        let quill = one_joint("prismatic");
        let rising = || one_piece(&[[0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]]);
        close(advance(&quill, 0, rising(), [0.0, 1.0], [0.0, 0.0, 1.0]), 0.75);
        close(advance(&quill, 0, rising(), [0.0, 1.0], [0.6, 0.0, -0.8]), 0.2);
    }

    /// What a box on an arm loses along its way beyond the way itself, on an interval of this length, s.
    fn excess(length: f64, n: [f64; 3]) -> [f64; 2] {
        let arm = one_joint("revolute");
        let line = one_piece(&[[0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]]);
        // The corner that gets farthest stands at x = 0.6 and y = ±0.05, turned with the arm.
        let way = |angle: f64| {
            let corner = |y: f64| {
                let (sin, cos) = angle.sin_cos();
                n[0] * (0.6 * cos - y * sin) + n[1] * (0.6 * sin + y * cos)
            };
            corner(0.05).max(corner(-0.05))
        };
        let true_way = way(length).max(way(0.0)) - way(0.5 * length);
        let turned = advance(&arm, 0, line, [0.0, length], n);
        turned.map(|loss| loss - true_way)
    }

    #[test]
    fn the_bound_by_tangents_exceeds_the_way_by_its_square_only() {
        for n in [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.6, 0.8, 0.0]] {
            // On longer intervals it is another corner that gets farthest.
            let [coarse, fine] = [0.01, 0.001].map(|length| excess(length, n)[1]);
            assert!(coarse >= -1e-12 && fine >= -1e-12 && fine < 0.02 * coarse + 1e-12, "{coarse}, {fine}");
        }
        // Chords count in full across the way.
        let across = excess(0.01, [1.0, 0.0, 0.0]);
        assert!(across[1] < 0.2 * across[0], "{across:?}");
    }

    #[test]
    fn an_interval_over_two_pieces_has_the_range_of_both() {
        let line = |from: f64, speed: f64| [from, speed, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let trajectory: Trajectory =
            read(json!({"knots": [0.0, 1.0, 2.0], "coefficients": [[line(0.0, 1.0)], [line(5.0, -2.0)]]}));
        let span = |interval| {
            let span = Span::of(&trajectory, 0, interval);
            [span.middle, span.middle - span.below, span.middle + span.above]
        };
        let close =
            |a: [f64; 3], b: [f64; 3]| assert!(a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-12), "{a:?}");
        close(span([0.2, 0.6]), [0.4, 0.2, 0.6]);
        close(span([0.5, 1.2]), [0.85, 0.5, 5.0]);
        // One piece ends where the other begins: the jump between is of neither.
        close(span([0.5, 1.0]), [0.75, 0.5, 1.0]);
        close(span([1.0, 2.0]), [4.0, 3.0, 5.0]);
        close(span([2.0, 2.0]), [3.0, 3.0, 3.0]);
    }

    #[test]
    fn fingers_stop_at_the_object() {
        let opening = Span { middle: 0.05, below: 0.02, above: 0.01 };
        let free = Span::of_finger(opening, 0.0);
        assert!((free.middle - 0.025).abs() < 1e-15 && (free.below - 0.01).abs() < 1e-15);
        let stopped = Span::of_finger(opening, 0.04);
        assert!((stopped.below - 0.005).abs() < 1e-15 && (stopped.above - 0.005).abs() < 1e-15);
    }

    /// Whether it slides, an offset, an axis, an angle, where it starts and how far it goes.
    type RandomJoint = (bool, [f64; 3], [f64; 3], f64, f64, f64);

    /// A chain of some joints, with a solid on each link, and where they go within 1 s.
    #[derive(Clone, Debug)]
    struct Chain {
        joints: Vec<RandomJoint>,
        is_parallel: bool,
        interval: [f64; 2],
        n: [f64; 3],
    }

    fn unit(v: [f64; 3]) -> [f64; 3] {
        (Vector(v) * (1.0 / Vector(v).length())).0
    }

    fn chains() -> impl Strategy<Value = Chain> {
        let vector = || {
            proptest::array::uniform3(-1.0..1.0_f64).prop_filter("a direction", |v| Vector(*v).length() > 0.1)
        };
        let joint =
            (prop::bool::weighted(0.3), vector(), vector(), -3.0..3.0_f64, -2.0..2.0_f64, -1.5..1.5_f64);
        // From a thousandth of the motion to all of it: on short intervals the tangents decide.
        let interval = (0.0..0.9_f64, 0.0..3.0_f64);
        (prop::collection::vec(joint, 1..6), any::<bool>(), interval, vector()).prop_map(
            |(joints, is_parallel, (start, shortness), n)| Chain {
                joints,
                is_parallel,
                interval: [start, start + (1.0 - start) * 10.0_f64.powf(-shortness)],
                n: unit(n),
            },
        )
    }

    impl Chain {
        fn document(&self) -> Value {
            let mut document = gantry();
            let joints = self.joints.iter().map(|(slides, offset, axis, angle, ..)| {
                let axis = if self.is_parallel { [0.0, 0.0, 1.0] } else { unit(*axis) };
                let parent = pose(
                    offset.map(|x| 0.5 * x),
                    if self.is_parallel { axis } else { unit(*offset) },
                    *angle,
                );
                joint(if *slides { "prismatic" } else { "revolute" }, parent, axis)
            });
            let links = self.joints.iter().enumerate().map(|(i, (_, offset, axis, angle, ..))| {
                let place = pose(offset.map(|x| 0.3 * x), unit(*axis), *angle);
                let solid = match (angle.abs() * 10.0) as usize % 3 {
                    0 => boxed(HALF[0], HALF[1], HALF[2]),
                    1 => json!({"cylinder": {"radius": 0.1, "half_length": 0.05}}),
                    _ => json!({"capsule": {"radius": 0.05, "half_length": 0.2}}),
                };
                link(&format!("link {i}"), &[(place, solid)])
            });
            document["robot"] = robot(joints.collect(), links.collect());
            document
        }

        fn plan(&self) -> Plan {
            let motions: Vec<_> =
                self.joints.iter().map(|(.., from, way)| rest_to_rest(*from, from + way)).collect();
            let mut plan = plan(&["nothing"]);
            plan["trajectory"] = one_piece(&motions);
            plan["opening"] = one_piece(&[rest_to_rest(0.01, 0.3)]);
            read(plan)
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        /// Whatever pair moves, seen from what carries both no point goes farther than the bound.
        #[test]
        fn no_slab_narrows_by_more_than_the_loss(chain in chains()) {
            let resolved: Resolved = read(chain.document());
            let (scene, plan) = (Scene::new(&resolved), chain.plan());
            prop_assert_eq!(scene.keeps_axes, chain.is_parallel || scene.keeps_axes);
            let n = Vector(chain.n);
            let still = Stage::without_object();
            let mut whole = Motion::new(&scene, &plan);
            whole.set(chain.interval, 0.02);
            for pair in scene.pairs.iter().filter(|pair| scene.bodies[pair.a].role != Role::Object) {
                let mounts = [pair.a, pair.b].map(|body| scene.bodies[body].mount);
                let solids = [pair.a, pair.b].map(|body| scene.bodies[body].first_solid);
                if [pair.a, pair.b].iter().any(|body| scene.bodies[*body].parts.is_empty()) {
                    continue;
                }
                let placed = |motion: &mut Motion<'_>| {
                    let [a, b] = solids.map(|solid| motion.place(&still, solid));
                    [(a.solid, a.world_from_solid), (b.solid, b.world_from_solid)]
                        .map(|(solid, world_from_solid)| (solid.clone(), world_from_solid))
                };
                let slab = |[(a, at_a), (b, at_b)]: &[(Solid, Pose); 2], n| {
                    slab(
                        &Placed { solid: a, world_from_solid: *at_a },
                        &Placed { solid: b, world_from_solid: *at_b },
                        n,
                    )
                };
                let before = slab(&placed(&mut whole), n);
                let losses = [f64::INFINITY, 0.0].map(|enough| whole.loss(solids, n, enough));
                // The slab turns with what carries the one that fewer joints move.
                let inner = if scene.joints_of(mounts[0].carrier) <= scene.joints_of(mounts[1].carrier) { 0 } else { 1 };
                let frame = match mounts[inner].carrier {
                    Carrier::Finger(_) => Carrier::Link(scene.robot.links.len() - 1),
                    carrier => carrier,
                };
                let local = whole.world_from(frame).vector_back(n);
                for step in 0..=10 {
                    let t = chain.interval[0] + (chain.interval[1] - chain.interval[0]) * f64::from(step) / 10.0;
                    let mut then = Motion::new(&scene, &plan);
                    then.set([t, t], 0.02);
                    let after = slab(&placed(&mut then), then.world_from(frame).vector(local));
                    let names = [pair.a, pair.b].map(|body| scene.bodies[body].name);
                    for loss in losses {
                        prop_assert!(before - after <= loss + 1e-12, "{names:?}: {} > {loss}", before - after);
                    }
                }
            }
        }
    }
}
