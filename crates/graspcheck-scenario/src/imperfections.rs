//! What is not as the plan and the controller believe: `[imperfections]`.

use graspcheck_model::{
    execution::{Imperfections, Push},
    robot::{JointKind, RobotModel},
};

use crate::{
    quantity::Quantity,
    robot_file::wrong_kind,
    section::{Bound, Section},
};

/// Reads `[imperfections]`; without it there are none.
pub(crate) fn imperfections(scenario: &Section<'_>, robot: Option<&RobotModel>) -> Option<Imperfections> {
    let Some(section) = scenario.section("imperfections", "a list of imperfections") else {
        return Some(Imperfections::default());
    };
    let payload = section.measure_or("payload", Quantity::Mass, Bound::Any, 0.0);
    let object_friction = optional(
        section.has("object_friction"),
        section.plain_or("object_friction", Bound::NotNegative, 0.0),
    );
    let joint_friction = optional(
        section.mentions("joint_friction"),
        section.measure_or("joint_friction", Quantity::Share, Bound::NotNegative, 1.0),
    );
    let encoder_step = of_each_joint(&section, "encoder_step", Bound::NotNegative, robot);
    let encoder_noise = of_each_joint(&section, "encoder_noise", Bound::NotNegative, robot);
    let calibration = of_each_joint(&section, "calibration", Bound::Any, robot);
    let latency = section.measure_or("latency", Quantity::Time, Bound::NotNegative, 0.0);
    let ripple = match section.section("torque_ripple", "a torque ripple") {
        Some(ripple) => {
            let share = ripple.required_measure("amplitude", Quantity::Share, Bound::NotNegative);
            let waves = ripple.required_plain("waves_per_turn", Bound::Positive);
            ripple.finish();
            share.zip(waves)
        }
        None => Some((0.0, 0.0)),
    };
    let push = optional(section.has("push"), section.section("push", "a push").and_then(push));
    let object = match section.section("object", "a displacement of the object") {
        Some(object) => {
            let offset = match object.mentions("offset") {
                true => object.measures("offset", Quantity::Length),
                false => Some([0.0; 3]),
            };
            let yaw = object.measure_or("yaw", Quantity::Angle, Bound::Any, 0.0);
            object.finish();
            offset.zip(yaw)
        }
        None => Some(([0.0; 3], 0.0)),
    };
    section.finish();
    let (torque_ripple, ripple_waves) = ripple?;
    let (object_offset, object_yaw) = object?;
    Some(Imperfections {
        payload: payload?,
        object_friction: object_friction?,
        joint_friction: joint_friction?,
        encoder_step: encoder_step?,
        encoder_noise: encoder_noise?,
        calibration: calibration?,
        latency: latency?,
        torque_ripple,
        ripple_waves,
        push: push?,
        object_offset,
        object_yaw,
    })
}

/// None when the key stands there and cannot be read.
fn optional<T>(is_there: bool, read: Option<T>) -> Option<Option<T>> {
    match (is_there, read) {
        (true, None) => None,
        (true, read) => Some(read),
        (false, _) => Some(None),
    }
}

/// A small position for some joints by name, in the unit of each joint's kind; 0 for the others.
fn of_each_joint(
    section: &Section<'_>,
    key: &str,
    bound: Bound,
    robot: Option<&RobotModel>,
) -> Option<Vec<f64>> {
    let Some(joints) = section.section(key, "values for joints") else {
        return (!section.has(key)).then(Vec::new);
    };
    let read: Option<Vec<f64>> = robot?
        .joints
        .iter()
        .map(|joint| {
            let slides = joint.kind == JointKind::Prismatic;
            let quantity = if slides { Quantity::Length } else { Quantity::Angle };
            if wrong_kind(&joints, &joint.name, slides, &joint.name, quantity) {
                return None;
            }
            joints.measure_or(&joint.name, quantity, bound, 0.0)
        })
        .collect();
    joints.finish();
    read
}

fn push(section: Section<'_>) -> Option<Push> {
    let body = section.required_text("body").map(|(body, _)| body.to_owned());
    let start = section.required_measure("at", Quantity::Time, Bound::NotNegative);
    let duration = section.required_measure("duration", Quantity::Time, Bound::Positive);
    let force = section.required_measures("force", Quantity::Force);
    section.finish();
    Some(Push { body: body?, start: start?, duration: duration?, force: force? })
}
