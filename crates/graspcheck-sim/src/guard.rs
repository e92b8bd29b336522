//! What ends a run: a start in penetration, numbers that are not finite, bodies that could pass through each other,
//! physics that has given up.

use graspcheck_model::{Pose, robot::RobotModel};

use crate::{
    clock::Clock,
    contacts::Contacts,
    error::SimError,
    plant::Plant,
    stride::{Stride, TooFar},
};

/// How deep the object may overlap something at the start, m. It may stand on a table without a gap, and
/// rapier's distance between curved shapes is uncertain by 3e-5 m.
pub const START_DEPTH_MAX: f64 = 5e-5;

/// Refuses an object that overlaps something at the start.
pub(crate) fn refuse_penetration(
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

/// Refuses a joint or an object whose state is no number.
pub(crate) fn refuse_not_finite(
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

/// Refuses two bodies that moved so far in a step that a collision could have been missed.
pub(crate) fn refuse_too_far(
    stride: &mut Stride,
    plant: &Plant,
    world_from_body: &[Pose],
    time: f64,
) -> Result<(), SimError> {
    match stride.advance(world_from_body) {
        None => Ok(()),
        Some(TooFar { a, b, moved, thickness }) => {
            let [a, b] = [a, b].map(|body| plant.names()[body].clone());
            Err(SimError::StepTooLong { a, b, moved, thickness, time })
        }
    }
}

/// Refuses a body that rapier took out or put to sleep.
pub(crate) fn refuse_broken(plant: &Plant, time: f64) -> Result<(), SimError> {
    if let Some(body) = plant.quarantined() {
        return Err(SimError::Quarantined { body, time });
    }
    if let Some(body) = plant.asleep() {
        return Err(SimError::Asleep { body: body.to_owned(), time });
    }
    Ok(())
}
