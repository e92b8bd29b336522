//! The comparisons hold for the robots of the tests, and would show a plant that is wrong.

use super::*;
use crate::fixtures;

fn rubbing() -> RobotModel {
    let mut robot = fixtures::rrr();
    for (joint, friction) in robot.joints.iter_mut().zip([10.0, 5.0, 0.5]) {
        joint.friction = friction;
        joint.damping = friction / 2.0;
    }
    robot
}

/// Eighth order by a library and fourth order of our own, which the windows of every run are integrated with.
#[test]
fn two_integrations_of_the_exact_equations_agree() {
    // Dry friction that turns within a step of 1 ms costs the fourth order: ½ dt² of twice the friction's
    // acceleration of some 10 rad/s² at each turn.
    for (robot, tolerance) in [(fixtures::rrr(), 1e-9), (rubbing(), 2e-5)] {
        let trial = Trial::of(&robot);
        let eighth = exact_swing(&robot, &trial, 2.0).unwrap();
        let mut arm = ExactArm::new(&robot, trial.gravity);
        let (mut q, mut qd) = (trial.swing.clone(), vec![0.0; 3]);
        for row in &eighth.q[1..] {
            for _ in 0..5 {
                arm.advance(&mut q, &mut qd, &[0.0; 3], 1e-3);
            }
            let apart = row.iter().zip(&q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < tolerance, "{apart}");
        }
    }
}

/// Without friction the exact arm keeps its energy: of twelve digits none that counts is lost.
#[test]
fn the_exact_swing_keeps_its_energy() {
    let robot = fixtures::rrr();
    let exact = exact_swing(&robot, &Trial::of(&robot), 3.0).unwrap();
    for energy in &exact.energy {
        assert!((energy - exact.energy[0]).abs() < 1e-9 * exact.peak_kinetic);
    }
}

#[test]
fn a_plant_of_first_order_is_found_to_be_one() {
    for robot in [fixtures::rrr(), rubbing()] {
        let order = convergence_order(&robot, &Trial::of(&robot), 1e-3).unwrap();
        assert!((order - 1.0).abs() < 0.1, "{order}");
    }
}

#[test]
fn the_first_link_swings_with_the_period_of_a_pendulum() {
    for robot in [fixtures::rrr(), fixtures::scara(), fixtures::tilted()] {
        let off = pendulum::period(&robot, 1e-3).unwrap();
        assert!(off.abs() < 1e-4, "{}: {off}", robot.name);
    }
    let mut sliding = fixtures::scara();
    sliding.joints[0].kind = JointKind::Prismatic;
    assert!(matches!(pendulum::period(&sliding, 1e-3), Err(FidelityError::NoPendulum { .. })));
}

#[test]
fn a_block_slides_from_its_coefficient_of_friction_on() {
    let threshold = friction_threshold(&fixtures::scara(), 1e-3).unwrap();
    assert!((threshold - 1.0).abs() < 0.02, "{threshold}");
}

#[test]
fn torques_at_rest_are_those_of_the_model() {
    for robot in [fixtures::rrr(), fixtures::scara(), fixtures::tilted()] {
        let apart = static_torques(&robot, Vector3::new(1.0, -2.0, -9.0)).unwrap();
        assert!(apart < 1e-8, "{}: {apart}", robot.name);
    }
}
