//! Peaks of joint motions and of torques, held against dense samples of polynomials and of a law of motion in the world
//! frame that are the judge's own.

use graspcheck_model::{plan::Plan, robot::RobotModel};
use graspcheck_motion::{Polynomial, Trajectory, bernstein};
use graspcheck_proof::torque_peaks;
use nalgebra::Vector3;

use crate::trial::{
    arms::Arm,
    fixtures::Draw,
    forces::torques,
    random::{Case, trajectory},
    relations,
};

/// Rounding of a value, as a share of the sum of its terms.
const ROUNDING: f64 = 1e-12;

/// The derivative of an order at local time `tau`, and the sum of the magnitudes of its terms.
fn derivative(polynomial: &Polynomial, order: usize, tau: f64) -> (f64, f64) {
    let terms = polynomial.coefficients().iter().enumerate().skip(order).map(|(power, c)| {
        let factor: f64 = (0..order).map(|k| (power - k) as f64).product();
        c * factor * tau.powi((power - order) as i32)
    });
    terms.fold((0.0, 0.0), |(sum, size), term| (sum + term, size + term.abs()))
}

#[test]
fn no_sample_exceeds_a_peak_and_limits_beside_it_are_told_apart() {
    const SAMPLES: u32 = 400;
    for arm in Arm::ALL {
        for seed in 0..12 {
            let mut draw = Draw(seed);
            let robot = arm.robot(&mut draw);
            let motion = trajectory(&robot, arm, &mut draw);
            for joint in 0..robot.dof() {
                for order in 0..4 {
                    let peak = motion.peak(joint, order);
                    let (mut largest, mut at_time) = (0.0_f64, f64::INFINITY);
                    for piece in 0..motion.piece_count() {
                        let (start, end) = (motion.knots()[piece], motion.knots()[piece + 1]);
                        let polynomial = motion.piece(piece, joint);
                        for sample in 0..=SAMPLES {
                            let tau = (end - start) * f64::from(sample) / f64::from(SAMPLES);
                            let (value, size) = derivative(polynomial, order, tau);
                            largest = largest.max(value.abs() - ROUNDING * size);
                        }
                        if (start..=end).contains(&peak.time) {
                            let (value, size) = derivative(polynomial, order, peak.time - start);
                            at_time = at_time.min((value - peak.value).abs() - 1e3 * ROUNDING * size);
                        }
                    }
                    let which = format!("{} {seed}, joint {joint}, order {order}: {peak:?}", arm.name());
                    assert!(largest <= peak.value.abs(), "{which}, but {largest}");
                    assert!(at_time <= 0.0, "{which} is not taken then");
                    assert_limits_are_told_apart(&motion, joint, order, peak.value.abs(), &which);
                }
            }
        }
    }
}

fn is_outside(proof: &bernstein::Proof) -> bool {
    matches!(proof, bernstein::Proof::Outside { .. })
}

/// A limit 0.01 % above the peak is proved, one 0.01 % below is refuted.
fn assert_limits_are_told_apart(motion: &Trajectory, joint: usize, order: usize, peak: f64, which: &str) {
    let proofs = |limit: f64| {
        let pieces = 0..motion.piece_count();
        let proofs = pieces.map(|piece| {
            let h = motion.knots()[piece + 1] - motion.knots()[piece];
            bernstein::proves_within(motion.piece(piece, joint), order, h, -limit, limit)
        });
        proofs.collect::<Vec<_>>()
    };
    let above = proofs(peak * 1.0001);
    assert!(above.iter().all(|proof| *proof == bernstein::Proof::Within), "{which}: {above:?}");
    let below = proofs(peak * 0.9999);
    assert!(below.iter().any(is_outside), "{which}: {below:?}");
}

#[test]
fn a_cubic_that_overshoots_by_a_thousandth_between_its_waypoints_is_caught() {
    // From rest at 0 to 1, where it moves back: it swings over 1 just before. The speed is found by halving.
    let overshoot = 0.001;
    let cubic = |speed: f64| Polynomial::new([0.0, 0.0, 3.0 - speed, speed - 2.0]);
    let peak = |speed: f64| cubic(speed).range(0, 0.0, 1.0)[1].value;
    let (mut low, mut high) = (-1.0, 0.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if peak(middle) > 1.0 + overshoot { low = middle } else { high = middle }
    }
    let polynomial = cubic(low);
    assert!((peak(low) - 1.001).abs() < 1e-9 && derivative(&polynomial, 0, 1.0).0 <= 1.0 + 1e-12);
    let proof = |limit: f64| bernstein::proves_within(&polynomial, 0, 1.0, -limit, limit);
    assert!(is_outside(&proof(1.0009)) && proof(1.0011) == bernstein::Proof::Within);
    let motion = Trajectory::new(1, vec![0.0, 1.0], vec![polynomial]).unwrap();
    assert!(motion.peak(0, 0).value > 1.0009 && !motion.exceeds(0, 0, -1.0, 1.0).is_empty());
}

/// What the motors bring at an instant by the judge, friction included.
fn with_friction(robot: &RobotModel, case: &Case, gravity: &Vector3<f64>, t: f64) -> Vec<f64> {
    let mut torques = torques(case, gravity, t);
    let state = case.plan.trajectory.eval(t);
    for (joint, torque) in
        robot.joints.iter().zip(&mut torques).enumerate().map(|(index, it)| ((index, it.0), it.1))
    {
        let (index, joint) = joint;
        let speed = state.qd[index];
        let sign = if speed.abs() > 0.0 { speed.signum() } else { 0.0 };
        *torque += joint.damping * speed + joint.friction * sign;
    }
    torques
}

#[test]
fn no_sampled_torque_exceeds_a_proved_peak() {
    /// Share of the effort limit.
    const TOLERANCE: f64 = 0.005;
    let gravity = Vector3::new(1.0, -2.0, -9.0);
    for arm in Arm::ALL {
        for seed in 0..6 {
            // Five times slower, as an arm within its limits: the bounds of wild motions stay wide.
            let mut case = relations::slowed(&Case::of_the_arm_alone(arm, &mut Draw(seed)), 5.0);
            // A peak counts the least and the largest opening of a phase, samples that of their instant: here it stands.
            let opening = case.plan.opening.eval(0.0).q[0];
            case.plan.opening = Trajectory::hold(&[opening], case.plan.duration()).unwrap();
            let Plan { trajectory, .. } = &case.plan;
            let peaks = torque_peaks(&case.robot, gravity, case.object.as_ref(), &case.plan, TOLERANCE)
                .expect("the plan fits the robot");
            let samples = (trajectory.duration() * 2e3) as u32;
            let mut largest = vec![0.0_f64; case.robot.dof()];
            for sample in 0..=samples {
                let t = trajectory.duration() * (f64::from(sample) / f64::from(samples));
                let torques = with_friction(&case.robot, &case, &gravity, t);
                largest
                    .iter_mut()
                    .zip(torques)
                    .for_each(|(largest, torque)| *largest = largest.max(torque.abs()));
            }
            for (peak, (largest, joint)) in peaks.iter().zip(largest.iter().zip(&case.robot.joints)) {
                let which = format!("{} {seed}: {peak:?}, sampled {largest}", arm.name());
                let rounding = 1e-9 * (1.0 + peak.upper);
                assert!(*largest <= peak.upper + rounding && peak.lower <= peak.upper, "{which}");
                // Where a joint turns back its friction may have either sign. A search on a chain of any axes may end by
                // its budget, wider.
                let open = 2.0 * TOLERANCE * joint.limits.effort + 2.0 * joint.friction + 0.01 * peak.upper;
                assert!(arm == Arm::Chain || peak.upper <= largest + open, "{which}");
                let there = with_friction(&case.robot, &case, &gravity, peak.time)[peak.joint].abs();
                assert!(there >= peak.lower - rounding, "{which}: {there} then");
            }
        }
    }
}
