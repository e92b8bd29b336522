//! How much torque a plan takes at most, proved over continuous time.
//!
//! What a joint's motor must bring is `tau = M(q) qdd + V(q, qd) + G(q)` with the load that the phase holds, and
//! friction with the sign of the velocity. On a stretch of time the model bounds it from both sides
//! ([`TorqueBounds`]), and the stretch with the largest bound is halved until the largest torque is known to a
//! tolerance (branch and bound): no instant takes more than the upper bound, and one takes the lower.
//!
//! Where a joint turns back its friction can have either sign, and both count.

use std::{cmp::Ordering, collections::BinaryHeap};

use graspcheck_model::{
    dynamics::Dynamics,
    inertia::Inertial,
    object::Object,
    plan::{Holding, Plan},
    robot::RobotModel,
    torque_bounds::TorqueBounds,
};
use graspcheck_motion::{Interval, MotionBounds};
use nalgebra::Vector3;

use crate::stretch::{middle, stretches};

/// How near the bounds of a largest torque are brought to each other when nothing else is asked for, as a share
/// of the joint's effort limit.
pub const TORQUE_TOLERANCE: f64 = 0.005;

/// Fingers whose masses differ by less than this share have the same mass.
const SAME_MASS: f64 = 1e-9;

/// A stretch shorter than this, s, is halved no more: at its ends a torque without friction differs by far less
/// than any tolerance.
const SHORTEST_STRETCH: f64 = 1e-6;

/// A stretch shorter than this, s, is not halved only to find out when a joint turns back in it, or whether it
/// stands still throughout: the sign of its friction would change all the same.
const SHORTEST_REVERSAL: f64 = 1e-3;

/// Certified bounds of the largest torque of one joint, and where it is met.
#[derive(Clone, Debug, PartialEq)]
pub struct TorquePeak {
    /// Index of the joint.
    pub joint: usize,
    /// At `time` the joint takes at least this, N·m or N.
    pub lower: f64,
    /// At no instant does it take more, N·m or N.
    pub upper: f64,
    /// When, s.
    pub time: f64,
    /// Name of the phase.
    pub phase: String,
}

/// A stretch with bounds of every joint's torque, ordered so that the least settled one is taken first.
struct Node {
    start: f64,
    end: f64,
    phase: usize,
    /// How far the largest upper bound exceeds what some instant is known to take, as a share of the limit.
    excess: f64,
    magnitudes: Vec<f64>,
    /// What of the magnitudes a shorter stretch would not reduce.
    undecided: Vec<f64>,
}

impl Ord for Node {
    fn cmp(&self, other: &Self) -> Ordering {
        self.excess.total_cmp(&other.excess).then_with(|| other.start.total_cmp(&self.start))
    }
}

impl PartialOrd for Node {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Node {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Node {}

/// The largest torque of every joint over a plan, between bounds that differ by at most `tolerance` of the
/// joint's effort limit, and by its dry friction where that is undecided.
///
/// The gripper counts with the least and the largest opening of a phase; between them its share of the torque is
/// between theirs, as both fingers have the same mass and move alike.
///
/// # Errors
/// Says in words what does not fit in the plan, or that the fingers differ in mass.
pub fn torque_peaks(
    robot: &RobotModel,
    gravity: Vector3<f64>,
    object: Option<&Object>,
    plan: &Plan,
    tolerance: f64,
) -> Result<Vec<TorquePeak>, String> {
    let stretches = stretches(plan, robot.dof())?;
    let [left, right] = [0, 1].map(|finger| robot.gripper.fingers[finger].link.inertial.mass);
    if (left - right).abs() > SAME_MASS * left.max(right) {
        return Err(format!("fingers of {left} kg and {right} kg: torques are proved for equal ones"));
    }
    let limits: Vec<f64> = robot.joints.iter().map(|joint| joint.limits.effort).collect();
    let arms = plan.phases.iter().enumerate().map(|(phase, _)| arms_of(robot, gravity, object, plan, phase));
    let arms: Vec<Vec<Dynamics>> = arms.collect();
    let mut bounds: Vec<Vec<TorqueBounds<'_>>> =
        arms.iter().map(|arms| arms.iter().map(TorqueBounds::new).collect()).collect();
    let mut motion = MotionBounds::zeros(robot.dof());
    let mut friction = vec![Interval::ZERO; robot.dof()];
    let mut peaks: Vec<TorquePeak> = (0..robot.dof())
        .map(|joint| TorquePeak { joint, lower: 0.0, upper: 0.0, time: 0.0, phase: String::new() })
        .collect();

    // Bounds a stretch, and lets the torque that some instant of it takes count for the peaks.
    let mut look = |start: f64, end: f64, phase: usize, peaks: &mut [TorquePeak]| {
        plan.trajectory.enclose_into(start, end, &mut motion);
        arms[phase][0].friction_of(&motion.qd, &mut friction);
        let mut magnitudes = vec![0.0_f64; limits.len()];
        let is_short = end - start < SHORTEST_REVERSAL;
        let undecided = friction.iter().map(|it| if is_short { it.width() } else { 0.0 }).collect();
        for arm in &mut bounds[phase] {
            let torques = arm.over(&plan.trajectory, start, end);
            for (joint, torque) in torques.iter().enumerate() {
                let total = *torque + friction[joint];
                magnitudes[joint] = magnitudes[joint].max(total.magnitude());
                if total.mignitude() > peaks[joint].lower {
                    peaks[joint].lower = total.mignitude();
                    peaks[joint].time = middle(start, end);
                    peaks[joint].phase.clone_from(&plan.phases[phase].name);
                }
            }
        }
        Node { start, end, phase, excess: 0.0, magnitudes, undecided }
    };
    let excess = |node: &Node, peaks: &[TorquePeak]| {
        let of_joint = |joint: usize| {
            (node.magnitudes[joint] - node.undecided[joint] - peaks[joint].lower) / limits[joint]
        };
        (0..limits.len()).map(of_joint).fold(0.0, f64::max)
    };

    let mut heap = BinaryHeap::with_capacity(4 * stretches.len());
    for stretch in &stretches {
        let mut node = look(stretch.start, stretch.end, stretch.phase, &mut peaks);
        node.excess = excess(&node, &peaks);
        heap.push(node);
    }
    while let Some(node) = heap.pop() {
        if excess(&node, &peaks) <= tolerance || node.end - node.start < SHORTEST_STRETCH {
            for (peak, magnitude) in peaks.iter_mut().zip(&node.magnitudes) {
                peak.upper = peak.upper.max(*magnitude);
            }
            continue;
        }
        let half = middle(node.start, node.end);
        for (start, end) in [(node.start, half), (half, node.end)] {
            let mut child = look(start, end, node.phase, &mut peaks);
            for (magnitude, above) in child.magnitudes.iter_mut().zip(&node.magnitudes) {
                *magnitude = magnitude.min(*above);
            }
            child.excess = excess(&child, &peaks);
            heap.push(child);
        }
    }
    Ok(peaks)
}

/// The arm with what it may hold in a phase, at the least and the largest opening of the phase. While the fingers
/// close and open the object may or may not weigh on them.
fn arms_of(
    robot: &RobotModel,
    gravity: Vector3<f64>,
    object: Option<&Object>,
    plan: &Plan,
    phase: usize,
) -> Vec<Dynamics> {
    let phase = &plan.phases[phase];
    let load = object.zip(plan.grasp.as_ref()).map(|(object, grasp)| grasp.load(robot, object));
    let loads = match phase.holding {
        Holding::Held => vec![load],
        Holding::Closing | Holding::Opening => vec![None, load],
        Holding::Nothing | Holding::AtStart | Holding::Placed => vec![None],
    };
    let [start, end] = [phase.start, phase.end].map(|time| time.clamp(0.0, plan.opening.duration()));
    let [narrow, wide] = plan.opening.range_in(0, 0, start, end).map(|extremum| extremum.value);
    let mut openings = vec![narrow];
    openings.extend((wide > narrow).then_some(wide));
    let arm = |opening: f64, load: Option<&Inertial>| {
        let mut arm = Dynamics::new(robot, gravity);
        arm.set_load(opening, load);
        arm
    };
    let all = openings.iter().flat_map(|&opening| loads.iter().map(move |load| (opening, load)));
    all.map(|(opening, load)| arm(opening, load.as_ref())).collect()
}

#[cfg(test)]
mod tests {
    use graspcheck_model::robot::JointKind;

    use super::*;
    use crate::fixtures::{self, at, boxed};

    const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

    /// What sampling finds, at 20 kHz.
    fn sampled(robot: &RobotModel, plan: &Plan) -> Vec<f64> {
        let mut arm = Dynamics::new(robot, GRAVITY);
        arm.set_load(0.05, None);
        let (mut tau, mut friction) = (vec![0.0; robot.dof()], vec![0.0; robot.dof()]);
        let mut most = vec![0.0_f64; robot.dof()];
        let steps = (plan.duration() * 20_000.0) as usize;
        for step in 0..=steps {
            let state = plan.trajectory.eval(plan.duration() * step as f64 / steps as f64);
            arm.inverse(&state.q, &state.qd, &state.qdd, &mut tau);
            arm.friction(&state.qd, &mut friction);
            for joint in 0..robot.dof() {
                most[joint] = most[joint].max((tau[joint] + friction[joint]).abs());
            }
        }
        most
    }

    #[test]
    fn a_pendulum_takes_what_the_closed_form_says() {
        // One rod of 2 kg with its centre 0.5 m out, turning about y from hanging sideways to 30° below.
        let mut robot = fixtures::robot(
            vec![fixtures::joint("pivot", JointKind::Revolute, at(0.0, 0.0, 0.0), Vector3::y())],
            vec![fixtures::link("rod", vec![])],
        );
        robot.links[0].inertial =
            Inertial { mass: 2.0, center: [0.5, 0.0, 0.0].into(), ..robot.links[0].inertial.clone() };
        for finger in &mut robot.gripper.fingers {
            finger.link.inertial = Inertial::massless();
        }
        let plan = fixtures::rest_to_rest(&[0.0], &[0.5], 10.0);
        let peak = &torque_peaks(&robot, GRAVITY, None, &plan, 1e-4).unwrap()[0];
        // Nearly at rest: gravity alone, 2 · 9.81 · 0.5 N·m, less at every later instant.
        let still = 2.0 * 9.81 * 0.5;
        assert!(peak.lower <= peak.upper && (peak.upper - still).abs() < 0.05, "{peak:?}");
    }

    #[test]
    fn no_sample_takes_more_and_one_takes_nearly_as_much() {
        let mut draw = fixtures::Draw(11);
        for _ in 0..12 {
            let mut robot = fixtures::scara();
            for joint in &mut robot.joints {
                joint.damping = 0.3;
                joint.rotor_inertia = 0.01;
            }
            let from: Vec<f64> = (0..4).map(|_| draw.between(-1.0, 1.0)).collect();
            let to: Vec<f64> = (0..4).map(|_| draw.between(-1.0, 1.0)).collect();
            let plan = fixtures::rest_to_rest(&from, &to, draw.between(0.3, 1.5));
            let peaks = torque_peaks(&robot, GRAVITY, None, &plan, 0.002).unwrap();
            for (peak, sampled) in peaks.iter().zip(sampled(&robot, &plan)) {
                let slack = 0.002 * robot.joints[peak.joint].limits.effort;
                assert!(sampled <= peak.upper + 1e-9, "{sampled} {peak:?}");
                assert!(peak.lower <= sampled + 1e-3 && peak.upper <= peak.lower + slack + 1e-9, "{peak:?}");
            }
        }
    }

    #[test]
    fn a_load_counts_while_it_is_held_and_only_then() {
        let robot = fixtures::scara();
        let object = Object {
            name: "brick".to_owned(),
            shape: boxed(0.02, 0.02, 0.02),
            mass: 3.0,
            friction: 0.8,
            world_from_object: at(0.0, 0.0, 0.0),
            handles: vec![],
        };
        let mut plan = fixtures::rest_to_rest(&[0.0; 4], &[0.0, 0.0, 0.1, 0.0], 2.0);
        let free = torque_peaks(&robot, GRAVITY, Some(&object), &plan, 1e-3).unwrap();
        plan.phases[0].holding = Holding::Held;
        plan.grasp = Some(graspcheck_model::plan::Grasp {
            handle: String::new(),
            tool_from_object: at(0.0, 0.0, 0.0),
            width: 0.04,
            opening: 0.05,
            force: 1.0,
            world_from_start: at(0.0, 0.0, 0.0),
            world_from_placed: at(0.0, 0.0, 0.0),
        });
        let held = torque_peaks(&robot, GRAVITY, Some(&object), &plan, 1e-3).unwrap();
        // The quill lifts 3 kg more: 3 · (9.81 + 10/√3 · 0.1/4) N at the peak of the quintic.
        let more = 3.0 * (9.81 + 10.0 / 3.0_f64.sqrt() * 0.1 / 4.0);
        assert!((held[2].upper - free[2].upper - more).abs() < 0.2, "{held:?} {free:?}");
        // It may still weigh on fingers that open.
        plan.phases[0].holding = Holding::Opening;
        let opening = torque_peaks(&robot, GRAVITY, Some(&object), &plan, 1e-3).unwrap();
        assert!((opening[2].upper - held[2].upper).abs() < 0.2, "{opening:?}");
    }

    #[test]
    fn a_plan_that_does_not_fit_is_refused() {
        let plan = fixtures::rest_to_rest(&[0.0], &[1.0], 1.0);
        assert!(torque_peaks(&fixtures::scara(), GRAVITY, None, &plan, 0.01).is_err());
    }

    /// Where a joint rests its dry friction is undecided, however long it rests; that must not take long.
    #[test]
    fn rests_and_reversals_with_dry_friction_are_settled() {
        let mut robot = fixtures::scara();
        for joint in &mut robot.joints {
            joint.friction = 0.4;
        }
        let there = fixtures::rest_to_rest(&[0.0; 4], &[0.5, 0.4, 0.1, 0.0], 0.5);
        let rest = graspcheck_motion::Trajectory::hold(&[0.5, 0.4, 0.1, 0.0], 1.5).unwrap();
        let mut plan = fixtures::rest_to_rest(&[0.0; 4], &[0.0; 4], 2.0);
        plan.trajectory = there.trajectory.then(&rest).unwrap();
        let peaks = torque_peaks(&robot, GRAVITY, None, &plan, 1e-4).unwrap();
        for (peak, sampled) in peaks.iter().zip(sampled(&robot, &plan)) {
            assert!(sampled <= peak.upper + 1e-9 && peak.upper <= sampled + 0.8 + 0.02, "{sampled} {peak:?}");
        }
    }
}
