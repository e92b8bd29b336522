//! Where everything is at the middle of an interval of time, and how far it can move from there.
//!
//! The argument for the bound: let the joints go from where they are at the middle to where they are at any
//! other time of the interval, one after the other. A revolute joint then moves a point by a chord of
//! `2 r sin(δ/2)`, across its axis, when it turns by up to `δ ≤ π` and the point is `r` from the axis; a
//! prismatic one along its axis by `δ`. Along a direction n these count with `‖n × axis‖` and `n · axis`.
//!
//! - Where no joint turns the axis of another, the innermost goes first. Then every axis points where it did
//!   and every point is as far from it as at the middle, for inner joints move both. Only a finger must go
//!   before all joints, as its axis is turned by them; what it moves the point across an axis adds to `r`.
//! - Else the outermost goes first. Then each axis is still where it was at the middle, but the point is not:
//!   what the outer joints moved it adds to `r`.
//!
//! Of two moving bodies only joints that do not move both count: seen from the last link that carries both,
//! the others do nothing.

use std::f64::consts::PI;

use crate::{
    documents::{JointKind, Plan, Trajectory},
    polynomial::{range, value},
    scene::{Carrier, Mount, Scene},
    solid::Placed,
    vector::{Pose, Vector},
};

/// Pieces of a trajectory that share less time than this, s, with an interval are not of it: nothing moves
/// farther than rounding in it.
pub(crate) const SAME_INSTANT: f64 = 1e-12;

/// Where a joint is at the middle of an interval, and how far it goes from there, rad or m.
#[derive(Clone, Copy, Debug)]
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

/// The robot on an interval of time.
pub(crate) struct Motion {
    pub(crate) joints: Vec<Span>,
    finger: Span,
    /// Poses of the links at the middle.
    world_from_link: Vec<Pose>,
    /// Axes of the joints at the middle, in the world.
    axes: Vec<Vector>,
    world_from_finger: [Pose; 2],
    finger_axes: [Vector; 2],
}

impl Motion {
    pub(crate) fn new(scene: &Scene, plan: &Plan, interval: [f64; 2], least_opening: f64) -> Self {
        let robot = scene.robot;
        let joints: Vec<Span> =
            (0..robot.joints.len()).map(|i| Span::of(&plan.trajectory, i, interval)).collect();
        let finger = Span::of_finger(Span::of(&plan.opening, 0, interval), least_opening);
        let mut world_from_parent = robot.world_from_base;
        let (mut world_from_link, mut axes) = (Vec::new(), Vec::new());
        for (joint, span) in robot.joints.iter().zip(&joints) {
            let moved = match joint.kind {
                JointKind::Revolute => Pose::turn(joint.axis, span.middle),
                JointKind::Prismatic => Pose::shift(joint.axis.0 * span.middle),
            };
            world_from_parent = world_from_parent * joint.parent_from_joint * moved;
            axes.push(world_from_parent.vector(joint.axis.0));
            world_from_link.push(world_from_parent);
        }
        let fingers = &robot.gripper.fingers;
        let world_from_finger = [0, 1].map(|i| {
            world_from_parent * fingers[i].link_from_finger * Pose::shift(fingers[i].axis.0 * finger.middle)
        });
        let finger_axes = [0, 1].map(|i| world_from_finger[i].vector(fingers[i].axis.0));
        Self { joints, finger, world_from_link, axes, world_from_finger, finger_axes }
    }

    /// Where a carrier is at the middle.
    pub(crate) fn world_from(&self, carrier: Carrier) -> Pose {
        match carrier {
            Carrier::World => Pose::IDENTITY,
            Carrier::Link(link) => self.world_from_link[link],
            Carrier::Finger(finger) => self.world_from_finger[finger],
        }
    }

    /// How much nearer along `n`, from A to B and of length 1, the solids A and B can come than they are at
    /// the middle, m.
    pub(crate) fn loss(&self, scene: &Scene, solids: [&Placed; 2], mounts: [Mount; 2], n: Vector) -> f64 {
        let joints = mounts.map(|mount| scene.joints_of(mount.carrier));
        let common = joints[0].min(joints[1]);
        let advance = |i: usize, n| self.advance(scene, solids[i], mounts[i].carrier, common, n);
        advance(0, n) + advance(1, -n)
    }

    /// How far the joints after the first `common` ones can move a solid along `n`, m.
    fn advance(&self, scene: &Scene, solid: &Placed, carrier: Carrier, common: usize, n: Vector) -> f64 {
        let slide = match carrier {
            Carrier::Finger(finger) => Some(self.finger_axes[finger]),
            Carrier::World | Carrier::Link(_) => None,
        };
        let mut along = slide.map_or(0.0, |axis| self.finger.along(n.dot(axis)));
        // By how much outer joints have moved points: revolute ones in any direction, prismatic ones along an axis.
        let mut outer_chords = 0.0;
        let mut outer_slides: Vec<Vector> = slide.iter().map(|axis| *axis * self.finger.farthest()).collect();
        for i in (common..scene.joints_of(carrier)).rev() {
            let (axis, span) = (self.axes[i], self.joints[i]);
            match scene.robot.joints[i].kind {
                JointKind::Prismatic => {
                    along += span.along(n.dot(axis));
                    if !scene.keeps_axes {
                        outer_slides.push(axis * span.farthest());
                    }
                }
                JointKind::Revolute if span.farthest() > 0.0 => {
                    let at_middle = solid.distance_from_line(self.world_from_link[i].origin, axis);
                    let moved: f64 = outer_slides.iter().map(|slide| slide.cross(axis).length()).sum();
                    let chord =
                        2.0 * (at_middle + moved + outer_chords) * (0.5 * span.farthest().min(PI)).sin();
                    along += chord * n.cross(axis).length();
                    if !scene.keeps_axes {
                        outer_chords += chord;
                    }
                }
                JointKind::Revolute => {}
            }
        }
        along
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

    /// How far a link of a robot can move along `n` on a part of a plan from 0 to 1 s.
    fn advance(document: &Value, link: usize, trajectory: Value, interval: [f64; 2], n: [f64; 3]) -> f64 {
        let resolved: Resolved = read(document.clone());
        let scene = Scene::new(&resolved);
        let mut plan = plan(&["nothing"]);
        plan["trajectory"] = trajectory;
        let plan: Plan = read(plan);
        let motion = Motion::new(&scene, &plan, interval, 0.0);
        let (body_from_solid, solid) = scene.bodies[link + 1].parts[0];
        let world_from_solid = motion.world_from(Carrier::Link(link)) * body_from_solid;
        motion.advance(&scene, &Placed { solid, world_from_solid }, Carrier::Link(link), 0, Vector(n))
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
        assert!(loss >= true_way && loss < 2.0 * true_way, "{loss} for {true_way}");
    }

    #[test]
    fn one_joint_moves_a_box_by_the_chord_or_the_slide() {
        let radius = 0.6_f64.hypot(0.05);
        let arm = one_joint("revolute");
        let trajectory = || one_piece(&[[0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]]);
        let chord = 2.0 * radius * 0.25_f64.sin();
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} is not {b}");
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

    /// A chain of some joints, with a box on each link, and where they go within 1 s.
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
        (prop::collection::vec(joint, 1..6), any::<bool>(), 0.0..0.5_f64, 0.5..1.0_f64, vector()).prop_map(
            |(joints, is_parallel, start, end, n)| Chain {
                joints,
                is_parallel,
                interval: [start, end],
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
                link(&format!("link {i}"), &[(place, boxed(HALF[0], HALF[1], HALF[2]))])
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
        #![proptest_config(ProptestConfig::with_cases(200))]

        /// Whatever pair moves, seen from what carries both no point goes farther than the bound.
        #[test]
        fn no_slab_narrows_by_more_than_the_loss(chain in chains()) {
            let resolved: Resolved = read(chain.document());
            let (scene, plan) = (Scene::new(&resolved), chain.plan());
            prop_assert_eq!(scene.keeps_axes, chain.is_parallel || scene.keeps_axes);
            let n = Vector(chain.n);
            let placed = |motion: &Motion, body: usize| {
                let (body_from_solid, solid) = scene.bodies[body].parts[0];
                let mount = scene.bodies[body].mount;
                Placed { solid, world_from_solid: motion.world_from(mount.carrier) * mount.carrier_from_body * body_from_solid }
            };
            let whole = Motion::new(&scene, &plan, chain.interval, 0.02);
            for pair in scene.pairs.iter().filter(|pair| scene.bodies[pair.a].role != Role::Object) {
                let mounts = [pair.a, pair.b].map(|body| scene.bodies[body].mount);
                let (a, b) = (placed(&whole, pair.a), placed(&whole, pair.b));
                let before = slab(&a, &b, n);
                let loss = whole.loss(&scene, [&a, &b], mounts, n);
                // The slab turns with what carries the one that fewer joints move.
                let inner = if scene.joints_of(mounts[0].carrier) <= scene.joints_of(mounts[1].carrier) { 0 } else { 1 };
                let frame = match mounts[inner].carrier {
                    Carrier::Finger(_) => Carrier::Link(scene.robot.links.len() - 1),
                    carrier => carrier,
                };
                let local = whole.world_from(frame).vector_back(n);
                for step in 0..=10 {
                    let t = chain.interval[0] + (chain.interval[1] - chain.interval[0]) * f64::from(step) / 10.0;
                    let then = Motion::new(&scene, &plan, [t, t], 0.02);
                    let after = slab(&placed(&then, pair.a), &placed(&then, pair.b), then.world_from(frame).vector(local));
                    let names = [pair.a, pair.b].map(|body| scene.bodies[body].name);
                    prop_assert!(before - after <= loss + 1e-12, "{names:?}: {} > {loss}", before - after);
                }
            }
        }
    }
}
