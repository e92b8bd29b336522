//! The task: pick and place, via points, joint segments, paths of the tool.

use graspcheck_model::{
    Pose,
    robot::{Joint, JointKind, RobotModel},
    task::{JointSegment, JointSegments, PickAndPlace, Task},
};

use crate::{
    fault::{Fault, Faults, Place},
    motion::GripPace,
    path_task,
    quantity::Quantity,
    robot_file::wrong_kind,
    section::{Bound, Section},
    shape::upright_pose,
    suggest::nearest,
    via_task,
};

/// How far the straight approach begins before the handle when the scenario does not say, m.
pub const PREGRASP_DEFAULT: f64 = 0.06;

/// How far joint polynomials may leave a Cartesian motion when the scenario does not say, m and rad: below
/// what an encoder of 20 bit resolves at the end of a long arm.
pub const PATH_TOLERANCE_DEFAULT: f64 = 1e-5;

/// The phases of pick and place in which the arm moves.
pub(crate) const ARM_PHASES: [&str; 6] = ["approach", "descend", "lift", "carry", "lower", "retreat"];

/// Those of them that are joint moves.
pub(crate) const JOINT_MOVES: [&str; 2] = ["approach", "carry"];

/// The only phase of a motion through via points.
const VIA_PHASE: &str = "via";

/// The kind of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    PickAndPlace,
    Via,
    JointVia,
    Segments,
    Path,
}

/// A task as far as it could be read; its kind and the names of its phases are known earlier than all of it.
pub(crate) struct ReadTask {
    pub(crate) kind: Option<Kind>,
    pub(crate) phases: Vec<String>,
    pub(crate) task: Option<Task>,
}

/// Reads `[task]`. Joint positions can only be read where the robot is known; `object` is the name of the
/// object, if there is one.
pub(crate) fn task(
    section: Section<'_>,
    robot: Option<&RobotModel>,
    object: Option<&str>,
    grip: Option<&GripPace>,
) -> ReadTask {
    let kinds = [
        ("pick_and_place", Kind::PickAndPlace),
        ("via", Kind::Via),
        ("joint_via", Kind::JointVia),
        ("segments", Kind::Segments),
        ("path", Kind::Path),
    ];
    let kind = section.word("kind", &kinds, None);
    let mut phases = Vec::new();
    let task = match kind {
        Some(Kind::PickAndPlace) => {
            phases.extend(ARM_PHASES.map(str::to_owned));
            pick_and_place(&section, robot, object, grip).map(Task::PickAndPlace)
        }
        Some(Kind::Via) => {
            phases.push(VIA_PHASE.to_owned());
            via_task::of_wrist(&section).map(Task::CartesianVia)
        }
        Some(Kind::JointVia) => {
            phases.push(VIA_PHASE.to_owned());
            via_task::of_joints(&section, robot).map(Task::JointVia)
        }
        Some(Kind::Segments) => {
            let (names, segments) = segments(&section, robot);
            phases = names;
            segments.map(Task::JointSegments)
        }
        Some(Kind::Path) => {
            let (names, path) = path_task::path(&section, robot);
            phases = names;
            path.map(Task::Path)
        }
        // Without a kind nobody knows which keys belong here.
        None => return ReadTask { kind, phases, task: None },
    };
    section.finish();
    ReadTask { kind, phases, task }
}

fn pick_and_place(
    section: &Section<'_>,
    robot: Option<&RobotModel>,
    object: Option<&str>,
    grip: Option<&GripPace>,
) -> Option<PickAndPlace> {
    let named = object_named(section, object);
    let start = start_position(section, robot);
    let place = section.required_section("place", "a place").and_then(|place| {
        let pose = upright_pose(&place);
        place.finish();
        pose
    });
    let pregrasp = section.measure_or("pregrasp", Quantity::Length, Bound::Positive, PREGRASP_DEFAULT);
    let departure = section.required_vector("departure", Quantity::Length);
    let arrival = section.required_vector("arrival", Quantity::Length);
    let retreat = match section.measure("retreat", Quantity::Length, Bound::Positive) {
        None if !section.mentions("retreat") => pregrasp,
        given => given,
    };
    named?;
    let grip = grip?;
    let world_from_placed: Pose = place?;
    Some(PickAndPlace {
        start: start?,
        world_from_placed,
        pregrasp_distance: pregrasp?,
        departure: departure?,
        arrival: arrival?,
        retreat_distance: retreat?,
        grip_force: grip.force,
        close_duration: grip.close,
        open_duration: grip.open,
    })
}

/// Reads `[task.start]`: a position for each joint, within its limits.
pub(crate) fn start_position(section: &Section<'_>, robot: Option<&RobotModel>) -> Option<Vec<f64>> {
    let start = section.required_section("start", "a start position")?;
    let robot = robot?;
    let positions = joint_positions(start, &robot.joints);
    within_limits(&positions, &robot.joints, section.faults()).then(|| positions_of(positions)).flatten()
}

/// Holds the key `object` against the object that there is.
fn object_named(section: &Section<'_>, object: Option<&str>) -> Option<()> {
    let (name, at) = section.required_text("object")?;
    if object == Some(name) {
        return Some(());
    }
    let title = format!("unknown object `{name}`");
    let label = match object {
        Some(object) => format!("the object is `{object}`"),
        None => format!("add [object.{name}]"),
    };
    section.faults().report(Fault::new("unknown-object", at, title, label));
    None
}

/// The position of a joint with its place.
struct Position<'a> {
    value: f64,
    at: &'a Place,
}

/// Reads one position for each joint; the unit follows the joint's kind.
fn joint_positions<'a>(section: Section<'a>, joints: &[Joint]) -> Vec<Option<Position<'a>>> {
    let read = joints
        .iter()
        .map(|joint| {
            let slides = joint.kind == JointKind::Prismatic;
            let quantity = if slides { Quantity::Length } else { Quantity::Angle };
            if wrong_kind(&section, &joint.name, slides, &joint.name, quantity) {
                return None;
            }
            if !section.mentions(&joint.name) {
                section.missing(&quantity.key(&joint.name));
            }
            section.measure_at(&joint.name, quantity, Bound::Any).map(|(value, at)| Position { value, at })
        })
        .collect();
    section.finish();
    read
}

/// The values, if all could be read.
fn positions_of(positions: Vec<Option<Position<'_>>>) -> Option<Vec<f64>> {
    positions.into_iter().map(|position| position.map(|position| position.value)).collect()
}

/// Reports every start position outside its joint's limits, and returns whether there is none.
fn within_limits(positions: &[Option<Position<'_>>], joints: &[Joint], faults: &Faults) -> bool {
    let mut inside = true;
    for (position, joint) in positions.iter().zip(joints) {
        let Some(position) = position else { continue };
        let limits = &joint.limits;
        let (limit, relation, word) = if position.value < limits.position_min {
            (limits.position_min, "below", "low")
        } else if position.value > limits.position_max {
            (limits.position_max, "above", "high")
        } else {
            continue;
        };
        inside = false;
        let shown = |value: f64| match joint.kind {
            JointKind::Revolute => format!("{:.1}°", value.to_degrees()),
            JointKind::Prismatic => format!("{:.1} mm", value * 1000.0),
        };
        let excess = shown((position.value - limit).abs());
        let title = format!(
            "joint {}: start {} is {relation} {} by {excess}",
            joint.name,
            shown(position.value),
            shown(limit)
        );
        let fault = Fault::new("outside-limit", position.at, title, format!("{excess} too {word}"));
        faults.report(fault.help("the limit comes from the robot's URDF"));
    }
    inside
}

fn segments(section: &Section<'_>, robot: Option<&RobotModel>) -> (Vec<String>, Option<JointSegments>) {
    let mut names: Vec<String> = Vec::new();
    let mut segments: Vec<Option<JointSegment>> = Vec::new();
    let mut last_end: Option<Vec<f64>> = None;
    for segment in section.sections("segment", "a segment") {
        let name = segment_name(&segment, &mut names);
        let from = match (segments.is_empty(), segment.has("from")) {
            (false, false) => last_end.clone(),
            _ => segment.required_section("from", "joint positions").and_then(|from| values(from, robot)),
        };
        let to = segment.required_section("to", "joint positions").and_then(|to| values(to, robot));
        segment.finish();
        last_end.clone_from(&to);
        let read = || Some(JointSegment { name: name?, from: from?, to: to? });
        segments.push(read());
    }
    let segments = at_least_one(section, segments);
    (names, segments.map(|segments| JointSegments { segments }))
}

/// The name of a segment, which becomes one of `names`; a name that is there already is reported.
pub(crate) fn segment_name(segment: &Section<'_>, names: &mut Vec<String>) -> Option<String> {
    let (name, at) = segment.required_text("name")?;
    if names.iter().any(|other| other == name) {
        let title = format!("two segments are named `{name}`");
        segment.faults().report(Fault::new("name", at, title, "names are unique"));
    }
    names.push(name.to_owned());
    Some(name.to_owned())
}

/// All segments, if each could be read; that there is none is reported.
pub(crate) fn at_least_one<T>(section: &Section<'_>, segments: Vec<Option<T>>) -> Option<Vec<T>> {
    if segments.is_empty() {
        let title = "a motion has at least one segment";
        section.faults().report(Fault::new("missing-key", section.place(), title, "add [[task.segment]]"));
        return None;
    }
    segments.into_iter().collect()
}

fn values(section: Section<'_>, robot: Option<&RobotModel>) -> Option<Vec<f64>> {
    positions_of(joint_positions(section, &robot?.joints))
}

/// Reports a phase that the task does not have.
pub(crate) fn unknown_phase(name: &str, at: &Place, phases: &[String], section: &Section<'_>) {
    let label = match nearest(name, phases.iter().map(String::as_str)) {
        Some(near) => format!("did you mean `{near}`?"),
        None if phases.is_empty() => "this task has no phase with a pace of its own".to_owned(),
        None => format!("the phases are {}", phases.join(", ")),
    };
    section.faults().report(Fault::new("unknown-phase", at, format!("unknown phase `{name}`"), label));
}
