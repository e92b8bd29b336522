//! The step loop.

use graspcheck_model::{
    Pose, cell::Cell, execution::Controller, execution::Execution, execution::Push, inertia::Inertial,
    object::Object, plan::Holding, plan::Plan, robot::RobotModel,
};
use graspcheck_motion::MotionState;
use graspcheck_proof::Scene;
use graspcheck_recording::Recording;

use crate::{
    contacts::Contacts,
    controller::ArmController,
    drives::Drives,
    encoders::Encoders,
    error::SimError,
    gripper::GripperDrive,
    guard,
    plant::{Plant, PlantSettings},
    reality,
    recorder::{Recorder, Sample},
    reintegration::reintegrate,
    self_test,
    stride::Stride,
    validate::validate,
};

/// How many steps pass between two reports of progress.
const PROGRESS_STRIDE: usize = 100;

/// Executes `plan` in a rapier world and returns the recording of every step.
///
/// Fills joint, tool and object series, contacts, monitor, frames, one event for the beginning of each
/// phase, and in the metadata how far the run is from the exact equations of motion
/// ([`reintegration`](crate::reintegration)); attachments, markers and all other metadata are the caller's. The simulation goes on at rest for
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
    let timing = validate(robot, object, plan, execution)?;
    let clock = timing.clock;
    let scene = Scene::new(robot, cell, object)?;
    self_test::run(robot, cell, &execution.contact, execution.seed)?;
    let imperfections = &execution.imperfections;
    let real_robot = reality::robot(robot, imperfections);
    let real_object = object.map(|object| reality::object(object, imperfections));
    let settings =
        PlantSettings { dt: clock.dt(), substeps: execution.substeps, contact: &execution.contact };
    let mut plant = Plant::new(&real_robot, cell, real_object.as_ref(), &settings)?;
    let dof = robot.dof();
    let mut encoders = Encoders::new(execution, dof);
    let mut reference = MotionState::zeros(dof);
    let mut next_reference = MotionState::zeros(dof);
    let mut opening = MotionState::zeros(1);
    plan.trajectory.eval_held(0.0, &mut reference);
    plan.opening.eval_held(0.0, &mut opening);
    let mut controller = ArmController::new(robot, cell.gravity, execution, &reference.q, opening.q[0]);
    let start: Vec<f64> = reference.q.iter().zip(encoders.offset()).map(|(q, offset)| q - offset).collect();
    let mut q = with_fingers(&start, opening.q[0] / 2.0);
    let mut qd = with_fingers(&reference.qd, opening.qd[0] / 2.0);
    plant.set_state(&q, &qd);

    let mut contacts = Contacts::new(plant.names());
    let mut world_from_body = vec![Pose::identity(); plant.names().len()];
    plant.read_poses(&mut world_from_body);
    let mut stride = Stride::new(&plant, &world_from_body);
    guard::refuse_penetration(&mut plant, &mut contacts, &mut world_from_body, clock)?;

    let load = held_object(robot, object, plan);
    let gripper = GripperDrive::new(&robot.gripper, plan.grasp.as_ref());
    let mut drives = Drives::new(robot, execution, timing.steps_late);
    let pushed = imperfections.push.as_ref().and_then(|push| Some((push, plant.body_named(&push.body)?)));
    let is_servo = execution.controller == Controller::IdealServo;
    let mut arc = plant.arc_correction(robot);
    let steps = clock.steps_in(plan.duration() + execution.settle);
    let mut recorder = Recorder::new(robot, plan, &plant, scene.sampler(plan), clock, steps + 1);
    for step in 0..=steps {
        let time = clock.seconds(step);
        plan.trajectory.eval_held(time, &mut reference);
        plan.opening.eval_held(time, &mut opening);
        plant.read_state(&mut q, &mut qd);
        plant.read_poses(&mut world_from_body);
        let object_twist = plant.object_twist();
        guard::refuse_not_finite(robot, &plant, &q, &qd, &world_from_body, time)?;
        guard::refuse_too_far(&mut stride, &plant, &world_from_body, time)?;

        let holding = plan.phase_at(time).holding;
        let measured_opening = q[dof..].iter().sum();
        let fingers = gripper.command(holding, opening.q[0], opening.qd[0], measured_opening);
        if step.is_multiple_of(timing.command_stride) {
            plan.trajectory.eval_held(clock.seconds(step + timing.command_stride), &mut next_reference);
            encoders.read(&q[..dof], &qd[..dof]);
            controller.set_load(measured_opening, load.as_ref().filter(|_| holding == Holding::Held));
            controller.update(&reference, &next_reference, encoders.q(), encoders.qd());
        }
        drives.act(controller.command(), &q[..dof]);
        plant.drive_fingers(fingers.velocity, fingers.force);
        plant.solve_for_grasp(fingers.presses);
        plant.clear_forces();
        if is_servo {
            plant.drive_arm(robot, &drives.applied().velocities);
        } else {
            plant.apply_efforts(&drives.applied().efforts);
        }
        if let Some((push, body)) = pushed
            && acts(push, time)
        {
            plant.push(body, push.force);
        }
        arc.predict(robot, &q[..dof], &qd[..dof]);
        plant.step(&arc);
        guard::refuse_broken(&plant, time)?;

        contacts.collect(&plant, &world_from_body, clock.dt());
        recorder.push(&Sample {
            step,
            q: &q,
            qd: &qd,
            reference: &reference,
            opening: &opening,
            fingers,
            asked: controller.asked(),
            applied: &drives.applied().efforts,
            world_from_body: &world_from_body,
            object_twist,
            contacts: &contacts,
        });
        if step.is_multiple_of(PROGRESS_STRIDE) || step == steps {
            progress(step, steps);
        }
    }
    let mut recording = recorder.finish();
    let robots = [robot, &real_robot];
    if let Some(found) = reintegrate(&recording, robots, cell, plan, execution, timing) {
        found.enter(robot, &mut recording);
    }
    Ok(recording)
}

/// Whether a push acts in the step that begins at `time`, s.
fn acts(push: &Push, time: f64) -> bool {
    (push.start..push.start + push.duration).contains(&time)
}

/// The values of the arm's joints, followed by the same value for both fingers.
fn with_fingers(arm: &[f64], finger: f64) -> Vec<f64> {
    let mut all = arm.to_vec();
    all.extend([finger; crate::plant::FINGERS]);
    all
}

/// Mass properties of the object in the frame of the last link while it is held.
fn held_object(robot: &RobotModel, object: Option<&Object>, plan: &Plan) -> Option<Inertial> {
    Some(plan.grasp.as_ref()?.load(robot, object?))
}

#[cfg(test)]
mod control_tests;
#[cfg(test)]
mod tests;
