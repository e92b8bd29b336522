//! The step loop.

use graspcheck_model::{
    Pose,
    cell::Cell,
    execution::{Controller, Execution},
    inertia::Inertial,
    object::Object,
    plan::{Holding, Plan},
    robot::RobotModel,
};
use graspcheck_motion::MotionState;
use graspcheck_recording::Recording;

use crate::{
    clock::Clock,
    contacts::Contacts,
    controller::ComputedTorque,
    error::SimError,
    gripper::GripperDrive,
    plant::{Plant, PlantSettings},
    recorder::{Recorder, Sample},
    self_test,
};

/// How deep the object may overlap something at the start, m. It may stand on a table without a gap, and
/// rapier's distance between curved shapes is uncertain by 3e-5 m.
pub const START_DEPTH_MAX: f64 = 5e-5;

/// How many steps pass between two reports of progress.
const PROGRESS_STRIDE: usize = 100;

/// Executes `plan` in a rapier world and returns the recording of every step.
///
/// Fills joint, tool and object series, contacts, monitor, frames, and one event for the beginning of each
/// phase; metadata, attachments and markers are the caller's. The simulation goes on at rest for
/// `execution.settle` seconds after the plan's end; the last row is at or after that instant.
/// `progress(done, total)` is called with counts of steps, last with `done == total`.
///
/// A plan that cannot be followed, or that drops or hits something, is still recorded to its end.
///
/// # Errors
/// When the input does not fit together, the multibody does not agree with the model's dynamics, the object
/// overlaps something at the start, or the physics breaks down (not finite, asleep).
pub fn simulate(
    robot: &RobotModel,
    cell: &Cell,
    object: Option<&Object>,
    plan: &Plan,
    execution: &Execution,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<Recording, SimError> {
    let clock = validate(robot, object, plan, execution)?;
    self_test::run(robot, cell, &execution.contact, execution.seed)?;
    let settings =
        PlantSettings { dt: clock.dt(), substeps: execution.substeps, contact: &execution.contact };
    let mut plant = Plant::new(robot, cell, object, &settings)?;
    let dof = robot.dof();
    let mut reference = MotionState::zeros(dof);
    let mut opening = MotionState::zeros(1);
    plan.trajectory.eval_held(0.0, &mut reference);
    plan.opening.eval_held(0.0, &mut opening);
    let mut q = with_fingers(&reference.q, opening.q[0] / 2.0);
    let mut qd = with_fingers(&reference.qd, opening.qd[0] / 2.0);
    plant.set_state(&q, &qd);

    let mut contacts = Contacts::new(plant.names());
    let mut world_from_body = vec![Pose::identity(); plant.names().len()];
    refuse_penetration(&mut plant, &mut contacts, &mut world_from_body, clock)?;

    let load = held_object(robot, object, plan);
    let drive = GripperDrive::new(&robot.gripper, plan.grasp.as_ref());
    let mut controller = ComputedTorque::new(robot, cell.gravity, &execution.controller);
    let steps = clock.steps_in(plan.duration() + execution.settle);
    let mut recorder = Recorder::new(robot, plan, &plant, clock, steps + 1);
    for step in 0..=steps {
        let time = clock.seconds(step);
        plan.trajectory.eval_held(time, &mut reference);
        plan.opening.eval_held(time, &mut opening);
        plant.read_state(&mut q, &mut qd);
        plant.read_poses(&mut world_from_body);
        let object_twist = plant.object_twist();
        refuse_not_finite(robot, &plant, &q, &qd, &world_from_body, time)?;

        let holding = plan.phase_at(time).holding;
        let measured_opening = q[dof..].iter().sum();
        let fingers = drive.command(holding, opening.q[0], opening.qd[0], measured_opening);
        controller.set_load(measured_opening, load.as_ref().filter(|_| holding == Holding::Held));
        controller.update(&reference, &q[..dof], &qd[..dof]);
        plant.drive_fingers(fingers.velocity, fingers.force);
        plant.apply_efforts(controller.applied());
        plant.step();
        refuse_broken(&plant, time)?;

        contacts.collect(&plant, &world_from_body, clock.dt());
        recorder.push(&Sample {
            step,
            q: &q,
            qd: &qd,
            reference: &reference,
            opening: &opening,
            fingers,
            controller: &controller,
            world_from_body: &world_from_body,
            object_twist,
            contacts: &contacts,
        });
        if step.is_multiple_of(PROGRESS_STRIDE) || step == steps {
            progress(step, steps);
        }
    }
    Ok(recorder.finish())
}

/// Checks that the parts fit together and returns the time base.
fn validate(
    robot: &RobotModel,
    object: Option<&Object>,
    plan: &Plan,
    execution: &Execution,
) -> Result<Clock, SimError> {
    let clock = Clock::new(execution.dt)?;
    let Controller::ComputedTorque { bandwidth, damping_ratio } = execution.controller;
    let contact = &execution.contact;
    let positive = "positive and finite";
    let not_negative = "at least 0 and finite";
    let settings = [
        ("substeps", execution.substeps as f64, positive),
        ("settle", execution.settle, not_negative),
        ("controller bandwidth", bandwidth, positive),
        ("controller damping ratio", damping_ratio, not_negative),
        ("contact frequency", contact.frequency, positive),
        ("contact damping ratio", contact.damping_ratio, positive),
        ("contact prediction", contact.prediction, positive),
        ("contact friction", contact.friction, not_negative),
    ];
    for (setting, value, requirement) in settings {
        let large_enough = if requirement == positive { value > 0.0 } else { value >= 0.0 };
        if !(large_enough && value.is_finite()) {
            return Err(SimError::Setting { setting, value, requirement });
        }
    }
    if plan.trajectory.dof() != robot.dof() {
        return Err(SimError::JointCount {
            robot_name: robot.name.clone(),
            plan: plan.trajectory.dof(),
            robot: robot.dof(),
        });
    }
    if plan.opening.dof() != 1 {
        return Err(SimError::OpeningJoints { count: plan.opening.dof() });
    }
    if plan.phases.is_empty() {
        return Err(SimError::NoPhase);
    }
    if let (Some(grasp), None) = (&plan.grasp, object) {
        return Err(SimError::GraspWithoutObject { handle: grasp.handle.clone() });
    }
    Ok(clock)
}

/// The values of the arm's joints, followed by the same value for both fingers.
fn with_fingers(arm: &[f64], finger: f64) -> Vec<f64> {
    let mut all = arm.to_vec();
    all.extend([finger; crate::plant::FINGERS]);
    all
}

/// Mass properties of the object in the frame of the last link while it is held.
fn held_object(robot: &RobotModel, object: Option<&Object>, plan: &Plan) -> Option<Inertial> {
    let (object, grasp) = (object?, plan.grasp.as_ref()?);
    let link_from_object = robot.link_from_tool * grasp.tool_from_object;
    Some(object.shape.inertial(object.mass).transformed(&link_from_object))
}

fn refuse_penetration(
    plant: &mut Plant,
    contacts: &mut Contacts,
    world_from_body: &mut [Pose],
    clock: Clock,
) -> Result<(), SimError> {
    let Some(object) = plant.object() else { return Ok(()) };
    plant.detect_contacts();
    plant.read_poses(world_from_body);
    contacts.collect(plant, world_from_body, clock.dt());
    let deepest = contacts
        .rows()
        .iter()
        .filter(|contact| contact.a == object || contact.b == object)
        .max_by(|left, right| left.depth.total_cmp(&right.depth));
    match deepest {
        Some(contact) if contact.depth > START_DEPTH_MAX => {
            let other = if contact.a == object { contact.b } else { contact.a };
            Err(SimError::StartsInPenetration {
                object: plant.names()[object].clone(),
                other: plant.names()[other].clone(),
                depth: contact.depth,
                limit: START_DEPTH_MAX,
            })
        }
        _ => Ok(()),
    }
}

fn refuse_not_finite(
    robot: &RobotModel,
    plant: &Plant,
    q: &[f64],
    qd: &[f64],
    world_from_body: &[Pose],
    time: f64,
) -> Result<(), SimError> {
    for (quantity, values) in [("position", q), ("velocity", qd)] {
        if let Some(joint) = values.iter().position(|value| !value.is_finite()) {
            let place = match robot.joints.get(joint) {
                Some(joint) => &joint.name,
                None => &robot.gripper.fingers[joint - robot.dof()].joint,
            };
            return Err(SimError::NotFinite { place: place.clone(), quantity, value: values[joint], time });
        }
    }
    if let Some(object) = plant.object() {
        let position = world_from_body[object].translation.vector;
        if let Some(value) = position.iter().find(|value| !value.is_finite()) {
            let place = plant.names()[object].clone();
            return Err(SimError::NotFinite { place, quantity: "position", value: *value, time });
        }
    }
    Ok(())
}

fn refuse_broken(plant: &Plant, time: f64) -> Result<(), SimError> {
    if let Some(body) = plant.quarantined() {
        return Err(SimError::Quarantined { body: body.to_owned(), time });
    }
    if let Some(body) = plant.asleep() {
        return Err(SimError::Asleep { body: body.to_owned(), time });
    }
    Ok(())
}
