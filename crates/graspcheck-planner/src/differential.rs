//! From the motion of the tool to the motion of the joints: velocity and acceleration.
//!
//! With `J` the Jacobian of the tool, linear rows above angular ones, both in the world frame,
//! `ξ = J qd` and `ξ̇ = J qdd + J̇ qd` (Siciliano et al., *Robotics: Modelling, Planning and Control*,
//! sections 3.1 and 3.5). Both are solved for the joints by a QR decomposition, which also serves arms
//! with fewer than six joints as long as the tool's motion is one that they can make.
//!
//! Symbols used as names: `qd qdd` are velocity and acceleration of the joints.

use nalgebra::{DVector, Matrix6xX, Vector3, Vector6};

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
