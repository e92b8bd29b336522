//! Whether robot, object, plan and execution fit together, before anything is built.

use graspcheck_model::{
    execution::{Controller, Execution, Imperfections},
    object::Object,
    plan::Plan,
    robot::RobotModel,
};

use crate::{clock::Clock, error::SimError};

/// How far a commanded opening may be beyond what the gripper can, m, and a speed, as a share: a motion
/// planned to reach a limit comes out within rounding of it.
const OPENING_ROUNDING: f64 = 1e-9;
const SPEED_ROUNDING: f64 = 1e-9;

/// A run of more steps than this is refused: at some 3 kB of recording a step it would fill 3 GB of memory.
const MOST_STEPS: f64 = 1e6;

/// How far a time may be from a whole number of steps, as a share of a step: rounding of its quotient.
const STEPS_ROUNDING: f64 = 1e-9;

/// The times of a run, in steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Timing {
    pub(crate) clock: Clock,
    /// Steps from one command of the controller to the next; at least one.
    pub(crate) command_stride: usize,
    /// Steps by which a command acts late.
    pub(crate) steps_late: usize,
}

/// Checks that the parts fit together and returns the time base.
pub(crate) fn validate(
    robot: &RobotModel,
    object: Option<&Object>,
    plan: &Plan,
    execution: &Execution,
) -> Result<Timing, SimError> {
    let clock = Clock::new(execution.dt)?;
    settings_are_in_range(execution)?;
    let command_stride = whole_steps("controller period", execution.command_period(), execution.dt)?;
    if command_stride == 0 {
        let (setting, value) = ("controller period", execution.command_period());
        return Err(SimError::Setting { setting, value, requirement: POSITIVE });
    }
    let steps_late = whole_steps("latency", execution.imperfections.latency, execution.dt)?;
    links_can_exist(robot)?;
    plan.check(robot.dof())?;
    let duration = plan.duration() + execution.settle;
    if duration / execution.dt > MOST_STEPS {
        return Err(SimError::TooManySteps { duration, dt: execution.dt, limit: MOST_STEPS });
    }
    fingers_can_follow(robot, plan)?;
    if let (Some(grasp), None) = (&plan.grasp, object) {
        return Err(SimError::GraspWithoutObject { handle: grasp.handle.clone() });
    }
    imperfections_fit(robot, object, execution)?;
    Ok(Timing { clock, command_stride, steps_late })
}

const POSITIVE: &str = "positive and finite";
const NOT_NEGATIVE: &str = "at least 0 and finite";
const FINITE: &str = "finite";

fn in_range(setting: &'static str, value: f64, requirement: &'static str) -> Result<(), SimError> {
    let fits = match requirement {
        POSITIVE => value > 0.0,
        NOT_NEGATIVE => value >= 0.0,
        _ => true,
    };
    if fits && value.is_finite() {
        return Ok(());
    }
    Err(SimError::Setting { setting, value, requirement })
}

fn settings_are_in_range(execution: &Execution) -> Result<(), SimError> {
    let contact = &execution.contact;
    let (bandwidth, damping_ratio) = execution.controller.gains().unwrap_or((1.0, 1.0));
    for (setting, value, requirement) in [
        ("substeps", execution.substeps as f64, POSITIVE),
        ("settle", execution.settle, NOT_NEGATIVE),
        ("controller bandwidth", bandwidth, POSITIVE),
        ("controller damping ratio", damping_ratio, NOT_NEGATIVE),
        ("contact frequency", contact.frequency, POSITIVE),
        ("contact damping ratio", contact.damping_ratio, POSITIVE),
        ("contact prediction", contact.prediction, POSITIVE),
        ("contact friction", contact.friction, NOT_NEGATIVE),
    ] {
        in_range(setting, value, requirement)?;
    }
    Ok(())
}

/// How many steps a time takes.
fn whole_steps(setting: &'static str, time: f64, dt: f64) -> Result<usize, SimError> {
    in_range(setting, time, NOT_NEGATIVE)?;
    let steps = (time / dt).round();
    if (time / dt - steps).abs() > STEPS_ROUNDING * steps.max(1.0) || steps > MOST_STEPS {
        return Err(SimError::NotWholeSteps { setting, time, dt });
    }
    // Exact: a whole number up to a million.
    Ok(steps as usize)
}

/// Checks that every body of the robot that moves has mass properties that a body can have. Those of a robot that
/// was read from files have been checked there.
fn links_can_exist(robot: &RobotModel) -> Result<(), SimError> {
    let fingers = robot.gripper.fingers.iter().map(|finger| &finger.link);
    for link in robot.links.iter().chain(fingers) {
        link.inertial.validate().map_err(|fault| SimError::Inertial { link: link.name.clone(), fault })?;
    }
    Ok(())
}

/// Checks the commanded opening at every instant: what it asks for beyond the gripper would be cut off.
fn fingers_can_follow(robot: &RobotModel, plan: &Plan) -> Result<(), SimError> {
    let (opening, gripper) = (&plan.opening, &robot.gripper);
    for extreme in opening.range_in(0, 0, 0.0, opening.duration()) {
        let beyond = (-extreme.value).max(extreme.value - gripper.opening_max);
        if beyond.is_nan() || beyond > OPENING_ROUNDING {
            return Err(SimError::Opening {
                opening: extreme.value,
                opening_max: gripper.opening_max,
                time: extreme.time,
            });
        }
    }
    let fastest = opening.peak(0, 1);
    let (speed, speed_max) = (fastest.value.abs() / 2.0, gripper.finger_speed);
    if speed.is_nan() || speed > speed_max * (1.0 + SPEED_ROUNDING) {
        return Err(SimError::FingerSpeed { speed, speed_max, time: fastest.time });
    }
    Ok(())
}

fn imperfections_fit(
    robot: &RobotModel,
    object: Option<&Object>,
    execution: &Execution,
) -> Result<(), SimError> {
    let real: &Imperfections = &execution.imperfections;
    let mass = object.map_or(1.0, |object| object.mass + real.payload);
    let [x, y, z] = real.object_offset;
    for (setting, value, requirement) in [
        ("the object's real mass", mass, POSITIVE),
        ("the object's real friction", real.object_friction.unwrap_or(0.0), NOT_NEGATIVE),
        ("the joints' share of friction", real.joint_friction.unwrap_or(0.0), NOT_NEGATIVE),
        ("torque ripple", real.torque_ripple, NOT_NEGATIVE),
        ("waves of torque ripple", real.ripple_waves, NOT_NEGATIVE),
        ("object offset x", x, FINITE),
        ("object offset y", y, FINITE),
        ("object offset z", z, FINITE),
        ("object yaw offset", real.object_yaw, FINITE),
    ] {
        in_range(setting, value, requirement)?;
    }
    for (setting, values, requirement) in [
        ("encoder step", &real.encoder_step, NOT_NEGATIVE),
        ("encoder noise", &real.encoder_noise, NOT_NEGATIVE),
        ("calibration offset", &real.calibration, FINITE),
    ] {
        if !(values.is_empty() || values.len() == robot.dof()) {
            return Err(SimError::ForEachJoint { setting, count: values.len(), joints: robot.dof() });
        }
        values.iter().try_for_each(|value| in_range(setting, *value, requirement))?;
    }
    if real.torque_ripple > 0.0 && execution.controller == Controller::IdealServo {
        return Err(SimError::RippleOfServo);
    }
    let Some(push) = &real.push else { return Ok(()) };
    in_range("start of the push", push.start, NOT_NEGATIVE)?;
    in_range("duration of the push", push.duration, POSITIVE)?;
    push.force.iter().try_for_each(|part| in_range("force of the push", *part, FINITE))?;
    let fingers = robot.gripper.fingers.iter().map(|finger| &finger.link);
    let links = robot.links.iter().chain(fingers).map(|link| link.name.as_str());
    let bodies: Vec<&str> = links.chain(object.map(|object| object.name.as_str())).collect();
    if !bodies.contains(&push.body.as_str()) {
        return Err(SimError::PushedBody { body: push.body.clone(), bodies: bodies.join(", ") });
    }
    Ok(())
}
