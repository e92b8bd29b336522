//! One formula for floats, intervals and rates: intervals hold what floats give, rates are slopes, and the
//! product of transforms is where quaternions and closed forms say.

use graspcheck_model::{
    chain::{SerialChain, Twist},
    dynamics::{Dynamics, Workspace},
    robot::RobotModel,
    spatial::{Frame, Vector},
    structure::PlanarGeometry,
    torque_bounds::TorqueBounds,
};
use graspcheck_motion::{Dual, Interval, MotionState, Polynomial, Scalar, Trajectory};
use nalgebra::Vector3;
use proptest::prelude::*;

use crate::arms;

const GRAVITY: Vector3<f64> = Vector3::new(1.0, -2.0, -9.0);

fn four() -> impl Strategy<Value = [f64; 4]> {
    proptest::array::uniform4(-2.0..2.0_f64)
}

fn four_jointed() -> impl Strategy<Value = RobotModel> {
    prop_oneof![Just(arms::scara()), Just(arms::spatial()), Just(arms::askew_scara())]
}

/// Intervals of half width `half` around numbers.
fn around(values: [f64; 4], half: f64) -> [Interval; 4] {
    values.map(|value| Interval::between(value - half, value + half))
}

/// Torques over intervals.
fn torques(dynamics: &Dynamics, [q, qd, qdd]: [[Interval; 4]; 3]) -> [Interval; 4] {
    let mut tau = [Interval::ZERO; 4];
    dynamics.inverse_of(&q, &qd, &qdd, &mut Workspace::new(4), &mut tau);
    tau
}

fn pieces(frame: &Frame<f64>) -> Vec<f64> {
    frame.rotation.0.iter().flat_map(|row| row.0).chain(frame.origin.0).collect()
}

/// A quintic motion of four joints from state to state, 1 s.
fn quintic(start: [f64; 4], end: [f64; 4], speed: [f64; 4]) -> Trajectory {
    let pieces = (0..4)
        .map(|k| Polynomial::quintic_hermite([start[k], speed[k], 0.0], [end[k], 0.0, speed[k]], 1.0))
        .collect();
    Trajectory::new(4, vec![0.0, 1.0], pieces).expect("one interval of four joints")
}

proptest! {
    #[test]
    fn torques_over_a_box_hold_those_of_every_state_in_it(
        robot in four_jointed(), q in four(), qd in four(), qdd in four(),
        log_half in -8.0..-0.5_f64, shares in proptest::array::uniform12(-1.0..=1.0_f64),
    ) {
        let half = 10.0_f64.powf(log_half);
        let mut dynamics = Dynamics::new(&robot, GRAVITY);
        let state = [around(q, half), around(qd, half), around(qdd, half)];
        let bounds = torques(&dynamics, state);
        let inside = |part: usize, k: usize| {
            let interval = state[part][k];
            (interval.middle() + shares[4 * part + k] * half).clamp(interval.lower(), interval.upper())
        };
        let [q, qd, qdd]: [[f64; 4]; 3] =
            std::array::from_fn(|part| std::array::from_fn(|k| inside(part, k)));
        let mut tau = [0.0; 4];
        dynamics.inverse(&q, &qd, &qdd, &mut tau);
        for (bound, torque) in bounds.iter().zip(tau) {
            prop_assert!(bound.contains(torque), "{bounds:?} {tau:?}");
        }
        // Half the box gives bounds inside, and not much wider than half as wide.
        let halved = state.map(|part| part.map(|x| Interval::between(x.middle() - half / 2.0, x.middle() + half / 2.0)));
        for (small, large) in torques(&dynamics, halved).into_iter().zip(bounds) {
            prop_assert!(small.is_within(large.widened(1e-12)), "{small} {large}");
            prop_assert!(small.width() <= 0.75 * large.width() + 1e-11, "{small} {large}");
        }
    }

    #[test]
    fn bounds_on_a_point_are_as_tight_as_rounding(robot in four_jointed(), q in four(), qd in four(), qdd in four()) {
        let bounds = torques(&Dynamics::new(&robot, GRAVITY), [around(q, 0.0), around(qd, 0.0), around(qdd, 0.0)]);
        for bound in bounds {
            prop_assert!(bound.width() < 1e-10, "{bounds:?}");
        }
    }

    #[test]
    fn rates_of_torques_are_their_slopes(robot in four_jointed(), q in four(), qd in four(), qdd in four(), qddd in four()) {
        let mut dynamics = Dynamics::new(&robot, GRAVITY);
        let dual = |value: [f64; 4], rate: [f64; 4]| -> [Dual<f64>; 4] {
            std::array::from_fn(|k| Dual { value: value[k], rate: rate[k] })
        };
        let mut rates = dual([0.0; 4], [0.0; 4]);
        dynamics.inverse_of(&dual(q, qd), &dual(qd, qdd), &dual(qdd, qddd), &mut Workspace::new(4), &mut rates);
        // The state a moment later and earlier, by Taylor.
        let step = 1e-5;
        let mut at = |t: f64| {
            let moved = |k: usize| {
                let p = Polynomial::new([q[k], qd[k], qdd[k] / 2.0, qddd[k] / 6.0]);
                p.eval(t)
            };
            let part = |order: usize| -> [f64; 4] { std::array::from_fn(|k| moved(k)[order]) };
            let mut tau = [0.0; 4];
            dynamics.inverse(&part(0), &part(1), &part(2), &mut tau);
            tau
        };
        let (before, after, now) = (at(-step), at(step), at(0.0));
        for k in 0..4 {
            let slope = (after[k] - before[k]) / (2.0 * step);
            prop_assert!((rates[k].rate - slope).abs() < 1e-5 * (1.0 + slope.abs()), "{rates:?} {slope}");
            prop_assert!((rates[k].value - now[k]).abs() < 1e-12 * (1.0 + now[k].abs()));
        }
    }

    #[test]
    fn torques_of_a_motion_stay_within_its_bounds(
        robot in four_jointed(), start in four(), end in four(), speed in four(),
        from in 0.0..1.0_f64, log_length in -4.0..0.0_f64,
    ) {
        let motion = quintic(start, end, speed);
        let to = (from + 10.0_f64.powf(log_length)).min(1.0);
        let mut dynamics = Dynamics::new(&robot, GRAVITY);
        let bounds = TorqueBounds::new(&dynamics.clone(), &motion).over(from, to).to_vec();
        let mut state = MotionState::zeros(4);
        for i in 0..=30 {
            motion.eval_into((from + (to - from) * f64::from(i) / 30.0).min(to), &mut state);
            let mut tau = [0.0; 4];
            dynamics.inverse(&state.q, &state.qd, &state.qdd, &mut tau);
            for (bound, torque) in bounds.iter().zip(tau) {
                let rounding = 1e-12 * (1.0 + bound.magnitude());
                prop_assert!(bound.widened(rounding).contains(torque), "{bound} {torque}");
            }
        }
    }

    #[test]
    fn the_product_of_transforms_is_where_quaternions_put_every_link(robot in four_jointed(), q in four()) {
        let chain = SerialChain::of(&robot);
        let mut frames = vec![Frame::constant(&graspcheck_model::Pose::identity()); 4];
        chain.links_into(&q, &mut frames);
        for (frame, pose) in frames.iter().zip(robot.forward(&q)) {
            prop_assert!((frame.to_pose().to_homogeneous() - pose.to_homogeneous()).amax() < 1e-14);
        }
        let tool = chain.tool(&q).to_pose();
        prop_assert!((tool.to_homogeneous() - robot.world_from_tool(&q).to_homogeneous()).amax() < 1e-14);
        prop_assert!((chain.jacobian(&q) - robot.tool_jacobian(&q)).amax() < 1e-14);
    }

    #[test]
    fn the_jacobian_is_what_dual_numbers_give(robot in four_jointed(), q in four(), qd in four()) {
        let chain = SerialChain::of(&robot);
        let moving: [Dual<f64>; 4] = std::array::from_fn(|k| Dual { value: q[k], rate: qd[k] });
        let tool = chain.tool(&moving);
        let expected = chain.jacobian(&q) * nalgebra::DVector::from_column_slice(&qd);
        for k in 0..3 {
            prop_assert!((tool.origin.0[k].rate - expected[k]).abs() < 1e-13);
        }
        // The axes of the tool turn with ω × axis.
        let omega = Vector3::new(expected[3], expected[4], expected[5]);
        let part = |of: fn(&Dual<f64>) -> f64, column: usize| {
            Vector3::from_fn(|row, _| of(&tool.rotation.0[row].0[column]))
        };
        for column in 0..3 {
            let turned = omega.cross(&part(|dual| dual.value, column));
            prop_assert!((part(|dual| dual.rate, column) - turned).amax() < 1e-13);
        }
    }

    #[test]
    fn frames_and_jacobians_over_a_box_hold_those_inside(
        robot in four_jointed(), q in four(), log_half in -8.0..-0.5_f64, shares in proptest::array::uniform4(-1.0..=1.0_f64),
    ) {
        let half = 10.0_f64.powf(log_half);
        let chain = SerialChain::of(&robot);
        let boxed = around(q, half);
        let point: [f64; 4] = std::array::from_fn(|k| {
            (q[k] + shares[k] * half).clamp(boxed[k].lower(), boxed[k].upper())
        });
        let bounds = chain.tool(&boxed);
        let found = pieces(&chain.tool(&point));
        let all: Vec<Interval> = bounds.rotation.0.iter().flat_map(|row| row.0).chain(bounds.origin.0).collect();
        for (bound, value) in all.iter().zip(found) {
            prop_assert!(bound.contains(value), "{bound} {value}");
            prop_assert!(bound.width() < 60.0 * half + 1e-13, "{bound} for {half}");
        }
        let zero = Twist { linear: Vector::zero(), angular: Vector::zero() };
        let mut columns = vec![zero; 4];
        chain.jacobian_into(&boxed, &mut columns);
        let jacobian = chain.jacobian(&point);
        for (k, column) in columns.iter().enumerate() {
            for (row, bound) in column.linear.0.iter().chain(&column.angular.0).enumerate() {
                prop_assert!(bound.contains(jacobian[(row, k)]), "{bound} {}", jacobian[(row, k)]);
            }
        }
    }

    #[test]
    fn closed_forms_are_the_product_of_transforms(q in four(), askew in any::<bool>()) {
        for robot in if askew { [arms::askew_scara(), arms::askew_rrr()] } else { [arms::scara(), arms::rrr()] } {
            let q = &q[..robot.dof()];
            let geometry = PlanarGeometry::of(&robot).expect("a planar arm");
            let closed = robot.world_from_base * geometry.forward(q);
            let product = SerialChain::of(&robot).tool(q).to_pose();
            prop_assert!((closed.to_homogeneous() - product.to_homogeneous()).amax() < 1e-13);
            let mut turned = geometry.jacobian(q);
            let world_from_base = robot.world_from_base.rotation;
            for mut column in turned.column_iter_mut() {
                for rows in [0, 3] {
                    let part: Vector3<f64> = column.fixed_rows::<3>(rows).into_owned();
                    column.fixed_rows_mut::<3>(rows).copy_from(&(world_from_base * part));
                }
            }
            prop_assert!((turned - SerialChain::of(&robot).jacobian(q)).amax() < 1e-13);
        }
    }
}

#[test]
fn where_an_acceleration_jumps_both_sides_count() {
    // Constant acceleration of 2 rad/s², then of −1 rad/s²: the torque jumps by 3 times the inertia.
    let pieces = [Polynomial::new([0.0, 0.0, 1.0]), Polynomial::new([1.0, 2.0, -0.5])];
    let still = Polynomial::constant(0.0);
    let all = pieces.into_iter().flat_map(|p| [p, still, still]).collect();
    let motion = Trajectory::new(3, vec![0.0, 1.0, 2.0], all).expect("two intervals of three joints");
    let dynamics = Dynamics::new(&arms::rrr(), Vector3::zeros());
    let inertia = dynamics.clone().mass_matrix(&[0.0; 3])[(0, 0)];
    let mut room = TorqueBounds::new(&dynamics, &motion);
    let torque = room.over(0.9, 1.1)[0];
    assert!(torque.contains(2.0 * inertia) && torque.contains(-inertia), "{torque}");
    assert!(torque.width() < 3.0 * inertia * (1.0 + 1e-2), "{torque}");
    let left = room.over(0.9, 1.0)[0];
    assert!(left.contains(2.0 * inertia) && !left.contains(1.9 * inertia), "{left}");
}

#[test]
fn friction_over_an_interval_has_every_sign_of_the_velocity() {
    let mut robot = arms::rrr();
    for joint in &mut robot.joints {
        (joint.damping, joint.friction) = (2.0, 3.0);
    }
    let dynamics = Dynamics::new(&robot, GRAVITY);
    let mut torque = [Interval::ZERO; 3];
    let velocities = [Interval::between(-0.5, 1.0), Interval::between(0.5, 1.0), Interval::ZERO];
    dynamics.friction_of(&velocities, &mut torque);
    assert_eq!(torque[0], Interval::between(-4.0, 5.0).hull(torque[0]));
    assert!(torque[0].width() < 9.0 + 1e-14 && torque[1].contains(5.0) && !torque[1].contains(3.9));
    assert_eq!(torque[2], Interval::ZERO);
}

/// The share of excess that the docs of [`graspcheck_model::torque_bounds`] state.
#[test]
fn the_excess_of_bounds_is_what_the_docs_say() {
    let motion = quintic([0.3, 0.4, -0.05, 0.1], [-0.9, -1.2, -0.25, 4.0], [0.0; 4]);
    let dynamics = Dynamics::new(&arms::scara(), Vector3::new(0.0, 0.0, -9.81));
    let mut by_floats = dynamics.clone();
    let mut room = TorqueBounds::new(&dynamics, &motion);
    let mut sampled = |from: f64, to: f64| {
        let mut range = [[f64::INFINITY, f64::NEG_INFINITY]; 4];
        let (mut state, mut tau) = (MotionState::zeros(4), [0.0; 4]);
        for i in 0..=200 {
            motion.eval_into((from + (to - from) * f64::from(i) / 200.0).min(1.0), &mut state);
            by_floats.inverse(&state.q, &state.qd, &state.qdd, &mut tau);
            for (range, torque) in range.iter_mut().zip(tau) {
                *range = [range[0].min(torque), range[1].max(torque)];
            }
        }
        range
    };
    let peaks = sampled(0.0, 1.0).map(|[low, high]| high.max(-low));
    let mut found = Vec::new();
    for parts in [10, 40, 160] {
        let mut worst = [0.0_f64; 2];
        for part in 0..parts {
            let [from, to] = [part, part + 1].map(|k| f64::from(k) / f64::from(parts));
            let range = sampled(from, to);
            let mut alone = [Interval::ZERO; 4];
            let state: [[Interval; 4]; 4] = std::array::from_fn(|joint| motion.enclose(joint, from, to));
            let order = |k: usize| -> [Interval; 4] { std::array::from_fn(|joint| state[joint][k]) };
            dynamics.inverse_of(&order(0), &order(1), &order(2), &mut Workspace::new(4), &mut alone);
            for (joint, bound) in room.over(from, to).iter().enumerate() {
                let width = range[joint][1] - range[joint][0];
                worst[0] = worst[0].max((alone[joint].width() - width) / peaks[joint]);
                worst[1] = worst[1].max((bound.width() - width) / peaks[joint]);
            }
        }
        found.push(worst);
    }
    for (worst, stated) in found.iter().zip([[0.75, 0.26], [0.20, 0.005], [0.06, 0.0004]]) {
        assert!(worst[0] < stated[0] && worst[1] < stated[1], "{found:?}");
    }
    assert!(found[1][1] < found[0][1] / 10.0 && found[2][1] < found[1][1] / 10.0, "{found:?}");
}

#[test]
fn a_scalar_constant_is_the_same_number_in_every_kind() {
    assert_eq!(Interval::from(0.1).scaled(3.0), Interval::point(0.1) * Interval::point(3.0));
    assert_eq!(Dual::<f64>::from(0.1).rate.to_bits(), 0.0_f64.to_bits());
}
