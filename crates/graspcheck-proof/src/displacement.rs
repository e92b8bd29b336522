//! How far a solid can come towards another on an interval of time.
//!
//! Of a solid only its core counts: the ball around each point of it looks the same however it is turned.
//!
//! Let joint j go from its position at the reference time (the middle of the interval) by at most `δ⁺_j`
//! forwards and `δ⁻_j` backwards, and let `δ_j` be the larger of the two. These are exact ranges, not speed
//! times time: a joint that turns back costs nothing extra. Let `a_j` be its axis, through `o_j`, at the
//! reference time, and n a direction of length 1. Two bounds on how far the core can reach out along n beyond
//! where it reaches at the reference time are at hand, and the smaller one counts.
//!
//! # B1: what every joint can do, added up
//!
//! Let the joints move from their positions at the reference time to those at any other time, one after the
//! other, the outermost first. While joint j moves, the joints before it still stand at the reference, so
//! that its axis is where it is at the reference time. Then
//! - a revolute joint moves a point by a chord across `a_j` of at most `2 ρ_j sin(δ_j / 2)` (with `δ_j ≤ π`), where
//!   `ρ_j` bounds the point's distance from the axis;
//! - a prismatic joint moves it along `a_j` by at most `δ⁺_j` forwards and `δ⁻_j` backwards.
//!
//! Summed up, no point moves farther than `Σ chords + Σ δ` (after Schwarzer, Saha and Latombe,
//! *Adaptive dynamic collision checking*, T-RO 21(3), 2005), and along n not farther than
//! **B1** `= Σ ‖n × a_j‖ chord_j + Σ max((n·a_j) δ⁺_j, -(n·a_j) δ⁻_j)`.
//! The radius is `ρ_j = (distance of the core's points from the axis at the reference time) + (what the outer
//! joints can add across the axis)`, for they have moved already when joint j moves; their chords and slides
//! bound that.
//!
//! Where no joint turns the axis of another (all axes parallel, as in SCARA and planar arms), the joints may
//! as well move innermost first: then the outer ones still stand at the reference, nothing is added to the
//! radius, and the axes point where they did. That bound is the smaller one and is used. A finger, whose
//! axis the arm does turn, moves before all of them and adds to the radius in any case.
//!
//! # B2: first order, and what is left of second
//!
//! With all joints as a vector δ around the reference, `n·p(δ)` of a point p of the core is smooth. By Taylor's
//! theorem with Lagrange's remainder there is a ξ between 0 and δ with
//! `n·p(δ) = n·p + Σ c_j δ_j + ½ Σ_i Σ_j H_ij(ξ) δ_i δ_j`, where at the reference
//! - `c_j = n·(a_j × (p - o_j)) = (p - o_j)·(n × a_j)` of a revolute joint, `n·a_j` of a prismatic one.
//!
//! Let joint i come no later in the chain than joint j. Joint i turns everything beyond it, so that
//! - both revolute: `H_ij = n·(a_i × (a_j × (p - o_j))) = (n × a_i)·(a_j × (p - o_j))`, at most `ν_i R_j`;
//! - i revolute, j prismatic: `H_ij = n·(a_i × a_j) = (n × a_i)·a_j`, at most `ν_i`, and 0 where their axes are
//!   parallel and stay so;
//! - i prismatic: 0, for it shifts all axes beyond it and turns none.
//!
//! All of this is taken at ξ, anywhere in the joints' ranges. `R_j` bounds the distance of the core's points
//! from axis j there. It depends on the joints beyond j only: the distance at the reference and the chords
//! and slides of these bound it. `ν_i` bounds `‖n × a_i‖` there: it is `‖n × a_i‖` at the reference and, unless no
//! joint turns the axis of another, at most `Σ 2 sin(δ_l / 2)` more, over the revolute joints l before i, of
//! which each moves the tip of the axis by a chord; and never above 1. With `Λ_j = Σ_(i < j, revolute) ν_i δ_i`
//!
//! **B2** `= max over p of [n·p + Σ max(c_j δ⁺_j, -c_j δ⁻_j)] - max over p of n·p
//!   + Σ_revolute R_j δ_j (½ ν_j δ_j + Λ_j) + Σ_(prismatic, turned) δ_j Λ_j`
//!
//! holds for every serial chain with any axes. What is maximised is convex in p, so that the corners of the
//! core suffice. For a cylinder the corners are two rims: with w the direction of n across the cylinder's
//! axis and x its share of n, a point `r u` of the disc has `(n + m)·r u ≤ r ‖(n + m)_⊥‖`, where `m = Σ δ_j (n × a_j)`
//! is at most Λ long, and the point `r w` has `r (x + m·w)`. The first exceeds the second by at most
//! `r (√((x - Λ)² + Λ²) - (x - Λ))`, which is added; it is of second order unless n points along the axis.
//!
//! B1 falls with the length of the interval, B2 exceeds the true motion by its square only: what moves along
//! a surface or away from it is proved in few steps.
//!
//! # Which joints
//!
//! Of two moving bodies only the joints beyond their common link count: both arguments hold in that link's
//! frame. A finger is one more prismatic joint at the end of the arm.

use graspcheck_model::{Pose, robot::JointKind};
use nalgebra::Vector3;

use crate::{
    bounds::Bounds,
    chain::{Carrier, Mount},
    contact::Stage,
    scene::{PartPair, Scene},
    solid::{Core, Place, Placed},
    stretch::{Range, Stretch},
};

/// The scene at a reference time, and the motion of every joint on an interval around it.
///
/// Places and radii of a part are computed when it is first asked for.
pub(crate) struct Moment<'s> {
    scene: &'s Scene,
    stage: &'s Stage,
    joints: Vec<JointState>,
    /// Of the position of each finger, which is half of the opening.
    finger: Range,
    parts: Vec<PartState>,
    /// For each part and arm joint.
    radii: Vec<Radii>,
    /// Of the joints that move a part, while B2 is computed.
    slopes: Vec<Slope>,
    /// Counts the settings; a part whose count differs is not up to date.
    setting: u64,
}

/// An arm joint.
#[derive(Clone, Copy)]
struct JointState {
    kind: JointKind,
    range: Range,
    /// How far it goes from the reference on either side, rad or m.
    farthest: f64,
    /// The longest chord of a point at a distance of 1 from the axis; 0 for a prismatic joint.
    turn: f64,
    /// Of the link behind it, in the world.
    place: Place,
    /// In the world.
    axis: Vector3<f64>,
}

/// A part and an arm joint that moves it.
#[derive(Clone, Copy, Default)]
struct Radii {
    /// The longest chord of the core's points about a revolute joint, m; 0 for a prismatic one.
    chord: f64,
    /// The largest distance of the core's points from the joint's axis, wherever the joints are, m.
    radius: f64,
}

#[derive(Clone, Copy)]
struct PartState {
    setting: u64,
    place: Place,
    finger_axis: Vector3<f64>,
}

/// How fast a point moves along the direction in question with a joint: `base + turn·p` of a point p in the
/// solid's frame.
#[derive(Clone, Copy)]
struct Slope {
    base: f64,
    turn: Vector3<f64>,
    below: f64,
    above: f64,
}

const STILL: Range = Range { reference: 0.0, below: 0.0, above: 0.0 };

impl Range {
    fn farthest(&self) -> f64 {
        self.below.max(self.above)
    }

    /// How far a sliding joint whose axis has this share along a direction can move something along it, m.
    fn slide(&self, along: f64) -> f64 {
        (along * self.above).max(-along * self.below)
    }
}

impl<'s> Moment<'s> {
    pub(crate) fn new(scene: &'s Scene, stage: &'s Stage) -> Self {
        let nowhere = Place::from(&Pose::identity());
        let joint = |joint: &graspcheck_model::robot::Joint| JointState {
            kind: joint.kind,
            range: STILL,
            farthest: 0.0,
            turn: 0.0,
            place: nowhere,
            axis: Vector3::zeros(),
        };
        let part = PartState { setting: 0, place: nowhere, finger_axis: Vector3::zeros() };
        Self {
            scene,
            stage,
            joints: scene.robot.joints.iter().map(joint).collect(),
            finger: STILL,
            parts: vec![part; scene.first_cell_part],
            radii: vec![Radii::default(); scene.first_cell_part * scene.robot.dof()],
            slopes: Vec::with_capacity(scene.robot.dof() + 1),
            setting: 0,
        }
    }

    /// Moves to the middle of `[start, end]` on a stretch of the plan.
    pub(crate) fn set(&mut self, stage: &'s Stage, stretch: &Stretch, start: f64, end: f64) {
        for (joint, state) in self.joints.iter_mut().enumerate() {
            state.range = stretch.arm(joint, start, end);
            state.farthest = state.range.farthest();
        }
        self.finger = half_opening(stretch.opening(start, end), stage.opening_min);
        self.update(stage);
    }

    /// Moves to joint positions `q` and an opening at which nothing moves.
    pub(crate) fn set_still(&mut self, stage: &'s Stage, q: &[f64], opening: f64) {
        for (state, &reference) in self.joints.iter_mut().zip(q) {
            state.range = Range { reference, ..STILL };
            state.farthest = 0.0;
        }
        self.finger = half_opening(Range { reference: opening, ..STILL }, 0.0);
        self.update(stage);
    }

    fn update(&mut self, stage: &'s Stage) {
        self.stage = stage;
        self.setting += 1;
        let mut world_from_parent = self.scene.world_from_base;
        for (state, hinge) in self.joints.iter_mut().zip(&self.scene.hinges) {
            world_from_parent = hinge.link_beyond(&world_from_parent, state.range.reference);
            state.place = world_from_parent;
            state.axis = world_from_parent.rotation * hinge.axis;
            let turns = state.kind == JointKind::Revolute;
            state.turn = if turns { chord(state.farthest) } else { 0.0 };
        }
    }

    /// A part where it is at the reference time.
    pub(crate) fn place(&mut self, part: usize) -> Placed<'s> {
        let known = &self.scene.parts[part];
        let place = match self.parts.get(part) {
            Some(state) if state.setting == self.setting => state.place,
            Some(_) => self.bring_up_to_date(part),
            None => known.mount.place,
        };
        Placed { solid: &known.solid, place }
    }

    /// Both solids of a pair where they are at the reference time.
    pub(crate) fn placed(&mut self, pair: PartPair) -> [Placed<'s>; 2] {
        [pair.a, pair.b].map(|part| self.place(part))
    }

    /// How much narrower than at the reference time the gap of a pair across `n` (from a to b) can become
    /// on the interval, m, when the arm joints from `first` on move the two against each other. A bound that
    /// is not above `enough` is good enough, and no smaller one is looked for; nor is one when it is plain that
    /// none can be found that is not above a positive `enough`.
    ///
    /// The pair must have been asked for by [`Moment::placed`] at this setting.
    pub(crate) fn loss(&mut self, pair: PartPair, first: usize, n: &Vector3<f64>, enough: f64) -> f64 {
        let of_b = self.approach(pair.b, first, &-n, enough);
        of_b + self.approach(pair.a, first, n, enough - of_b)
    }

    /// A box around everything that a part sweeps over on the interval.
    pub(crate) fn sweep(&mut self, part: usize) -> Bounds {
        let placed = self.place(part);
        let most = |axis: usize, sign: f64, moment: &mut Self| {
            let mut n = Vector3::zeros();
            n[axis] = sign;
            sign * placed.place.center[axis] + placed.reach(&n) + moment.approach(part, 0, &n, 0.0)
        };
        let high = Vector3::from_fn(|axis, _| most(axis, 1.0, self));
        let low = Vector3::from_fn(|axis, _| -most(axis, -1.0, self));
        Bounds { low, high }
    }

    /// How far the joints from `first` on can make a part reach out along `n`, m: B1 if that is not above
    /// `enough`, else the smaller one of B1 and B2.
    fn approach(&mut self, part: usize, first: usize, n: &Vector3<f64>, enough: f64) -> f64 {
        if part >= self.parts.len() {
            return 0.0;
        }
        let carrier = self.stage.mount(self.scene, part).carrier;
        let joints = first..carrier.arm_joints(self.joints.len());
        if joints.is_empty() && !matches!(carrier, Carrier::Finger(_)) {
            return 0.0;
        }
        let added_up = self.added_up(part, joints.clone(), n);
        let wanted = if enough > 0.0 { enough } else { added_up };
        if added_up <= enough { added_up } else { self.first_order(part, joints, n, added_up, wanted) }
    }

    /// B1 of some joints, m.
    fn added_up(&self, part: usize, joints: std::ops::Range<usize>, n: &Vector3<f64>) -> f64 {
        let mut sum = 0.0;
        for joint in joints {
            let JointState { kind, axis, range, .. } = &self.joints[joint];
            sum += match kind {
                JointKind::Revolute => {
                    let chord = self.radii[part * self.joints.len() + joint].chord;
                    if chord > 0.0 { chord * n.cross(axis).norm() } else { 0.0 }
                }
                JointKind::Prismatic => range.slide(n.dot(axis)),
            };
        }
        if let Carrier::Finger(_) = self.stage.mount(self.scene, part).carrier {
            sum += self.finger.slide(n.dot(&self.parts[part].finger_axis));
        }
        sum
    }

    /// B2 of some joints, m, or `most` if that is not more; also if B2 cannot be below `wanted`.
    fn first_order(
        &mut self,
        part: usize,
        joints: std::ops::Range<usize>,
        n: &Vector3<f64>,
        most: f64,
        wanted: f64,
    ) -> f64 {
        let PartState { place, finger_axis, .. } = self.parts[part];
        let steady = self.scene.steady_axes;
        self.slopes.clear();
        // Λ, what joints before have turned the axes, and the part of second order.
        let (mut turned, mut tilt, mut second) = (0.0, 0.0, 0.0);
        for joint in joints {
            let JointState { kind, range, farthest, turn, axis, place: link } = &self.joints[joint];
            if *farthest <= 0.0 {
                continue;
            }
            let (base, turns) = match kind {
                JointKind::Revolute => {
                    let across = n.cross(axis);
                    let share = across.norm();
                    let share = if steady { share } else { (share + tilt).min(1.0) };
                    let radius = self.radii[part * self.joints.len() + joint].radius;
                    second += radius * farthest * (0.5 * share * farthest + turned);
                    turned += share * farthest;
                    tilt += turn;
                    ((place.center - link.center).dot(&across), place.rotation.tr_mul(&across))
                }
                JointKind::Prismatic => {
                    if !steady {
                        second += farthest * turned;
                    }
                    (n.dot(axis), Vector3::zeros())
                }
            };
            self.slopes.push(Slope { base, turn: turns, below: range.below, above: range.above });
        }
        if let Carrier::Finger(_) = self.stage.mount(self.scene, part).carrier {
            second += self.finger.farthest() * turned;
            let Range { below, above, .. } = self.finger;
            self.slopes.push(Slope { base: n.dot(&finger_axis), turn: Vector3::zeros(), below, above });
        }
        // Where a number is NaN, B1 is, too.
        if second >= most.min(wanted) {
            return most;
        }
        let local = place.rotation.tr_mul(n);
        let core = self.scene.parts[part].solid.core();
        let first = farthest_out(core, &local, &self.slopes, turned) - core.reach(&local);
        let bound = first + second;
        if bound < most { bound } else { most }
    }

    /// Computes the place and the radii of a part of the robot or the object.
    fn bring_up_to_date(&mut self, part: usize) -> Place {
        let scene = self.scene;
        let mount = self.stage.mount(scene, part);
        let state = &mut self.parts[part];
        state.setting = self.setting;
        match mount.carrier {
            Carrier::World => state.place = mount.place,
            Carrier::Link(link) => state.place = self.joints[link].place.then(&mount.place),
            Carrier::Finger(index) => {
                let finger = &scene.fingers[index];
                let closed = self.joints[self.joints.len() - 1].place.then(&finger.place);
                state.finger_axis = closed.rotation * finger.axis;
                let center = closed.center + state.finger_axis * self.finger.reference;
                state.place = Place { center, ..closed }.then(&mount.place);
            }
        }
        let place = state.place;
        self.measure(part, mount);
        place
    }

    /// Chords and radii of a part.
    fn measure(&mut self, part: usize, mount: &Mount) {
        let PartState { place, finger_axis, .. } = self.parts[part];
        let dof = self.joints.len();
        let steady = self.scene.steady_axes;
        let radii = &mut self.radii[part * dof..(part + 1) * dof];
        let mut outer_chords = 0.0;
        for joint in (0..mount.carrier.arm_joints(dof)).rev() {
            let JointState { kind, farthest, turn, axis, place: link, .. } = &self.joints[joint];
            radii[joint] = Radii::default();
            if *kind == JointKind::Prismatic || *farthest <= 0.0 {
                continue;
            }
            let mut at_reference =
                (place.center - link.center).cross(axis).norm() + mount.radial_extents[joint];
            if let Carrier::Finger(_) = mount.carrier {
                at_reference += self.finger.farthest() * finger_axis.cross(axis).norm();
            }
            let mut radius = at_reference + outer_chords;
            if !steady {
                let outer = &self.joints[joint + 1..mount.carrier.arm_joints(dof)];
                let slides = outer.iter().filter(|outer| outer.kind == JointKind::Prismatic);
                radius += slides.map(|outer| outer.farthest * outer.axis.cross(axis).norm()).sum::<f64>();
            }
            let chord = turn * if steady { at_reference } else { radius };
            radii[joint] = Radii { chord, radius };
            outer_chords += chord;
        }
    }
}

/// How far out along `n` (of length 1, in the solid's frame) a core reaches from its origin when every point
/// may move on with these slopes, m; `turned` bounds the length of all turns together.
fn farthest_out(core: &Core, n: &Vector3<f64>, slopes: &[Slope], turned: f64) -> f64 {
    let at = |p: Vector3<f64>| {
        let along = |slope: &Slope| {
            let speed = slope.base + slope.turn.dot(&p);
            (speed * slope.above).max(-speed * slope.below)
        };
        n.dot(&p) + slopes.iter().map(along).sum::<f64>()
    };
    let ends = |half_length: f64, aside: Vector3<f64>| {
        let along = Vector3::z() * half_length;
        at(aside + along).max(at(aside - along))
    };
    match core {
        Core::Point => at(Vector3::zeros()),
        Core::Segment { half_length } => ends(*half_length, Vector3::zeros()),
        Core::Box { half_extents: h } => [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]]
            .iter()
            .map(|[x, y]| ends(h.z, Vector3::new(x * h.x, y * h.y, 0.0)))
            .fold(f64::NEG_INFINITY, f64::max),
        Core::Cylinder { radius, half_length } => {
            let across = n.x.hypot(n.y);
            let aside = Vector3::new(n.x, n.y, 0.0).try_normalize(1e-12).unwrap_or_else(Vector3::x) * *radius;
            let left = across - turned;
            ends(*half_length, aside) + radius * (left.hypot(turned) - left)
        }
        Core::Points { points, .. } => points.iter().map(|p| at(*p)).fold(f64::NEG_INFINITY, f64::max),
    }
}

/// The longest chord that a point at a distance of 1 from an axis makes when it turns by up to `delta` (rad).
fn chord(delta: f64) -> f64 {
    2.0 * (0.5 * delta.min(std::f64::consts::PI)).sin()
}

/// The positions of a finger when the pads are as far apart as the opening says, but not nearer than
/// `least` (m).
fn half_opening(opening: Range, least: f64) -> Range {
    let reference = opening.reference.max(least);
    let low = (opening.reference - opening.below).max(least);
    let high = (opening.reference + opening.above).max(least);
    Range { reference: 0.5 * reference, below: 0.5 * (reference - low), above: 0.5 * (high - reference) }
}

#[cfg(test)]
mod tests {
    use graspcheck_model::{plan::Plan, robot::RobotModel, shape::Shape};
    use graspcheck_motion::{Polynomial, Trajectory};
    use proptest::prelude::*;

    use super::*;
    use crate::{
        contact::Occasion,
        fixtures::{self, Draw},
        stretch::{middle, stretches},
    };

    /// A chain of up to six joints with skewed axes and offsets, a solid on each link, and an obstacle.
    fn random_chain(draw: &mut Draw, parallel: bool) -> RobotModel {
        let dof = draw.between(1.0, 6.999) as usize;
        let mut joints = Vec::new();
        let mut links = Vec::new();
        for index in 0..dof {
            let mut vector = |half: f64| Vector3::from_fn(|_, _| draw.between(-half, half));
            let (offset, turn, axis) = (vector(0.5), vector(3.0), vector(1.0));
            let (half, place) = (vector(0.2).abs().add_scalar(0.01), Pose::new(vector(0.3), vector(3.0)));
            let points = (0..6).map(|_| vector(0.2).into()).collect();
            let parent = Pose::new(offset, if parallel { Vector3::z() * turn.z } else { turn });
            let axis = if parallel { Vector3::z() } else { axis };
            let slides = draw.between(0.0, 1.0) < 0.3;
            let kind = if slides { JointKind::Prismatic } else { JointKind::Revolute };
            joints.push(fixtures::joint(&format!("joint_{index}"), kind, parent, axis));
            let (radius, half_length) = (half.x, half.y);
            let shape = match draw.between(0.0, 5.0) as usize {
                0 => Shape::Sphere { radius },
                1 => Shape::Cylinder { radius, half_length },
                2 => Shape::Capsule { radius, half_length },
                3 => Shape::Hull { points },
                _ => Shape::Box { half_extents: half },
            };
            links.push(fixtures::link(&format!("link_{index}"), vec![(place, shape)]));
        }
        fixtures::robot(joints, links)
    }

    fn random_plan(draw: &mut Draw, dof: usize, reach: f64) -> Plan {
        let mut some = |reach: f64| (0..dof).map(|_| draw.between(-reach, reach)).collect::<Vec<_>>();
        let (from, to) = (some(2.0), some(reach));
        let to: Vec<f64> = from.iter().zip(to).map(|(a, b)| a + b).collect();
        let mut plan = fixtures::rest_to_rest(&from, &to, 1.0);
        let opening = Polynomial::quintic_hermite([0.01, 0.0, 0.0], [0.4, 0.0, 0.0], 1.0);
        plan.opening = Trajectory::new(1, vec![0.0, 1.0], vec![opening]).unwrap();
        plan
    }

    /// A robot by itself among one obstacle, and a plan of one phase.
    fn scene_of(robot: &RobotModel) -> Scene {
        let obstacle = ("obstacle", fixtures::boxed(0.1, 0.1, 0.1), fixtures::at(1.0, 0.0, 0.0));
        Scene::new(robot, &fixtures::cell(0.0, vec![obstacle]), None).unwrap()
    }

    /// The joint positions of a moment, each anywhere in its range, and an opening likewise: more than the
    /// plan can do, as its joints need not move together.
    fn anywhere(moment: &Moment, draw: &mut Draw) -> (Vec<f64>, f64) {
        let mut position = |range: &Range| {
            let (low, high) = (range.reference - range.below, range.reference + range.above);
            [low, high, range.reference, draw.between(low, high)][draw.between(0.0, 4.0) as usize]
        };
        let q = moment.joints.iter().map(|joint| position(&joint.range)).collect();
        (q, 2.0 * position(&moment.finger))
    }

    /// How far a solid reaches along a direction in the world.
    fn reach(placed: &Placed, n: &Vector3<f64>) -> f64 {
        placed.place.center.dot(n) + placed.reach(n)
    }

    /// Both bounds of a part on an interval, from the base on.
    fn bounds(moment: &mut Moment, part: usize, n: &Vector3<f64>) -> [f64; 2] {
        moment.place(part);
        let joints = 0..moment.stage.mount(moment.scene, part).carrier.arm_joints(moment.joints.len());
        let added_up = moment.added_up(part, joints.clone(), n);
        [added_up, moment.first_order(part, joints, n, f64::INFINITY, f64::INFINITY)]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1500))]

        /// Each of the two bounds by itself, for solids of all kinds at the end of any chain, wherever in
        /// their ranges the joints are; and the box of the sweep.
        #[test]
        fn no_solid_reaches_out_farther_than_the_bounds(seed: u64, reach_of_joints in 0.001..4.0_f64, parallel: bool) {
            let mut draw = Draw(seed);
            let robot = random_chain(&mut draw, parallel);
            let scene = scene_of(&robot);
            let plan = random_plan(&mut draw, robot.dof(), reach_of_joints);
            let stage = Stage::new(&scene, &plan, Occasion::of(&plan, 0)).unwrap();
            let stretch = &stretches(&plan, robot.dof()).unwrap()[0];
            let (start, end) = (draw.between(0.0, 0.5), draw.between(0.5, 1.0));
            let n = Vector3::from_fn(|_, _| draw.between(-1.0, 1.0)).normalize();
            let (mut moment, mut still) = (Moment::new(&scene, &stage), Moment::new(&scene, &stage));
            moment.set(&stage, stretch, start, end);
            for part in 0..scene.first_cell_part {
                let before = reach(&moment.place(part), &n);
                let [added_up, first_order] = bounds(&mut moment, part, &n);
                let sweep = moment.sweep(part);
                for _ in 0..20 {
                    let (q, opening) = anywhere(&moment, &mut draw);
                    still.set_still(&stage, &q, opening);
                    let there = still.place(part);
                    let moved = reach(&there, &n) - before;
                    prop_assert!(moved <= added_up + 1e-10, "part {part}: moved {moved}, B1 {added_up}");
                    prop_assert!(moved <= first_order + 1e-10, "part {part}: moved {moved}, B2 {first_order}");
                    let own = Bounds::of(&there);
                    prop_assert!(own.low >= sweep.low.add_scalar(-1e-10), "{own:?} {sweep:?}");
                    prop_assert!(own.high <= sweep.high.add_scalar(1e-10), "{own:?} {sweep:?}");
                }
            }
        }

        /// For any two parts, moving or not: the distance at any instant of an interval is at least the gap
        /// at its middle, across any normal, less the loss.
        #[test]
        fn no_gap_shrinks_by_more_than_the_loss(seed: u64, reach in 0.001..2.0_f64, parallel: bool) {
            let mut draw = Draw(seed);
            let robot = random_chain(&mut draw, parallel);
            let scene = scene_of(&robot);
            let plan = random_plan(&mut draw, robot.dof(), reach);
            let stage = Stage::new(&scene, &plan, Occasion::of(&plan, 0)).unwrap();
            let stretch = &stretches(&plan, robot.dof()).unwrap()[0];
            let (start, end) = (draw.between(0.2, 0.5), draw.between(0.5, 0.8));
            let (mut moment, mut then) = (Moment::new(&scene, &stage), Moment::new(&scene, &stage));
            moment.set(&stage, stretch, start, end);
            for pair in &scene.pairs {
                let first = stage.requirement(&scene, pair).first_joint;
                let [a, b] = moment.placed(*pair);
                let best = crate::gap::separation(&a, &b, None, 0.0).unwrap();
                let turned = best.normal + Vector3::from_fn(|_, _| draw.between(-0.3, 0.3));
                for n in [best.normal, turned.normalize()] {
                    let least = crate::gap::gap(&a, &b, &n) - moment.loss(*pair, first, &n, 0.0);
                    for step in 0..=10 {
                        let t = start + (end - start) * f64::from(step) / 10.0;
                        then.set(&stage, stretch, t, t);
                        let [a, b] = then.placed(*pair);
                        let then = crate::gap::separation(&a, &b, None, 0.0).unwrap();
                        prop_assert!(then.upper >= least, "{then:?} {least}");
                    }
                }
            }
        }

        /// B2 is the slope and something of second order: on an interval a tenth as long it is a tenth of
        /// what a motion at constant speed makes, but for a hundredth.
        #[test]
        fn what_first_order_leaves_over_falls_with_the_square_of_the_length(seed: u64, parallel: bool) {
            let mut draw = Draw(seed);
            let robot = random_chain(&mut draw, parallel);
            let scene = scene_of(&robot);
            let mut plan = random_plan(&mut draw, robot.dof(), 2.0);
            plan.opening = Trajectory::hold(&[0.05], 1.0).unwrap();
            let stage = Stage::new(&scene, &plan, Occasion::of(&plan, 0)).unwrap();
            let stretch = &stretches(&plan, robot.dof()).unwrap()[0];
            let n = Vector3::from_fn(|_, _| draw.between(-1.0, 1.0)).normalize();
            let (mut moment, mut still) = (Moment::new(&scene, &stage), Moment::new(&scene, &stage));
            // How far joints that all go to one end of their ranges can take the solid, at best.
            let mut left_over = |part: usize, half: f64| {
                moment.set(&stage, stretch, 0.5 - half, 0.5 + half);
                let before = reach(&moment.place(part), &n);
                let [_, first_order] = bounds(&mut moment, part, &n);
                let dof = moment.joints.len();
                let corner = |corner: usize| {
                    let end = |j: usize| if corner >> j & 1 == 1 { moment.joints[j].range.above } else { -moment.joints[j].range.below };
                    (0..dof).map(|j| moment.joints[j].range.reference + end(j)).collect::<Vec<_>>()
                };
                let farthest = (0..1 << dof).map(|index| {
                    still.set_still(&stage, &corner(index), 0.05);
                    reach(&still.place(part), &n) - before
                });
                first_order - farthest.fold(f64::NEG_INFINITY, f64::max)
            };
            // Of single parts what is left over may be small on one of the intervals by chance.
            let (mut wide, mut narrow) = (0.0, 0.0);
            for part in 0..scene.first_cell_part {
                let of_part = left_over(part, 1e-3);
                prop_assert!(of_part >= -1e-12, "part {part}: {of_part}");
                narrow += of_part;
                wide += left_over(part, 1e-2);
            }
            prop_assert!(narrow < 0.03 * wide + 1e-9, "{wide} {narrow}");
        }
    }

    /// A tip on the axis of the first joint is swung off it by the second, across it, and then carried on by
    /// the first. At the reference its distance from the first axis is nothing.
    #[test]
    fn outer_joints_add_to_the_radius_of_skewed_inner_ones() {
        let revolute = |name, axis| fixtures::joint(name, JointKind::Revolute, Pose::identity(), axis);
        let tip = (fixtures::at(0.0, 0.0, 1.0), fixtures::boxed(1e-4, 1e-4, 1e-4));
        let robot = fixtures::robot(
            vec![revolute("turn", Vector3::z()), revolute("swing", Vector3::x())],
            vec![fixtures::link("turning", vec![]), fixtures::link("swinging", vec![tip])],
        );
        let obstacle = ("obstacle", fixtures::boxed(0.1, 0.1, 0.1), fixtures::at(3.0, 0.0, 0.0));
        let scene = Scene::new(&robot, &fixtures::cell(0.0, vec![obstacle]), None).unwrap();
        let plan = fixtures::rest_to_rest(&[-0.5, -0.5], &[0.5, 0.5], 1.0);
        let stage = Stage::new(&scene, &plan, Occasion::of(&plan, 0)).unwrap();
        let mut moment = Moment::new(&scene, &stage);
        moment.set(&stage, &stretches(&plan, 2).unwrap()[0], 0.0, 1.0);
        let part = scene.bodies.iter().find(|body| body.name == "swinging").unwrap().first_part;
        let index = scene.pairs.iter().position(|pair| pair.a == part).unwrap();
        moment.placed(scene.pairs[index]);
        let loss = moment.loss(scene.pairs[index], 0, &Vector3::x(), 0.0);
        let moved = 0.5_f64.sin().powi(2);
        assert!(loss >= moved && loss < 1.2 * moved, "moved {moved}, bound {loss}");
    }

    #[test]
    fn a_sweep_along_a_face_costs_nothing_and_a_slide_is_signed() {
        let table = ("table", fixtures::boxed(1.0, 1.0, 0.05), fixtures::at(0.0, 0.0, -0.05));
        let scene = Scene::new(&fixtures::scara(), &fixtures::cell(0.0, vec![table]), None).unwrap();
        let up = fixtures::rest_to_rest(&[0.0, 0.0, -0.1, 0.0], &[1.0, 2.0, 0.0, 3.0], 1.0);
        let stage = Stage::new(&scene, &up, Occasion::of(&up, 0)).unwrap();
        let mut moment = Moment::new(&scene, &stage);
        let stretch = &stretches(&up, 4).unwrap()[0];
        moment.set(&stage, stretch, 0.0, 1.0);
        let loss = |moment: &mut Moment, name: &str| {
            let a = scene.bodies.iter().find(|body| body.name == name).unwrap().first_part;
            let index = scene.pairs.iter().position(|pair| pair.a == a).unwrap();
            moment.placed(scene.pairs[index]);
            moment.loss(scene.pairs[index], 0, &-Vector3::z(), 0.0)
        };
        assert!(loss(&mut moment, "forearm").abs() < 1e-15);
        // From the middle of the stroke the hand can come 50 mm nearer to the table, by having been there.
        assert!((loss(&mut moment, "hand") - 0.05).abs() < 1e-12);
        // On the later half it only rises.
        moment.set(&stage, stretch, 0.5, 1.0);
        let reference = up.trajectory.eval(middle(0.5, 1.0)).q[2];
        assert!((loss(&mut moment, "hand") - (reference + 0.05)).abs() < 1e-12);
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "halving is exact")]
    fn the_pads_stop_at_the_width_of_the_object() {
        let closing = Range { reference: 0.04, below: 0.02, above: 0.01 };
        let finger = half_opening(closing, 0.03);
        assert_eq!(finger.reference, 0.02);
        assert!((finger.below - 0.005).abs() < 1e-15 && (finger.above - 0.005).abs() < 1e-15);
        let closed = half_opening(Range { reference: 0.01, below: 0.01, above: 0.01 }, 0.03);
        assert_eq!(closed, Range { reference: 0.015, below: 0.0, above: 0.0 });
    }
}
