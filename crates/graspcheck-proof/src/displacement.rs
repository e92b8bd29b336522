//! How far a solid can come towards another on an interval of time.
//!
//! Let joints move from their positions at the reference time (the middle of the interval) to those at any
//! other time of it, one joint after the other, the outermost first. While joint j moves, the joints before
//! it still stand at the reference, so that its axis `a_j` is where it is at the reference time. Then
//! - a revolute joint moves a point by a chord across `a_j` of at most `2 ρ_j sin(δ_j / 2)`, where `δ_j ≤ π` is
//!   how far the joint goes from its reference position, and `ρ_j` bounds the point's distance from the axis;
//! - a prismatic joint moves it along `a_j` by at most `δ⁺` forwards and `δ⁻` backwards.
//!
//! Summed up, no point moves farther than **B0** `= Σ chords + Σ δ` (after Schwarzer, Saha and Latombe,
//! *Adaptive dynamic collision checking*, T-RO 21(3), 2005), and along a direction n not farther than
//! **B1** `= Σ ‖n × a_j‖ chord_j + Σ max((n·a_j) δ⁺_j, -(n·a_j) δ⁻_j)`. B1 is never the larger, so it is the loss.
//! The radius is `ρ_j = (distance of the solid's points from the axis at the reference time) + (what the outer
//! joints can add across the axis)`, for they have moved already when joint j moves; B0 of the outer joints
//! bounds that.
//!
//! Where no joint turns the axis of another (all axes parallel, as in SCARA and planar arms), the joints may
//! as well move innermost first: then the outer ones still stand at the reference, nothing is added to the
//! radius, and the axes point where they did. That bound is the smaller one and is used. A finger, whose
//! axis the arm does turn, moves before all of them and adds to the radius in any case.
//!
//! The positions are exact ranges, not speed times time: a joint that turns back costs nothing extra.
//!
//! Where the axes between j and the solid are parallel, the solid's extent counts across the axis only.
//!
//! Of two moving bodies only the joints beyond their common link count: the argument holds in that link's
//! frame.

use graspcheck_model::{Pose, robot::JointKind};
use nalgebra::{Translation3, Vector3};

use crate::{
    chain::Carrier,
    contact::{Requirement, Stage},
    scene::{PartPair, Scene},
    solid::{Place, Placed},
    stretch::{Range, Stretch},
};

/// The scene at a reference time, and the motion of every joint on an interval around it.
///
/// Places and chords of a part are computed when it is first asked for.
pub(crate) struct Moment<'s> {
    scene: &'s Scene,
    stage: &'s Stage,
    q: Vec<f64>,
    arm: Vec<Range>,
    /// Of the position of each finger, which is half of the opening.
    finger: Range,
    world_from_link: Vec<Pose>,
    axes: Vec<Vector3<f64>>,
    parts: Vec<PartState>,
    /// For each part and arm joint: the chord of a revolute joint, m; 0 for a prismatic one.
    chords: Vec<f64>,
    /// Counts the settings; a part whose count differs is not up to date.
    setting: u64,
}

#[derive(Clone, Copy)]
struct PartState {
    setting: u64,
    place: Place,
    finger_axis: Vector3<f64>,
}

const STILL: Range = Range { reference: 0.0, below: 0.0, above: 0.0 };

impl<'s> Moment<'s> {
    pub(crate) fn new(scene: &'s Scene, stage: &'s Stage) -> Self {
        let dof = scene.robot.dof();
        let nowhere = Place::from(&Pose::identity());
        let part = PartState { setting: 0, place: nowhere, finger_axis: Vector3::zeros() };
        Self {
            scene,
            stage,
            q: vec![0.0; dof],
            arm: vec![STILL; dof],
            finger: STILL,
            world_from_link: vec![Pose::identity(); dof],
            axes: vec![Vector3::zeros(); dof],
            parts: vec![part; scene.parts.len()],
            chords: vec![0.0; scene.parts.len() * dof],
            setting: 0,
        }
    }

    /// Moves to the middle of `[start, end]` on a stretch of the plan.
    pub(crate) fn set(&mut self, stage: &'s Stage, stretch: &Stretch, start: f64, end: f64) {
        for (joint, range) in self.arm.iter_mut().enumerate() {
            *range = stretch.arm(joint, start, end);
        }
        let opening = stretch.opening(start, end);
        self.finger = half_opening(opening, stage.opening_min);
        self.update(stage);
    }

    /// Moves to joint positions `q` and an opening at which nothing moves.
    pub(crate) fn set_still(&mut self, stage: &'s Stage, q: &[f64], opening: f64) {
        for (range, &reference) in self.arm.iter_mut().zip(q) {
            *range = Range { reference, ..STILL };
        }
        self.finger = half_opening(Range { reference: opening, ..STILL }, 0.0);
        self.update(stage);
    }

    fn update(&mut self, stage: &'s Stage) {
        self.stage = stage;
        self.setting += 1;
        for (q, range) in self.q.iter_mut().zip(&self.arm) {
            *q = range.reference;
        }
        self.scene.robot.forward_into(&self.q, &mut self.world_from_link);
        for ((axis, pose), joint) in
            self.axes.iter_mut().zip(&self.world_from_link).zip(&self.scene.robot.joints)
        {
            *axis = pose.rotation * joint.axis.into_inner();
        }
    }

    /// Both solids of a pair where they are at the reference time.
    pub(crate) fn placed(&mut self, pair: PartPair) -> [Placed<'s>; 2] {
        [pair.a, pair.b].map(|part| {
            if self.parts[part].setting != self.setting {
                self.bring_up_to_date(part);
            }
            Placed { solid: &self.scene.parts[part].solid, place: self.parts[part].place }
        })
    }

    /// How much narrower than at the reference time the gap of a pair across `n` (from a to b) can become
    /// on the interval, m.
    ///
    /// The pair must have been asked for by [`Moment::placed`] at this setting.
    pub(crate) fn loss(&self, pair: PartPair, requirement: &Requirement, n: &Vector3<f64>) -> f64 {
        self.approach(pair.a, requirement.first_joint, n)
            + self.approach(pair.b, requirement.first_joint, &-n)
    }

    /// B1: how far the joints from `first` on can move a part along `n`, m.
    fn approach(&self, part: usize, first: usize, n: &Vector3<f64>) -> f64 {
        let carrier = self.stage.mount(self.scene, part).carrier;
        let dof = self.axes.len();
        let mut sum = 0.0;
        for joint in first..carrier.arm_joints(dof) {
            let axis = &self.axes[joint];
            sum += match self.scene.robot.joints[joint].kind {
                JointKind::Revolute => {
                    let chord = self.chords[part * dof + joint];
                    if chord > 0.0 { chord * n.cross(axis).norm() } else { 0.0 }
                }
                JointKind::Prismatic => slide(n.dot(axis), &self.arm[joint]),
            };
        }
        if let Carrier::Finger(_) = carrier {
            sum += slide(n.dot(&self.parts[part].finger_axis), &self.finger);
        }
        sum
    }

    fn bring_up_to_date(&mut self, part: usize) {
        let scene = self.scene;
        let stage = self.stage;
        let mount = stage.mount(scene, part);
        let state = &mut self.parts[part];
        state.setting = self.setting;
        let last = self.world_from_link.len() - 1;
        match mount.carrier {
            Carrier::World => {
                let of_object = if scene.object_part == Some(part) { stage.object_place } else { None };
                state.place = of_object
                    .or(scene.parts[part].place)
                    .unwrap_or_else(|| Place::from(&mount.carrier_from_solid));
                return;
            }
            Carrier::Link(link) => {
                state.place = Place::from(&(self.world_from_link[link] * mount.carrier_from_solid));
            }
            Carrier::Finger(index) => {
                let finger = &scene.robot.gripper.fingers[index];
                let axis = finger.axis.into_inner();
                let world_from_closed = self.world_from_link[last] * finger.link_from_finger;
                let world_from_finger = world_from_closed * Translation3::from(axis * self.finger.reference);
                state.place = Place::from(&(world_from_finger * mount.carrier_from_solid));
                state.finger_axis = world_from_closed.rotation * axis;
            }
        }
        self.measure_chords(part);
    }

    fn measure_chords(&mut self, part: usize) {
        let mount = self.stage.mount(self.scene, part);
        let PartState { place, finger_axis, .. } = self.parts[part];
        let dof = self.axes.len();
        let joints = &self.scene.robot.joints;
        let chords = &mut self.chords[part * dof..(part + 1) * dof];
        let mut outer_chords = 0.0;
        for joint in (0..mount.carrier.arm_joints(dof)).rev() {
            let range = &self.arm[joint];
            let delta = range.below.max(range.above);
            chords[joint] = 0.0;
            if joints[joint].kind == JointKind::Prismatic || delta <= 0.0 {
                continue;
            }
            let axis = &self.axes[joint];
            let origin = &self.world_from_link[joint].translation.vector;
            let mut radius = (place.center - origin).cross(axis).norm() + mount.radial_extents[joint];
            if let Carrier::Finger(_) = mount.carrier {
                radius += self.finger.below.max(self.finger.above) * finger_axis.cross(axis).norm();
            }
            if self.scene.steady_axes {
                chords[joint] = chord(radius, delta);
                continue;
            }
            radius += outer_chords;
            let slides = |outer: &usize| joints[*outer].kind == JointKind::Prismatic;
            for outer in (joint + 1..mount.carrier.arm_joints(dof)).filter(slides) {
                let slide = self.arm[outer].below.max(self.arm[outer].above);
                radius += slide * self.axes[outer].cross(axis).norm();
            }
            chords[joint] = chord(radius, delta);
            outer_chords += chords[joint];
        }
    }
}

/// The longest chord, m, of a point at most `radius` (m) from an axis, when it turns by up to `delta` (rad).
fn chord(radius: f64, delta: f64) -> f64 {
    2.0 * radius * (0.5 * delta.min(std::f64::consts::PI)).sin()
}

/// How far a sliding joint whose axis has this share along a direction can move something along it, m.
fn slide(along: f64, range: &Range) -> f64 {
    (along * range.above).max(-along * range.below)
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
    use graspcheck_model::{plan::Plan, robot::RobotModel};
    use graspcheck_motion::{Polynomial, Trajectory};
    use proptest::prelude::*;

    use super::*;
    use crate::{
        contact::Occasion,
        fixtures::{self, Draw},
        stretch::{middle, stretches},
    };

    /// A chain of up to six joints with skewed axes and offsets, a box on each link, and an obstacle.
    fn random_chain(draw: &mut Draw, parallel: bool) -> RobotModel {
        let dof = draw.between(1.0, 6.999) as usize;
        let mut joints = Vec::new();
        let mut links = Vec::new();
        for index in 0..dof {
            let mut vector = |half: f64| Vector3::from_fn(|_, _| draw.between(-half, half));
            let (offset, turn, axis) = (vector(0.5), vector(3.0), vector(1.0));
            let (half, place) = (vector(0.2).abs().add_scalar(0.01), Pose::new(vector(0.3), vector(3.0)));
            let parent = Pose::new(offset, if parallel { Vector3::z() * turn.z } else { turn });
            let axis = if parallel { Vector3::z() } else { axis };
            let slides = draw.between(0.0, 1.0) < 0.3;
            let kind = if slides { JointKind::Prismatic } else { JointKind::Revolute };
            joints.push(fixtures::joint(&format!("joint_{index}"), kind, parent, axis));
            let shape = fixtures::boxed(half.x, half.y, half.z);
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

    /// Eight corners of a part's box in the world.
    fn corners(moment: &mut Moment, pair: PartPair, half: &Vector3<f64>) -> [Vector3<f64>; 8] {
        let [a, _] = moment.placed(pair);
        std::array::from_fn(|i| {
            let sign = |bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
            let corner = half.component_mul(&Vector3::new(sign(0), sign(1), sign(2)));
            a.place.center + a.place.rotation * corner
        })
    }

    fn no_corner_goes_farther(seed: u64, reach: f64, parallel: bool) {
        let mut draw = Draw(seed);
        let robot = random_chain(&mut draw, parallel);
        let obstacle = ("obstacle", fixtures::boxed(0.1, 0.1, 0.1), fixtures::at(3.0, 0.0, 0.0));
        let scene = Scene::new(&robot, &fixtures::cell(0.0, vec![obstacle]), None).unwrap();
        let plan = random_plan(&mut draw, robot.dof(), reach);
        let stage = Stage::new(&scene, &plan, Occasion::of(&plan, 0)).unwrap();
        let stretch = &stretches(&plan, robot.dof()).unwrap()[0];
        let (start, end) = (draw.between(0.0, 0.5), draw.between(0.5, 1.0));
        let n = Vector3::from_fn(|_, _| draw.between(-1.0, 1.0)).normalize();
        for (index, pair) in scene.pairs.iter().enumerate() {
            let crate::solid::Core::Box { half_extents } = scene.parts[pair.a].solid.core() else { continue };
            if scene.parts[pair.b].mount.carrier != Carrier::World {
                continue;
            }
            let requirement = &stage.requirements[index];
            let mut moment = Moment::new(&scene, &stage);
            moment.set(&stage, stretch, start, end);
            let before = corners(&mut moment, *pair, half_extents);
            let loss = moment.loss(*pair, requirement, &n);
            for step in 0..=20 {
                let t = start + (end - start) * f64::from(step) / 20.0;
                moment.set(&stage, stretch, t, t);
                let after = corners(&mut moment, *pair, half_extents);
                for (p, q) in before.iter().zip(after) {
                    let moved = n.dot(&(q - p));
                    assert!(moved <= loss + 1e-10, "part {}: moved {moved}, bound {loss}", pair.a);
                }
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        #[test]
        fn no_point_goes_farther_than_the_bound(seed: u64, reach in 0.001..4.0_f64, parallel: bool) {
            no_corner_goes_farther(seed, reach, parallel);
        }

        /// For any two parts, moving or not: the distance at any instant of an interval is at least the gap
        /// at its middle, across any normal, less the loss.
        #[test]
        fn no_gap_shrinks_by_more_than_the_loss(seed: u64, reach in 0.001..2.0_f64, parallel: bool) {
            let mut draw = Draw(seed);
            let robot = random_chain(&mut draw, parallel);
            let obstacle = ("obstacle", fixtures::boxed(0.1, 0.1, 0.1), fixtures::at(1.0, 0.0, 0.0));
            let scene = Scene::new(&robot, &fixtures::cell(0.0, vec![obstacle]), None).unwrap();
            let plan = random_plan(&mut draw, robot.dof(), reach);
            let stage = Stage::new(&scene, &plan, Occasion::of(&plan, 0)).unwrap();
            let stretch = &stretches(&plan, robot.dof()).unwrap()[0];
            let (start, end) = (draw.between(0.2, 0.5), draw.between(0.5, 0.8));
            let mut moment = Moment::new(&scene, &stage);
            for (pair, requirement) in scene.pairs.iter().zip(&stage.requirements) {
                moment.set(&stage, stretch, start, end);
                let [a, b] = moment.placed(*pair);
                let best = crate::gap::separation(&a, &b, None, 0.0).unwrap();
                let turned = best.normal + Vector3::from_fn(|_, _| draw.between(-0.3, 0.3));
                for n in [best.normal, turned.normalize()] {
                    moment.set(&stage, stretch, start, end);
                    let [a, b] = moment.placed(*pair);
                    let least = crate::gap::gap(&a, &b, &n) - moment.loss(*pair, requirement, &n);
                    for step in 0..=20 {
                        let t = start + (end - start) * f64::from(step) / 20.0;
                        moment.set(&stage, stretch, t, t);
                        let [a, b] = moment.placed(*pair);
                        let then = crate::gap::separation(&a, &b, None, 0.0).unwrap();
                        prop_assert!(then.upper >= least, "{then:?} {least}");
                    }
                }
            }
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
        let loss = moment.loss(scene.pairs[index], &stage.requirements[index], &Vector3::x());
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
            moment.loss(scene.pairs[index], &stage.requirements[index], &-Vector3::z())
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
