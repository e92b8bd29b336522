//! Controllers, their period, and what is not as they believe.

use super::{reintegrate, simulate};
use crate::{
    SimError,
    fixtures::{self, Lift},
    reintegration::Reintegration,
    validate::validate,
};
use graspcheck_model::{
    execution::{Controller, Execution, Imperfections, Push},
    plan::Plan,
    robot::RobotModel,
};
use graspcheck_recording::Recording;

const BANDWIDTH: f64 = 100.0;

fn with(controller: Controller) -> Execution {
    Execution { controller, ..fixtures::execution() }
}

fn disturbed(imperfections: Imperfections) -> Execution {
    Execution { imperfections, ..fixtures::execution() }
}

fn scara_move() -> Plan {
    fixtures::move_plan(&[0.0, 0.0, -0.05, 0.0], &[(1.0, vec![1.1, 1.7, -0.25, 3.0])])
}

fn try_run(robot: &RobotModel, plan: &Plan, execution: &Execution) -> Result<Recording, SimError> {
    simulate(robot, &fixtures::empty_cell(fixtures::GRAVITY), None, plan, execution, &mut |_, _| {})
}

fn run(execution: &Execution) -> Recording {
    try_run(&fixtures::scara(), &scara_move(), execution).unwrap()
}

fn run_lift(lift: &Lift, execution: &Execution) -> Recording {
    simulate(&lift.robot, &lift.cell, Some(&lift.object), &lift.plan, execution, &mut |_, _| {}).unwrap()
}

/// Measured less commanded position of a joint.
fn error(recording: &Recording, row: usize, joint: usize) -> f64 {
    recording.measured.position_row(row)[joint] - recording.reference.position_row(row)[joint]
}

fn worst(recording: &Recording, joint: usize) -> f64 {
    (0..recording.measured.len()).map(|row| error(recording, row, joint).abs()).fold(0.0, f64::max)
}

fn is_finite(recording: &Recording) -> bool {
    let measured = &recording.measured;
    measured.position.iter().chain(&measured.velocity).chain(&measured.effort).all(|value| value.is_finite())
}

/// How often the torque of the shoulder goes from beyond one limit to beyond the other.
fn swings(recording: &Recording) -> usize {
    let sides: Vec<bool> = (0..recording.reference.len())
        .map(|row| recording.reference.effort_row(row)[0])
        .filter(|effort| effort.abs() > 120.0)
        .map(|effort| effort > 0.0)
        .collect();
    sides.windows(2).filter(|pair| pair[0] != pair[1]).count()
}

#[test]
fn each_controller_follows_as_well_as_its_law_can() {
    let gains = (BANDWIDTH, 1.0);
    let (bandwidth, damping_ratio) = gains;
    let computed = run(&with(Controller::ComputedTorque { bandwidth, damping_ratio }));
    let gravity = run(&with(Controller::GravityPd { bandwidth, damping_ratio }));
    let joint = run(&with(Controller::JointPd { bandwidth, damping_ratio }));
    let servo = run(&with(Controller::IdealServo));
    for k in 0..4 {
        let [servo, computed, gravity] = [&servo, &computed, &gravity].map(|recording| worst(recording, k));
        assert!(servo < 2e-5, "joint {k}: {servo}");
        assert!(computed < 5e-4 && gravity > 3.0 * computed, "joint {k}: {computed}, {gravity}");
    }
    // At rest the quill of the independent loop hangs by its weight over its stiffness: g / ω².
    let end = joint.measured.len() - 1;
    let sag = error(&joint, end, 2);
    assert!((sag + 9.81 / (BANDWIDTH * BANDWIDTH)).abs() < 1e-6, "{sag} m");
    assert!(error(&gravity, end, 2).abs() < 1e-6);
}

/// What a servo takes is what its motion takes: the torques of computed torque.
#[test]
fn the_torques_of_a_servo_are_recorded_and_limited() {
    let free = run(&with(Controller::IdealServo));
    let computed = run(&fixtures::execution());
    for row in [200, 500, 800] {
        let (servo, law) = (free.measured.effort_row(row)[0], computed.measured.effort_row(row)[0]);
        // An error of 1 µrad that a servo makes up in a millisecond is 1 N·m of this arm.
        assert!((servo - law).abs() < 2.0, "{servo} N·m, {law} N·m");
    }
    let mut robot = fixtures::scara();
    robot.joints[0].limits.effort = 8.0;
    let weak = try_run(&robot, &scara_move(), &with(Controller::IdealServo)).unwrap();
    assert!(worst(&weak, 0) > 0.01, "{}", worst(&weak, 0));
    assert!(weak.monitor.iter().any(|row| row.saturated_joints > 0));
    assert!((0..weak.measured.len()).all(|row| weak.measured.effort_row(row)[0].abs() <= 8.0));
}

#[test]
fn a_command_is_held_for_the_controllers_period() {
    let mut execution = fixtures::execution();
    execution.control_period = Some(0.005);
    let recording = run(&execution);
    let effort = |row| recording.measured.effort_row(row).to_vec();
    for row in (0..1000).step_by(5) {
        assert!((1..5).all(|later| effort(row + later)[..4] == effort(row)[..4]), "{row}");
    }
    assert_ne!(effort(300)[0].to_bits(), effort(305)[0].to_bits());
    execution.control_period = Some(0.0015);
    let refused = try_run(&fixtures::scara(), &scara_move(), &execution);
    assert!(matches!(refused, Err(SimError::NotWholeSteps { setting: "controller period", .. })));
}

/// The sampled double integrator with z → e^{sT} loses its stability where (2ζωT)/2 + … exceeds 2: at 100 rad/s
/// critically damped between periods of 8 ms and 10 ms with the inertia known exactly.
#[test]
fn gains_that_are_too_high_for_the_period_swing_between_the_limits_and_stay_finite() {
    let run_at = |period, latency| {
        let mut execution = disturbed(Imperfections { latency, ..Imperfections::default() });
        execution.control_period = Some(period);
        run(&execution)
    };
    assert_eq!(swings(&run_at(0.004, 0.0)), 0);
    for (period, latency) in [(0.02, 0.0), (0.001, 0.015)] {
        let unstable = run_at(period, latency);
        assert!(is_finite(&unstable) && swings(&unstable) > 10, "{}", swings(&unstable));
        assert_eq!(unstable.measured.len(), 1201);
    }
}

#[test]
fn a_payload_that_is_not_declared_pulls_the_quill_down_by_its_weight_over_the_stiffness() {
    let lift = fixtures::lift(20.0);
    let payload = 0.3;
    let end = |execution: &Execution| {
        let recording = run_lift(&lift, execution);
        error(&recording, recording.measured.len() - 1, 2)
    };
    assert!(end(&fixtures::execution()).abs() < 1e-6);
    let sag = end(&disturbed(Imperfections { payload, ..Imperfections::default() }));
    // The model moves 2.1 kg of quill, hand and fingers, and the cube of 0.1 kg.
    let expected = -payload * 9.81 / (2.2 * BANDWIDTH * BANDWIDTH);
    assert!((sag / expected - 1.0).abs() < 0.02, "{sag} m is not {expected} m");
}

#[test]
fn friction_calibration_and_pose_are_what_was_asked() {
    let mut robot = fixtures::scara();
    robot.joints[0].friction = 8.0;
    let rubbing = |share| {
        let real = Imperfections { joint_friction: share, ..Imperfections::default() };
        worst(&try_run(&robot, &scara_move(), &disturbed(real)).unwrap(), 0)
    };
    assert!((rubbing(Some(1.0)) - rubbing(None)).abs() < 1e-15);
    assert!(rubbing(Some(3.0)) > 3.0 * rubbing(None));

    let calibration = vec![0.01, 0.0, 0.0, -0.02];
    let off = run(&disturbed(Imperfections { calibration, ..Imperfections::default() }));
    for row in [0, off.measured.len() - 1] {
        assert!((error(&off, row, 0) + 0.01).abs() < 1e-5 && (error(&off, row, 3) - 0.02).abs() < 1e-5);
    }

    let mut lift = fixtures::lift(10.0);
    let there = lift.object.world_from_object.translation.vector;
    let object_offset = [0.004, -0.003, 0.0];
    let moved = run_lift(&lift, &disturbed(Imperfections { object_offset, ..Imperfections::default() }));
    let [x, y, z, ..] = moved.object.pose[0];
    assert!((x - there.x - 0.004).abs() < 1e-12 && (y - there.y + 0.003).abs() < 1e-12);
    assert!((z - there.z).abs() < 1e-12);

    lift.plan = fixtures::lift(0.9).plan;
    let height = |friction| {
        let real = Imperfections { object_friction: Some(friction), ..Imperfections::default() };
        let recording = run_lift(&lift, &disturbed(real));
        recording.object.pose[recording.object.pose.len() - 1][2] - there.z
    };
    assert!(height(0.8) > 0.099 && height(0.0) < 0.08, "{}, {}", height(0.8), height(0.0));
}

#[test]
fn a_push_acts_for_its_time_on_its_body() {
    let push = |force, body: &str, start, duration| {
        let push = Push { body: body.to_owned(), start, duration, force };
        Imperfections { push: Some(push), ..Imperfections::default() }
    };
    let still = run(&fixtures::execution());
    let pushed = run(&disturbed(push([0.0, 200.0, 0.0], "forearm", 0.3, 0.05)));
    let apart = |row| (error(&pushed, row, 1) - error(&still, row, 1)).abs();
    assert!(apart(300) == 0.0 && apart(330) > 1e-3, "{}", apart(330));
    // 0.65 s later the loop has forgotten it.
    assert!(apart(1000) < 1e-6, "{}", apart(1000));

    // A cube of 0.1 kg that stands gets 0.02 N·s less what the table's friction takes.
    let lift = fixtures::lift(10.0);
    let kicked = run_lift(&lift, &disturbed(push([2.0, 0.0, 0.0], "cube", 0.05, 0.01)));
    let speed = kicked.object.twist[60][0];
    let expected = 0.01 * (2.0 - 0.8 * 0.981) / 0.1;
    assert!((speed / expected - 1.0).abs() < 0.05, "{speed} m/s is not {expected} m/s");

    let refused = try_run(&fixtures::scara(), &scara_move(), &disturbed(push([0.0; 3], "table", 0.0, 1.0)));
    assert!(matches!(refused, Err(SimError::PushedBody { .. })));
}

#[test]
fn noise_follows_from_the_seed() {
    let noisy = |seed| {
        let encoder_noise = vec![1e-4; 4];
        run(&Execution { seed, ..disturbed(Imperfections { encoder_noise, ..Imperfections::default() }) })
    };
    let first = noisy(1);
    assert!(first == noisy(1));
    assert!(first.measured != noisy(2).measured);
}

#[test]
fn imperfections_that_make_no_sense_are_typed_errors() {
    let refused = |change: fn(&mut Execution)| {
        let mut execution = fixtures::execution();
        change(&mut execution);
        try_run(&fixtures::scara(), &scara_move(), &execution).unwrap_err()
    };
    let latency = refused(|execution| execution.imperfections.latency = 0.0015);
    assert!(matches!(latency, SimError::NotWholeSteps { setting: "latency", .. }));
    let joints = refused(|execution| execution.imperfections.calibration = vec![0.1; 3]);
    assert!(matches!(joints, SimError::ForEachJoint { count: 3, joints: 4, .. }));
    let noise = refused(|execution| execution.imperfections.encoder_noise = vec![f64::NAN; 4]);
    assert!(matches!(noise, SimError::Setting { setting: "encoder noise", .. }));
    let ripple = refused(|execution| {
        execution.controller = Controller::IdealServo;
        execution.imperfections.torque_ripple = 0.1;
    });
    assert_eq!(ripple, SimError::RippleOfServo);
    let mut robot = fixtures::scara();
    robot.links[1].inertial.mass = 0.0;
    let massless = try_run(&robot, &scara_move(), &fixtures::execution());
    assert!(matches!(massless, Err(SimError::Inertial { link, .. }) if link == "forearm"));
}

/// The run of a SCARA with friction, held against the exact equations.
fn reintegrated(spoil: impl Fn(&mut Recording)) -> Reintegration {
    let mut robot = fixtures::scara();
    for (joint, friction) in robot.joints.iter_mut().zip([1.0, 0.5, 2.0, 0.03]) {
        joint.friction = friction;
        joint.damping = friction / 4.0;
    }
    let (plan, execution) = (scara_move(), fixtures::execution());
    let mut recording = try_run(&robot, &plan, &execution).unwrap();
    spoil(&mut recording);
    let timing = validate(&robot, None, &plan, &execution).unwrap();
    let cell = fixtures::empty_cell(fixtures::GRAVITY);
    reintegrate(&recording, [&robot, &robot], &cell, &plan, &execution, timing).unwrap()
}

#[test]
fn the_integration_defect_is_small_and_shows_torques_that_were_not_applied() {
    let found = reintegrated(|_| {});
    assert_eq!(found.windows, [24, 24]);
    for (joint, defect) in found.defect.iter().enumerate() {
        assert!(defect.value > 0.0 && defect.value < 3e-4, "joint {joint}: {defect:?}");
        let (simulated, exact) = (found.tracking[joint].value, found.exact_tracking[joint].value);
        assert!(exact < simulated, "joint {joint}: {exact} on the exact plant, {simulated} simulated");
    }
    let spoiled = reintegrated(|recording| {
        for effort in recording.measured.effort.iter_mut().step_by(6) {
            *effort += 1.0;
        }
    });
    assert!(spoiled.defect[0].value > 4.0 * found.defect[0].value, "{:?}", spoiled.defect[0]);
}

#[test]
fn windows_with_a_contact_are_left_out() {
    let lift = fixtures::lift(10.0);
    let recording = run_lift(&lift, &fixtures::execution());
    // Half a second of closing, of which the pads touch at the end, then the cube is held.
    let windows = &recording.metadata["reintegrated_windows"];
    let free: usize = windows.split(' ').next().unwrap().parse().unwrap();
    assert!((1..10).contains(&free) && windows.contains("of 54"), "{windows}");
    assert!(recording.metadata["integration_defect.quill"].contains(" m at "));
    assert!(recording.metadata["free_tracking_error_exact_plant.wrist"].contains(" rad at "));
}
