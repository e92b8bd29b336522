//! How much torque a plan takes at most, proved over continuous time.
//!
//! What a joint's motor must bring is `tau = M(q) qdd + V(q, qd) + G(q)` with the load that the phase holds, and
//! friction with the sign of the velocity. On a stretch of time the model bounds it from both sides
//! ([`TorqueBounds`]), and stretches are halved (`peak`). [`keep_torque_limits`] proves that every joint keeps its
//! limit; [`torque_peaks`] brings bounds on the largest torques together.
//!
//! Where a joint turns back its friction can have either sign, and both count.

use graspcheck_model::{
    dynamics::Dynamics,
    inertia::Inertial,
    object::Object,
    plan::{Holding, Plan},
    robot::RobotModel,
    torque_bounds::TorqueBounds,
};
use graspcheck_motion::Trajectory;
use nalgebra::Vector3;

use crate::{
    peak::{Bound, Bounded, Course, FoundPeak, Kept, MOST_STEPS, find_peaks, keep_limits},
    stretch::{cuts, middle},
};

/// How near the bounds of a largest torque are brought to each other when nothing else is asked for, as a share
/// of the joint's effort limit.
pub const TORQUE_TOLERANCE: f64 = 0.005;

/// Fingers whose masses differ by less than this share have the same mass.
const SAME_MASS: f64 = 1e-9;

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
    /// Whether the bounds are as near to each other as was asked for; if not, the search gave up.
    pub is_settled: bool,
}

/// Whether a plan keeps the effort limits of the joints.
#[derive(Clone, Debug, PartialEq)]
pub enum TorqueLimits {
    /// At every instant.
    Kept,
    /// A joint takes more.
    Exceeded {
        /// Index of the joint.
        joint: usize,
        /// When, s.
        time: f64,
        /// At least so much, N·m or N.
        torque: f64,
    },
    /// A joint comes too near to its limit to tell.
    Unknown {
        /// Index of the joint.
        joint: usize,
        /// When, s.
        time: f64,
    },
}

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
    let arms = Arms::of(robot, gravity, object, plan)?;
    let (courses, mut torques) = arms.torques(plan);
    let tolerances: Vec<f64> = robot.joints.iter().map(|joint| tolerance * joint.limits.effort).collect();
    let (peaks, is_settled) = find_peaks(&mut torques, &courses, &tolerances, MOST_STEPS);
    let named = |(joint, peak): (usize, FoundPeak)| {
        let FoundPeak { lower, upper, time, .. } = peak;
        let phase = plan.phases[plan.phase_index_at(time)].name.clone();
        TorquePeak { joint, lower, upper, time, phase, is_settled }
    };
    Ok(peaks.into_iter().enumerate().map(named).collect())
}

/// Whether every joint keeps `share` of its effort limit at every instant of a plan: the proof that
/// [`torque_peaks`] would give, too, but found sooner, and as near to the limit as rounding allows.
///
/// # Errors
/// As [`torque_peaks`].
pub fn keep_torque_limits(
    robot: &RobotModel,
    gravity: Vector3<f64>,
    object: Option<&Object>,
    plan: &Plan,
    share: f64,
) -> Result<TorqueLimits, String> {
    let arms = Arms::of(robot, gravity, object, plan)?;
    let (courses, mut torques) = arms.torques(plan);
    let limits: Vec<f64> = robot.joints.iter().map(|joint| share * joint.limits.effort).collect();
    Ok(match keep_limits(&mut torques, &courses, &limits) {
        Kept::Always => TorqueLimits::Kept,
        Kept::Not { quantity, time, value, .. } => {
            TorqueLimits::Exceeded { joint: quantity, time, torque: value }
        }
        Kept::Unknown { quantity, time, .. } => TorqueLimits::Unknown { joint: quantity, time },
    })
}

/// For each stretch of a plan the arm with what it may hold on it.
struct Arms {
    /// For each phase.
    of_phase: Vec<Vec<Dynamics>>,
    cuts: Vec<f64>,
}

impl Arms {
    fn of(
        robot: &RobotModel,
        gravity: Vector3<f64>,
        object: Option<&Object>,
        plan: &Plan,
    ) -> Result<Self, String> {
        let cuts = cuts(plan, robot.dof())?;
        let [left, right] = [0, 1].map(|finger| robot.gripper.fingers[finger].link.inertial.mass);
        if (left - right).abs() > SAME_MASS * left.max(right) {
            return Err(format!("fingers of {left} kg and {right} kg: torques are proved for equal ones"));
        }
        let of_phase = (0..plan.phases.len()).map(|phase| arms_of(robot, gravity, object, plan, phase));
        Ok(Self { of_phase: of_phase.collect(), cuts })
    }

    /// The torques of a plan as functions of time, and the courses over which they are to be bounded: each stretch
    /// with each of the arms that it may have.
    fn torques<'a>(&'a self, plan: &'a Plan) -> (Vec<Course>, Torques<'a>) {
        let mut arms = Vec::new();
        let first_of_phase: Vec<usize> = self
            .of_phase
            .iter()
            .map(|of_phase| {
                let first = arms.len();
                arms.extend(
                    of_phase.iter().map(|arm| TorqueBounds::new(arm, &plan.trajectory).with_friction()),
                );
                first
            })
            .collect();
        let (mut courses, mut of_course) = (Vec::new(), Vec::new());
        for ends in self.cuts.windows(2) {
            let [start, end] = [ends[0], ends[1]];
            let phase = plan.phase_index_at(middle(start, end));
            let piece = plan.trajectory.piece_at(middle(start, end));
            for arm in 0..self.of_phase[phase].len() {
                courses.push(Course { start, end });
                of_course.push((first_of_phase[phase] + arm, piece));
            }
        }
        (courses, Torques { motion: &plan.trajectory, arms, of_course })
    }
}

/// The torques of a plan as functions of time.
struct Torques<'a> {
    motion: &'a Trajectory,
    arms: Vec<TorqueBounds<'a>>,
    /// For each course the arm and the piece of the motion.
    of_course: Vec<(usize, usize)>,
}

impl Bounded for Torques<'_> {
    fn count(&self) -> usize {
        self.motion.dof()
    }

    fn sample_size(&self) -> usize {
        self.motion.dof()
    }

    fn sample(&mut self, course: usize, time: f64, sample: &mut [f64]) {
        let (arm, piece) = self.of_course[course];
        self.arms[arm].at(piece, time, sample);
    }

    fn bound(&mut self, course: usize, ends: [f64; 2], samples: [&[f64]; 3], bounds: &mut [Bound]) {
        let (arm, piece) = self.of_course[course];
        let is_short = ends[1] - ends[0] < SHORTEST_REVERSAL;
        for (found, bound) in self.arms[arm].on(piece, ends, samples).iter().zip(bounds) {
            *bound = Bound {
                most: found.all.magnitude(),
                attained: found.middle.mignitude(),
                undecided: if is_short { found.undecided } else { 0.0 },
            };
        }
    }
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
    fn a_limit_is_kept_just_above_the_peak_and_not_below() {
        let mut draw = fixtures::Draw(5);
        for robot in [fixtures::scara(), fixtures::six_axes()] {
            let dof = robot.dof();
            let ends: [Vec<f64>; 2] =
                std::array::from_fn(|_| (0..dof).map(|_| draw.between(-1.0, 1.0)).collect());
            let plan = fixtures::rest_to_rest(&ends[0], &ends[1], 0.8);
            let peaks = torque_peaks(&robot, GRAVITY, None, &plan, 1e-5).unwrap();
            assert!(peaks.iter().all(|peak| peak.is_settled));
            let worst = peaks.iter().map(|peak| peak.upper / robot.joints[peak.joint].limits.effort);
            let worst = worst.fold(0.0, f64::max);
            let kept = |share: f64| keep_torque_limits(&robot, GRAVITY, None, &plan, share).unwrap();
            assert_eq!(kept(worst * 1.001), TorqueLimits::Kept);
            let TorqueLimits::Exceeded { joint, time, torque } = kept(worst * 0.999) else {
                panic!("more than the limit is taken: {peaks:?}");
            };
            assert!(torque > 0.999 * worst * robot.joints[joint].limits.effort);
            // What is said to be taken at that instant is.
            let mut arm = Dynamics::new(&robot, GRAVITY);
            arm.set_load(0.05, None);
            let (state, mut tau) = (plan.trajectory.eval(time), vec![0.0; dof]);
            arm.inverse(&state.q, &state.qd, &state.qdd, &mut tau);
            assert!((tau[joint].abs() - torque).abs() < 1e-6 * torque, "{tau:?} {torque}");
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
        let rest = Trajectory::hold(&[0.5, 0.4, 0.1, 0.0], 1.5).unwrap();
        let mut plan = fixtures::rest_to_rest(&[0.0; 4], &[0.0; 4], 2.0);
        plan.trajectory = there.trajectory.then(&rest).unwrap();
        let peaks = torque_peaks(&robot, GRAVITY, None, &plan, 1e-4).unwrap();
        for (peak, sampled) in peaks.iter().zip(sampled(&robot, &plan)) {
            assert!(sampled <= peak.upper + 1e-9 && peak.upper <= sampled + 0.8 + 0.02, "{sampled} {peak:?}");
        }
    }
}
