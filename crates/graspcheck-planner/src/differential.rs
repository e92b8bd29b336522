//! From the motion of the tool to the motion of the joints: velocity and acceleration.
//!
//! With `J` the Jacobian of the tool, linear rows above angular ones, both in the world frame,
//! `ξ = J qd` and `ξ̇ = J qdd + J̇ qd` (Siciliano et al., *Robotics: Modelling, Planning and Control*,
//! sections 3.1 and 3.5). Both are solved for the joints by a QR decomposition, which also serves arms
//! with fewer than six joints as long as the tool's motion is one that they can make.
//!
//! Symbols used as names: `qd qdd` are velocity and acceleration of the joints.

use nalgebra::{DVector, Matrix6xX, Vector3, Vector6};

/// Smallest diagonal element of the triangular factor, relative to the largest, at which a Jacobian still
/// counts as one of full rank.
///
/// The reason: rounding leaves 1e-16 of a zero, and an arm that is followed keeps far from singular.
const RANK_TOLERANCE: f64 = 1e-9;

/// Velocities and accelerations of the joints that give the tool the velocity `twist` and the acceleration
/// `twist_rate` (linear then angular, world frame, m/s and rad/s, m/s² and rad/s²).
///
/// None when the Jacobian has no full rank. The part of the tool's motion that the arm cannot make is
/// ignored; whoever follows a path has found it reachable before.
pub(crate) fn joint_rates(
    jacobian: &Matrix6xX<f64>,
    twist: &Vector6<f64>,
    twist_rate: &Vector6<f64>,
) -> Option<(DVector<f64>, DVector<f64>)> {
    let decomposition = jacobian.clone().qr();
    let (q, r) = (decomposition.q(), decomposition.r());
    let diagonal = r.diagonal().abs();
    if diagonal.min() <= RANK_TOLERANCE * diagonal.max() {
        return None;
    }
    let qd = r.solve_upper_triangular(&q.tr_mul(twist))?;
    let rest = twist_rate - jacobian_rate_times(jacobian, &qd);
    let qdd = r.solve_upper_triangular(&q.tr_mul(&rest))?;
    Some((qd, qdd))
}

/// `J̇ qd`: the acceleration that the tool has when the joints keep their velocities `qd`.
///
/// For a serial chain with columns `(vᵢ, ωᵢ)` the derivative of column i by joint j is `(ωⱼ × vᵢ, ωⱼ × ωᵢ)`
/// for `j ≤ i` and `(ωᵢ × vⱼ, 0)` for `j > i` (Bruyninckx and De Schutter, "Symbolic differentiation of the
/// velocity mapping for a serial kinematic chain", *Mechanism and Machine Theory* 31, 1996).
fn jacobian_rate_times(jacobian: &Matrix6xX<f64>, qd: &DVector<f64>) -> Vector6<f64> {
    let linear = |joint: usize| -> Vector3<f64> { jacobian.fixed_view::<3, 1>(0, joint).into_owned() };
    let angular = |joint: usize| -> Vector3<f64> { jacobian.fixed_view::<3, 1>(3, joint).into_owned() };
    let mut linear_sum = Vector3::zeros();
    let mut angular_sum = Vector3::zeros();
    for i in 0..qd.len() {
        for j in 0..qd.len() {
            let rate = qd[i] * qd[j];
            if j <= i {
                linear_sum += angular(j).cross(&linear(i)) * rate;
                angular_sum += angular(j).cross(&angular(i)) * rate;
            } else {
                linear_sum += angular(i).cross(&linear(j)) * rate;
            }
        }
    }
    let mut sum = Vector6::zeros();
    sum.fixed_rows_mut::<3>(0).copy_from(&linear_sum);
    sum.fixed_rows_mut::<3>(3).copy_from(&angular_sum);
    sum
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;
    use proptest::prelude::*;

    use super::*;
    use crate::robots::{pose, rrr, scara};

    /// Joint positions along a motion that has all derivatives, with velocities and accelerations.
    fn wave(base: &[f64], t: f64) -> [Vec<f64>; 3] {
        let sum = |of: &dyn Fn(f64, f64) -> f64| {
            base.iter().enumerate().map(|(joint, &q)| of(q, 1.0 + 0.3 * joint as f64)).collect()
        };
        [
            sum(&|q, rate| q + 0.4 * (rate * t).sin()),
            sum(&|_, rate| 0.4 * rate * (rate * t).cos()),
            sum(&|_, rate| -0.4 * rate * rate * (rate * t).sin()),
        ]
    }

    proptest! {
        #[test]
        fn joint_rates_undo_the_motion_of_the_tool(
            q in [-1.5..1.5, 0.6..2.5, -0.3..0.3, -3.0..3.0],
            t in -1.0..1.0,
            planar: bool,
        ) {
            let mut robot = if planar { rrr() } else { scara() };
            robot.world_from_base = pose([0.3, -0.2, 0.1], [0.4, -1.1, 2.0]);
            let base = &q[..robot.dof()];
            let twist_at = |t: f64| {
                let [q, qd, _] = wave(base, t);
                robot.tool_jacobian(&q) * DVector::from_vec(qd)
            };
            // A second way to the twist: differences of the pose.
            let step = 1e-5;
            let pose_at = |t: f64| -> Isometry3<f64> { robot.world_from_tool(&wave(base, t)[0]) };
            let (before, after) = (pose_at(t - step), pose_at(t + step));
            let linear = (after.translation.vector - before.translation.vector) / (2.0 * step);
            let angular = (after.rotation * before.rotation.inverse()).scaled_axis() / (2.0 * step);
            let twist = twist_at(t);
            prop_assert!((twist.fixed_rows::<3>(0) - linear).norm() < 1e-7);
            prop_assert!((twist.fixed_rows::<3>(3) - angular).norm() < 1e-7);

            let twist_rate = (twist_at(t + step) - twist_at(t - step)) / (2.0 * step);
            let [q, expected_qd, expected_qdd] = wave(base, t);
            let jacobian = robot.tool_jacobian(&q);
            prop_assume!(q[1].sin().abs() > 0.2);
            let (qd, qdd) = joint_rates(&jacobian, &twist, &twist_rate).unwrap();
            prop_assert!((qd - DVector::from_vec(expected_qd)).norm() < 1e-10);
            prop_assert!((qdd - DVector::from_vec(expected_qdd)).norm() < 1e-6);
        }
    }

    #[test]
    fn a_straight_arm_has_no_joint_rates() {
        let jacobian = rrr().tool_jacobian(&[0.0, 0.0, 0.0]);
        let twist = Vector6::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        assert!(joint_rates(&jacobian, &twist, &Vector6::zeros()).is_none());
    }
}
