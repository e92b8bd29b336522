//! Inverse dynamics against closed forms and against the energy of the moving arm.

use graspcheck_model::{
    dynamics::Dynamics,
    inertia::Inertial,
    robot::{JointKind, RobotModel},
};
use nalgebra::{DMatrix, DVector, Matrix3xX, Vector3};
use proptest::prelude::*;

use crate::arms;

const GRAVITY: Vector3<f64> = Vector3::new(0.0, -9.81, 0.0);

/// Two links with point masses at their ends; a third joint at the end of link 2 carries nothing.
fn two_point_masses(l1: f64, l2: f64, m1: f64, m2: f64) -> RobotModel {
    let revolute =
        |name, x| arms::joint(name, JointKind::Revolute, arms::pose([x, 0.0, 0.0], [0.0; 3]), [-3.0, 3.0]);
    arms::arm(
        vec![revolute("shoulder", 0.0), revolute("elbow", l1)],
        vec![arms::point_mass(m1, [l1, 0.0, 0.0]), arms::point_mass(m2, [l2, 0.0, 0.0])],
        arms::pose([l2, 0.0, 0.0], [0.0; 3]),
    )
}

proptest! {
    /// Section 2 of the worked examples.
    #[test]
    fn two_point_masses_follow_the_closed_form(
        l in proptest::array::uniform2(0.1..4.0_f64),
        m in proptest::array::uniform2(0.1..20.0_f64),
        q in proptest::array::uniform2(-3.0..3.0_f64),
        qd in proptest::array::uniform2(-3.0..3.0_f64),
        qdd in proptest::array::uniform2(-3.0..3.0_f64),
    ) {
        let ([l1, l2], [m1, m2], g) = (l, m, 9.81);
        let (s2, c2) = q[1].sin_cos();
        let (c1, c12) = (q[0].cos(), (q[0] + q[1]).cos());
        let m11 = l2 * l2 * m2 + 2.0 * l1 * l2 * m2 * c2 + l1 * l1 * (m1 + m2);
        let m12 = l2 * l2 * m2 + l1 * l2 * m2 * c2;
        let m22 = l2 * l2 * m2;
        let coupling = m2 * l1 * l2 * s2;
        let v = [-coupling * qd[1] * qd[1] - 2.0 * coupling * qd[0] * qd[1], coupling * qd[0] * qd[0]];
        let weight = [m2 * l2 * g * c12 + (m1 + m2) * l1 * g * c1, m2 * l2 * g * c12];
        let expected = [
            m11 * qdd[0] + m12 * qdd[1] + v[0] + weight[0],
            m12 * qdd[0] + m22 * qdd[1] + v[1] + weight[1],
        ];

        let mut dynamics = Dynamics::new(&two_point_masses(l1, l2, m1, m2), GRAVITY);
        let mut tau = [0.0; 2];
        dynamics.inverse(&q, &qd, &qdd, &mut tau);
        let scale = 1.0 + (m1 + m2) * (l1 + l2) * (l1 + l2) * 60.0;
        for (found, wanted) in tau.into_iter().zip(expected) {
            prop_assert!((found - wanted).abs() < 1e-13 * scale, "{found} {wanted}");
        }
        let matrix = dynamics.mass_matrix(&q);
        let closed = DMatrix::from_row_slice(2, 2, &[m11, m12, m12, m22]);
        prop_assert!((matrix - closed).amax() < 1e-13 * scale);
    }
}

/// Kinetic (without and with rotors) and potential energy from forward kinematics alone.
struct Energy<'a> {
    robot: &'a RobotModel,
    gravity: Vector3<f64>,
}

impl Energy<'_> {
    /// All bodies with the poses of the links that carry them, and the index of that link.
    fn mass_matrix(&self, q: &[f64]) -> DMatrix<f64> {
        let dof = q.len();
        let poses = self.robot.forward(q);
        let mut matrix = DMatrix::from_diagonal(&DVector::from_iterator(
            dof,
            self.robot.joints.iter().map(|joint| joint.rotor_inertia),
        ));
        for (k, link) in self.robot.links.iter().enumerate() {
            let body = link.inertial.transformed(&poses[k]);
            let (mut linear, mut angular) = (Matrix3xX::zeros(dof), Matrix3xX::zeros(dof));
            for (j, (joint, pose)) in self.robot.joints.iter().zip(&poses).enumerate().take(k + 1) {
                let axis = pose * joint.axis.into_inner();
                match joint.kind {
                    JointKind::Revolute => {
                        let arm = body.center.coords - pose.translation.vector;
                        linear.set_column(j, &axis.cross(&arm));
                        angular.set_column(j, &axis);
                    }
                    JointKind::Prismatic => linear.set_column(j, &axis),
                }
            }
            matrix += linear.transpose() * &linear * body.mass + angular.transpose() * body.tensor * &angular;
        }
        matrix
    }

    fn potential(&self, q: &[f64]) -> f64 {
        let poses = self.robot.forward(q);
        let links = self.robot.links.iter().zip(&poses);
        links.map(|(l, pose)| -l.inertial.mass * self.gravity.dot(&(pose * l.inertial.center).coords)).sum()
    }

    fn lagrangian(&self, q: &[f64], qd: &[f64]) -> f64 {
        let velocity = DVector::from_column_slice(qd);
        0.5 * velocity.dot(&(self.mass_matrix(q) * &velocity)) - self.potential(q)
    }

    /// d/dt ∂L/∂qd − ∂L/∂q by differences: M qdd + Ṁ qd − ∂L/∂q.
    fn torques(&self, q: &[f64], qd: &[f64], qdd: &[f64]) -> Vec<f64> {
        let step = 1e-5;
        let along = |sign: f64| -> Vec<f64> { q.iter().zip(qd).map(|(a, b)| a + sign * step * b).collect() };
        let rate = (self.mass_matrix(&along(1.0)) - self.mass_matrix(&along(-1.0))) / (2.0 * step);
        let momentum =
            self.mass_matrix(q) * DVector::from_column_slice(qdd) + rate * DVector::from_column_slice(qd);
        (0..q.len())
            .map(|k| {
                let at = |offset: f64| {
                    let mut moved = q.to_vec();
                    moved[k] += offset;
                    self.lagrangian(&moved, qd)
                };
                momentum[k] - (at(step) - at(-step)) / (2.0 * step)
            })
            .collect()
    }
}

fn four(range: std::ops::Range<f64>) -> impl Strategy<Value = [f64; 4]> {
    proptest::array::uniform4(range)
}

proptest! {
    /// Lagrange's equations from the energy, which knows nothing of recursion, forces or frames of links.
    #[test]
    fn torques_are_those_of_lagrange(q in four(-2.0..2.0), qd in four(-2.0..2.0), qdd in four(-3.0..3.0)) {
        for robot in [arms::spatial(), arms::scara()] {
            let gravity = Vector3::new(1.0, -2.0, -9.0);
            let energy = Energy { robot: &robot, gravity };
            let expected = energy.torques(&q, &qd, &qdd);
            let mut tau = [0.0; 4];
            let mut dynamics = Dynamics::new(&robot, gravity);
            dynamics.inverse(&q, &qd, &qdd, &mut tau);
            for (found, wanted) in tau.iter().zip(&expected) {
                prop_assert!((found - wanted).abs() < 2e-7, "{tau:?} {expected:?}");
            }
            let difference = (dynamics.mass_matrix(&q) - energy.mass_matrix(&q)).amax();
            prop_assert!(difference < 1e-12, "{difference}");
        }
    }

    #[test]
    fn torque_is_linear_in_acceleration_with_the_mass_matrix(
        q in four(-2.0..2.0), qd in four(-2.0..2.0), qdd in four(-3.0..3.0),
    ) {
        let mut dynamics = Dynamics::new(&arms::spatial(), GRAVITY);
        let (mut with, mut without) = ([0.0; 4], [0.0; 4]);
        dynamics.inverse(&q, &qd, &qdd, &mut with);
        dynamics.inverse(&q, &qd, &[0.0; 4], &mut without);
        let expected = dynamics.mass_matrix(&q) * DVector::from_column_slice(&qdd);
        for k in 0..4 {
            prop_assert!((with[k] - without[k] - expected[k]).abs() < 1e-11);
        }
    }
}

#[test]
fn the_planar_arm_held_level_bears_its_weight() {
    // Gravity in the plane, arm along x: tau₁ = g (20·2 + 15·5.5 + 3·7.5), tau₂ = g (15·1.5 + 3·3.5), …
    let mut dynamics = Dynamics::new(&arms::rrr(), GRAVITY);
    let mut tau = [0.0; 3];
    dynamics.inverse(&[0.0; 3], &[0.0; 3], &[0.0; 3], &mut tau);
    for (found, lever) in tau.into_iter().zip([145.0, 33.0, 1.5]) {
        assert!((found - 9.81 * lever).abs() < 1e-12 * 9.81 * lever, "{tau:?}");
    }
    // Gravity normal to the plane: nothing to bear.
    let mut dynamics = Dynamics::new(&arms::rrr(), Vector3::new(0.0, 0.0, -9.81));
    dynamics.inverse(&[0.3, 0.4, 0.5], &[0.0; 3], &[0.0; 3], &mut tau);
    assert!(tau.iter().all(|torque| torque.abs() < 1e-12), "{tau:?}");
}

#[test]
fn gravity_is_given_in_the_world_whatever_the_base() {
    // The base lies on its side: what the world calls down is the base's −y.
    let mut robot = arms::rrr();
    robot.world_from_base = arms::pose([1.0, 2.0, 3.0], [std::f64::consts::FRAC_PI_2, 0.0, 0.4]);
    let (mut tipped, mut upright) = ([0.0; 3], [0.0; 3]);
    let q = [0.3, 0.4, 0.5];
    Dynamics::new(&robot, Vector3::new(0.0, 0.0, -9.81)).inverse(&q, &[0.0; 3], &[0.0; 3], &mut tipped);
    Dynamics::new(&arms::rrr(), GRAVITY).inverse(&q, &[0.0; 3], &[0.0; 3], &mut upright);
    for (a, b) in tipped.into_iter().zip(upright) {
        assert!((a - b).abs() < 1e-11, "{tipped:?} {upright:?}");
    }
}

#[test]
fn fingers_and_load_add_what_they_weigh_where_they_are() {
    let mut robot = arms::rrr();
    for finger in &mut robot.gripper.fingers {
        finger.link.inertial = arms::point_mass(0.5, [0.0; 3]);
    }
    let mut dynamics = Dynamics::new(&robot, GRAVITY);
    let (mut empty, mut loaded, mut wide) = ([0.0; 3], [0.0; 3], [0.0; 3]);
    let rest = [0.0; 3];
    dynamics.inverse(&rest, &rest, &rest, &mut empty);
    // Both fingers at the tool, 1 m out on the hand, 8 m from axis 1.
    assert!((empty[2] - 9.81 * (1.5 + 1.0)).abs() < 1e-12, "{empty:?}");
    dynamics.set_load(0.0, Some(&arms::point_mass(2.0, [1.0, 0.0, 0.0])));
    dynamics.inverse(&rest, &rest, &rest, &mut loaded);
    assert!((loaded[0] - empty[0] - 9.81 * 2.0 * 8.0).abs() < 1e-11, "{loaded:?}");
    // Open fingers leave the weight where it is and add m·(opening/2)² to the inertia about the wrist.
    dynamics.set_load(0.06, None);
    dynamics.inverse(&rest, &rest, &rest, &mut wide);
    assert!((wide[2] - empty[2]).abs() < 1e-12);
    let open = dynamics.mass_matrix(&rest)[(2, 2)];
    dynamics.set_load(0.0, None);
    let closed = dynamics.mass_matrix(&rest)[(2, 2)];
    assert!((open - closed - 1.0 * 0.03 * 0.03).abs() < 1e-14, "{}", open - closed);
    // Taking the load off gives back the empty arm exactly.
    dynamics.inverse(&rest, &rest, &rest, &mut wide);
    assert_eq!(wide.map(f64::to_bits), empty.map(f64::to_bits));
}

#[test]
fn a_robot_that_carries_nothing_real_still_has_rotor_inertia() {
    let mut robot = two_point_masses(1.0, 1.0, 1.0, 1.0);
    for link in &mut robot.links {
        link.inertial = Inertial::massless();
    }
    robot.joints[1].rotor_inertia = 0.25;
    let matrix = Dynamics::new(&robot, GRAVITY).mass_matrix(&[0.4, 0.5]);
    assert_eq!(matrix, DMatrix::from_diagonal(&DVector::from_vec(vec![0.0, 0.25])));
}

#[test]
fn friction_opposes_motion_and_vanishes_at_rest() {
    let mut robot = arms::rrr();
    for (joint, (damping, friction)) in robot.joints.iter_mut().zip([(2.0, 3.0), (0.5, 0.0), (0.0, 1.0)]) {
        joint.damping = damping;
        joint.friction = friction;
    }
    let dynamics = Dynamics::new(&robot, GRAVITY);
    let mut torque = [f64::NAN; 3];
    dynamics.friction(&[0.5, -2.0, 0.0], &mut torque);
    assert_eq!(torque.map(f64::to_bits), [4.0, -1.0, 0.0].map(f64::to_bits));
    dynamics.friction(&[-0.5, 0.0, -1e-9], &mut torque);
    assert_eq!(torque.map(f64::to_bits), [-4.0, 0.0, -1.0].map(f64::to_bits));
}
