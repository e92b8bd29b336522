//! The object and its handles.

use graspcheck_model::{
    Pose,
    object::{Handle, Object},
    shape::Shape,
};
use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

use crate::{
    fault::{Fault, Place},
    quantity::Quantity,
    section::{Bound, Section, numbers},
    shape::{shape, upright_pose},
    tree::Value,
};

/// How far the cosine between pads and faces may be from 1: 4.5e-5 rad, the rounding of an angle written
/// with two decimals of a degree; more is an edge between the pads.
const FACE_TOLERANCE: f64 = 1e-9;

/// An object, with the places that faults about it point to.
pub(crate) struct PlacedObject<'a> {
    pub(crate) object: Object,
    pub(crate) name_at: &'a Place,
    /// Where its position stands.
    pub(crate) at: &'a Place,
    /// One for each handle: where its approach stands, and whether that is "down".
    pub(crate) handles: Vec<HandlePlace<'a>>,
}

/// Where a handle stands.
pub(crate) struct HandlePlace<'a> {
    pub(crate) at: &'a Place,
    pub(crate) down: bool,
}

/// The object as far as it could be read.
pub(crate) struct ReadObject<'a> {
    /// Its name, known also when it has faults.
    pub(crate) name: Option<&'a str>,
    /// None when there is no object or it has faults.
    pub(crate) placed: Option<PlacedObject<'a>>,
}

/// Reads `[object.NAME]`.
pub(crate) fn object<'a>(scenario: &Section<'a>) -> ReadObject<'a> {
    let mut read = ReadObject { name: None, placed: None };
    let Some(objects) = scenario.section("object", "the objects") else { return read };
    for (name, at, section) in objects.named_sections("an object") {
        let placed = one(name, at, section);
        if read.name.is_none() {
            read = ReadObject { name: Some(name), placed };
        } else {
            let title = format!("a scenario has one object, `{name}` is another");
            scenario.faults().report(Fault::new("object", at, title, "make it a body of the cell"));
        }
    }
    objects.finish();
    read
}

fn one<'a>(name: &str, name_at: &'a Place, section: Section<'a>) -> Option<PlacedObject<'a>> {
    let shape = shape(&section);
    let mass = section.required_measure("mass", Quantity::Mass, Bound::Positive);
    let friction = section.required_plain("friction", Bound::NotNegative);
    let world_from_object = upright_pose(&section);
    let at = section.place_of("at", Quantity::Length).unwrap_or(name_at);
    let mut handles = Vec::new();
    let mut places = Vec::new();
    for (index, handle_section) in section.sections("handle", "a handle").into_iter().enumerate() {
        let (at, down) = (handle_section.place(), is_down(&handle_section));
        handles.push(handle(index, handle_section, shape.as_ref()));
        places.push(HandlePlace { at, down });
    }
    section.finish();
    let object = Object {
        name: name.to_owned(),
        shape: shape?,
        mass: mass?,
        friction: friction?,
        world_from_object: world_from_object?,
        handles: handles.into_iter().collect::<Option<Vec<_>>>()?,
    };
    Some(PlacedObject { object, name_at, at, handles: places })
}

fn is_down(section: &Section<'_>) -> bool {
    section.entry("approach").is_some_and(|entry| entry.node.value == Value::Text("down".to_owned()))
}

fn handle(index: usize, section: Section<'_>, shape: Option<&Shape>) -> Option<Handle> {
    let name = match section.has("name") {
        true => section.text("name").map(|(name, _)| name.to_owned()),
        false => Some(format!("handle {}", index + 1)),
    };
    let at = match section.mentions("at") {
        true => section.required_vector("at", Quantity::Length),
        false => Some(Vector3::zeros()),
    };
    let axes = axes(&section);
    let half_turn = section.word("symmetry", &[("none", false), ("half_turn", true)], Some(false));
    let (place, faults) = (section.place(), section.faults());
    section.finish();
    let (x, y) = axes?;
    let shape = shape?;
    if !has_faces_across(shape, &y) {
        let title = "the fingers would close on edges: across a box they close along one of its axes";
        faults.report(Fault::new("handle", place, title, "turn it to a face"));
        return None;
    }
    let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, x.cross(&y)]));
    let rotation = UnitQuaternion::from_rotation_matrix(&rotation);
    Some(Handle {
        name: name?,
        object_from_handle: Pose::from_parts(Translation3::from(at?), rotation),
        width: (shape.support(&y) - shape.support(&-y)).dot(&y),
        half_turn: half_turn?,
    })
}

/// The direction of approach and the direction of closing, in the object's frame.
///
/// `approach = "down"` is −z, and the fingers close along x, turned by `turned_deg` about z. A direction of
/// two numbers lies in the object's x-y plane, and the fingers close in that plane.
fn axes(section: &Section<'_>) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let entry = section.required("approach")?;
    let turned = section.measure("turned", Quantity::Angle, Bound::Any);
    match &entry.node.value {
        Value::Text(word) if word == "down" => {
            let (sin, cos) = turned.unwrap_or(0.0).sin_cos();
            Some((-Vector3::z(), Vector3::new(cos, sin, 0.0)))
        }
        Value::Array(_) => {
            let [x, y] = numbers("approach", &entry.node, section.faults())?;
            if section.mentions("turned") {
                let title = "`turned_deg` belongs to `approach = \"down\"`; a direction fixes the fingers";
                section.faults().report(Fault::new("handle", section.place(), title, "remove `turned_deg`"));
                return None;
            }
            let direction = Vector3::new(x, y, 0.0).try_normalize(0.0);
            if direction.is_none() {
                let title = "approach is a direction of length 0";
                section.faults().report(Fault::new(
                    "range",
                    &entry.node.at,
                    title,
                    "write for example [0, -1]",
                ));
            }
            direction.map(|x| (x, Vector3::z().cross(&x)))
        }
        other => {
            let title =
                format!("approach takes \"down\" or a direction such as [0, -1], not {}", other.kind());
            section.faults().report(Fault::new("type", &entry.node.at, title, "write \"down\""));
            None
        }
    }
}

/// Whether two parallel faces stand across `direction`; what is round counts as having them.
fn has_faces_across(shape: &Shape, direction: &Vector3<f64>) -> bool {
    match shape {
        Shape::Box { .. } => direction.iter().any(|part| 1.0 - part.abs() < FACE_TOLERANCE),
        _ => true,
    }
}
