//! `robot.toml`: limits of acceleration and jerk, rotor inertias, tool frame, gripper, allowed contacts.

use graspcheck_model::{
    Pose,
    robot::{AllowedContact, JointKind},
    settings::{GripperSettings, JointSettings, RobotSettings, ToolSettings},
};
use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

use crate::{
    fault::{Fault, Faults},
    quantity::Quantity,
    section::{Bound, Section},
    shape::upright_pose,
    tree::{Table, Value},
};

/// Version of the form of a `robot.toml`.
pub const ROBOT_SCHEMA: i64 = 1;

/// Reads the settings. `kind_of` tells the kind of a joint from the URDF, where it is known.
pub(crate) fn read(
    table: &Table,
    kind_of: &dyn Fn(&str) -> Option<JointKind>,
    faults: &Faults,
) -> Option<RobotSettings> {
    let file = Section::new(table, "robot.toml", "a robot", faults);
    schema(&file, ROBOT_SCHEMA);
    file.required_text("urdf");
    let world_from_base = match file.section("base", "a base") {
        Some(base) => {
            let pose = upright_pose(&base);
            base.finish();
            pose
        }
        None => Some(Pose::identity()),
    };
    let joints = file.required_section("joint", "the joints").and_then(|joints| {
        let read: Vec<_> = joints
            .named_sections("a joint")
            .into_iter()
            .map(|(name, _, one)| joint(name, one, kind_of))
            .collect();
        joints.finish();
        read.into_iter().collect::<Option<Vec<_>>>()
    });
    let tool = file.required_section("tool", "a tool frame").and_then(tool);
    let gripper = file.required_section("gripper", "a gripper").and_then(gripper);
    let contacts: Vec<_> =
        file.sections("allowed_contact", "an allowed contact").into_iter().map(allowed_contact).collect();
    file.finish();
    Some(RobotSettings {
        world_from_base: world_from_base?,
        joints: joints?,
        tool: tool?,
        gripper: gripper?,
        allowed_contacts: contacts.into_iter().collect::<Option<Vec<_>>>()?,
    })
}

/// Holds the key `schema` against the version that this program reads.
pub(crate) fn schema(file: &Section<'_>, current: i64) {
    let Some(entry) = file.required("schema") else { return };
    if entry.node.value != Value::Integer(current) {
        let title = format!("this program reads schema {current} of this file");
        file.faults().report(Fault::new("schema", &entry.node.at, title, format!("write {current}")));
    }
}

fn joint(
    name: &str,
    section: Section<'_>,
    kind_of: &dyn Fn(&str) -> Option<JointKind>,
) -> Option<JointSettings> {
    // Without a URDF that says so, a joint slides when its keys say so.
    let slides = match kind_of(name) {
        Some(kind) => kind == JointKind::Prismatic,
        None => Quantity::LinearAcceleration.keys("acceleration_max").any(|(key, _)| section.has(&key)),
    };
    let (acceleration, jerk, inertia) = if slides {
        (Quantity::LinearAcceleration, Quantity::LinearJerk, Quantity::Mass)
    } else {
        (Quantity::AngularAcceleration, Quantity::AngularJerk, Quantity::Inertia)
    };
    let read = |stem: &str, quantity: Quantity, bound: Bound| match wrong_kind(
        &section, name, slides, stem, quantity,
    ) {
        true => None,
        false => section.required_measure(stem, quantity, bound),
    };
    let acceleration = read("acceleration_max", acceleration, Bound::Positive);
    let jerk = read("jerk_max", jerk, Bound::Positive);
    let rotor_inertia = read("rotor_inertia", inertia, Bound::NotNegative);
    section.finish();
    Some(JointSettings {
        name: name.to_owned(),
        acceleration: acceleration?,
        jerk: jerk?,
        rotor_inertia: rotor_inertia?,
    })
}

/// Reports the key of a joint that has the unit of the other kind of joint, and returns whether there is one.
pub(crate) fn wrong_kind(
    section: &Section<'_>,
    joint: &str,
    slides: bool,
    stem: &str,
    quantity: Quantity,
) -> bool {
    let Some((key, at, other)) = section.misfit(stem, quantity) else { return false };
    section.ask(key);
    let (kind, counts) = if slides { ("prismatic", "lengths") } else { ("revolute", "angles") };
    let title = format!("joint {joint} is {kind}: `{key}` has the unit of {}", other.word());
    let write = quantity.key(stem);
    let fault = Fault::new("unit-of-kind", at, title, format!("write `{write}`"));
    section.faults().report(fault.replace(format!("a {kind} joint counts in {counts}"), write));
    true
}

/// A key such as `points = "-z"`, as a unit vector.
fn axis(section: &Section<'_>, key: &str) -> Option<Vector3<f64>> {
    let axes = [
        ("+x", Vector3::x()),
        ("-x", -Vector3::x()),
        ("+y", Vector3::y()),
        ("-y", -Vector3::y()),
        ("+z", Vector3::z()),
        ("-z", -Vector3::z()),
    ];
    section.word(key, &axes, None)
}

fn tool(section: Section<'_>) -> Option<ToolSettings> {
    let link = section.required_text("link").map(|(link, _)| link.to_owned());
    let at = section.required_vector("at", Quantity::Length);
    let (points, closes) = (axis(&section, "points"), axis(&section, "closes"));
    let (place, faults) = (section.place(), section.faults());
    section.finish();
    let (x, y) = (points?, closes?);
    if x.dot(&y) != 0.0 {
        let title = "tool: `points` and `closes` must be two different axes";
        faults.report(Fault::new("tool-axes", place, title, "the fingers close across the approach"));
        return None;
    }
    let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, x.cross(&y)]));
    let rotation = UnitQuaternion::from_rotation_matrix(&rotation);
    Some(ToolSettings { link: link?, link_from_tool: Pose::from_parts(Translation3::from(at?), rotation) })
}

fn gripper(section: Section<'_>) -> Option<GripperSettings> {
    let fingers = section.required("fingers").and_then(|entry| finger_names(&section, entry));
    let opening_max = section.required_measure("opening_max", Quantity::Length, Bound::Positive);
    let free_opening = section.required_measure("free_opening", Quantity::Length, Bound::Positive);
    let force_max = section.required_measure("force_max", Quantity::Force, Bound::Positive);
    let finger_speed = section.required_measure("finger_speed", Quantity::Speed, Bound::Positive);
    section.finish();
    Some(GripperSettings {
        fingers: fingers?,
        opening_max: opening_max?,
        free_opening: free_opening?,
        force_max: force_max?,
        finger_speed: finger_speed?,
    })
}

fn finger_names(section: &Section<'_>, entry: &crate::tree::Entry) -> Option<[String; 2]> {
    if let Value::Array(nodes) = &entry.node.value
        && let [left, right] = &nodes[..]
        && let (Value::Text(left), Value::Text(right)) = (&left.value, &right.value)
    {
        return Some([left.clone(), right.clone()]);
    }
    let title = "fingers takes the names of the two fingers' joints";
    section.faults().report(Fault::new(
        "type",
        &entry.node.at,
        title,
        "write [\"left_joint\", \"right_joint\"]",
    ));
    None
}

fn allowed_contact(section: Section<'_>) -> Option<AllowedContact> {
    let text = |key: &str| section.required_text(key).map(|(text, _)| text.to_owned());
    let (a, b, reason) = (text("a"), text("b"), text("reason"));
    section.finish();
    Some(AllowedContact { a: a?, b: b?, reason: reason? })
}
