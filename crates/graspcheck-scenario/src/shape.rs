//! Solids and poses as files give them.

use graspcheck_model::{Pose, shape::Shape};
use nalgebra::{Point3, Translation3, UnitQuaternion, Vector3};

use crate::{
    fault::Fault,
    quantity::Quantity,
    section::{Bound, Section, numbers, wrong_type},
    tree::Value,
};

const KINDS: [&str; 5] = ["box", "sphere", "cylinder", "capsule", "hull"];

/// The solid under the key `shape`, which holds exactly one of [`KINDS`].
pub(crate) fn shape(section: &Section<'_>) -> Option<Shape> {
    let kinds = section.required_section("shape", "a shape")?;
    let given: Vec<_> = KINDS.into_iter().filter(|kind| kinds.mentions(kind)).collect();
    let shape = match given[..] {
        [kind] => read_kind(&kinds, kind),
        [] => {
            let title = format!("a shape is one of {}", KINDS.join(", "));
            let fault = Fault::new(
                "missing-key",
                kinds.place(),
                title,
                "write for example `{ box_mm = [30, 30, 30] }`",
            );
            kinds.faults().report(fault);
            None
        }
        _ => {
            let title = format!("a shape is one solid, this has {}: {}", given.len(), given.join(", "));
            kinds.faults().report(Fault::new("shape", kinds.place(), title, "keep one of them"));
            None
        }
    };
    let place = kinds.place();
    kinds.finish();
    let shape = shape?;
    match shape.validate() {
        Ok(()) => Some(shape),
        Err(error) => {
            let title = format!("this is no solid: {error}");
            section.faults().report(Fault::new("shape", place, title, "not a solid"));
            None
        }
    }
}

fn read_kind(kinds: &Section<'_>, kind: &str) -> Option<Shape> {
    match kind {
        "box" => {
            let size: [f64; 3] = kinds.measures("box", Quantity::Length)?;
            let half_extents = Vector3::from(size) / 2.0;
            positive(kinds, &size).then_some(Shape::Box { half_extents })
        }
        "hull" => hull(kinds),
        _ => {
            let what = if kind == "sphere" { "a sphere" } else { "a solid along z" };
            let solid = kinds.required_section(kind, what)?;
            let radius = solid.required_measure("radius", Quantity::Length, Bound::Positive);
            let length = match kind {
                "sphere" => Some(0.0),
                _ => solid.required_measure("length", Quantity::Length, Bound::Positive),
            };
            solid.finish();
            let (radius, half_length) = (radius?, length? / 2.0);
            Some(match kind {
                "sphere" => Shape::Sphere { radius },
                "cylinder" => Shape::Cylinder { radius, half_length },
                _ => Shape::Capsule { radius, half_length },
            })
        }
    }
}

fn positive(kinds: &Section<'_>, size: &[f64; 3]) -> bool {
    let fits = size.iter().all(|length| *length > 0.0);
    if !fits {
        let title = "a box has three lengths greater than 0".to_owned();
        kinds.faults().report(Fault::new("range", kinds.place(), title, "write three positive lengths"));
    }
    fits
}

fn hull(kinds: &Section<'_>) -> Option<Shape> {
    let (key, entry, to_si) = kinds.with_unit("hull", Quantity::Length)?;
    let Value::Array(nodes) = &entry.node.value else {
        wrong_type(&key, &entry.node, "a list of points", kinds.faults());
        return None;
    };
    let read: Vec<Option<[f64; 3]>> = nodes.iter().map(|node| numbers(&key, node, kinds.faults())).collect();
    let points: Option<Vec<_>> =
        read.into_iter().map(|point| point.map(|point| Point3::from(point.map(to_si)))).collect();
    Some(Shape::Hull { points: points? })
}

/// The pose under the keys `at_mm` and `yaw_deg` (a turn about the world's z; 0 when absent).
pub(crate) fn upright_pose(section: &Section<'_>) -> Option<Pose> {
    let at = section.required_vector("at", Quantity::Length);
    let yaw = section.measure("yaw", Quantity::Angle, Bound::Any).unwrap_or(0.0);
    Some(Pose::from_parts(Translation3::from(at?), UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw)))
}
