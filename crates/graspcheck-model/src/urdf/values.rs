//! What the numbers and words of links and joints mean, one element at a time.

use nalgebra::{Matrix3, Point3, Vector3};
use roxmltree::Node;

use super::{
    UrdfFault,
    walk::{named_children, nearest, numbers, place, tag_span},
};
use crate::inertia::Inertial;

/// How far the length of an axis may be from 1: a direction written with six digits.
const AXIS_LENGTH_TOLERANCE: f64 = 1e-6;

/// The kinds of joints that graspcheck reads.
const JOINT_TYPES: [&str; 3] = ["revolute", "prismatic", "fixed"];

/// Adds the faults that an element has in itself although its form is right.
pub(super) fn check_values(text: &str, root: Node<'_, '_>, faults: &mut Vec<UrdfFault>) {
    if let Some(version) = root.attribute_node("version").filter(|version| version.value() != "1.0") {
        faults.push(UrdfFault {
            span: version.range_value(),
            title: format!("{}: URDF version {}", place(root), version.value()),
            label: "graspcheck reads version 1.0".to_owned(),
            help: None,
        });
    }
    for node in root.descendants().filter(Node::is_element) {
        match node.tag_name().name() {
            "geometry" => check_geometry(text, node, faults),
            "mesh" => check_mesh(node, faults),
            "inertial" => check_inertial(text, node, faults),
            "joint" => check_joint(text, node, faults),
            _ => {}
        }
    }
}

fn check_geometry(text: &str, node: Node<'_, '_>, faults: &mut Vec<UrdfFault>) {
    let shapes: Vec<Node<'_, '_>> = node.children().filter(Node::is_element).collect();
    if shapes.len() != 1 {
        faults.push(UrdfFault {
            span: shapes.get(1).map_or_else(|| tag_span(text, node), |second| tag_span(text, *second)),
            title: format!("{}: <geometry> with {} shapes", place(node), shapes.len()),
            label: "must hold exactly one".to_owned(),
            help: Some("one of box, sphere, cylinder, capsule, mesh".to_owned()),
        });
    }
}

/// A mesh that collides must be an STL; one that is only shown is not read.
fn check_mesh(node: Node<'_, '_>, faults: &mut Vec<UrdfFault>) {
    let collides = node.ancestors().any(|ancestor| ancestor.tag_name().name() == "collision");
    let Some(filename) = node.attribute_node("filename").filter(|_| collides) else { return };
    if !filename.value().to_ascii_lowercase().ends_with(".stl") {
        faults.push(UrdfFault {
            span: filename.range_value(),
            title: format!("{}: mesh {} is not an STL file", place(node), filename.value()),
            label: "only .stl is read".to_owned(),
            help: Some("convert it to STL; its convex hull is what collides".to_owned()),
        });
    }
}

fn check_inertial(text: &str, node: Node<'_, '_>, faults: &mut Vec<UrdfFault>) {
    let mass = named_children(node, "mass").next().and_then(|mass| numbers::<1>(mass, "value"));
    let Some(inertia) = named_children(node, "inertia").next() else { return };
    let entries = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"].map(|name| numbers::<1>(inertia, name));
    let (Some([mass]), [Some([xx]), Some([xy]), Some([xz]), Some([yy]), Some([yz]), Some([zz])]) =
        (mass.filter(|[mass]| *mass > 0.0), entries)
    else {
        return; // The form is wrong and was reported.
    };
    let tensor = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    if let Err(error) = (Inertial { mass, center: Point3::origin(), tensor }).validate() {
        faults.push(UrdfFault {
            span: tag_span(text, inertia),
            title: format!("{}: {error}", place(node)),
            label: "no rigid body has this inertia".to_owned(),
            help: None,
        });
    }
}

fn check_joint(text: &str, node: Node<'_, '_>, faults: &mut Vec<UrdfFault>) {
    let Some(kind) = node.attribute_node("type") else { return };
    if !JOINT_TYPES.contains(&kind.value()) {
        let label = match kind.value() {
            "continuous" => "write revolute, with limits".to_owned(),
            "floating" | "planar" | "spherical" => "an arm has joints of one degree of freedom".to_owned(),
            other => match nearest(other, &JOINT_TYPES) {
                Some(meant) => format!("did you mean `{meant}`?"),
                None => "not a type of joint".to_owned(),
            },
        };
        faults.push(UrdfFault {
            span: kind.range_value(),
            title: format!("{}: type {} is not supported", place(node), kind.value()),
            label,
            help: Some("revolute, prismatic or fixed".to_owned()),
        });
    } else if kind.value() != "fixed" {
        check_axis(text, node, faults);
        check_limit(text, node, faults);
        check_mimic(node, faults);
    }
}

fn check_axis(text: &str, joint: Node<'_, '_>, faults: &mut Vec<UrdfFault>) {
    let Some(axis) = named_children(joint, "axis").next() else {
        faults.push(UrdfFault {
            span: tag_span(text, joint),
            title: format!("{}: no <axis>", place(joint)),
            label: "other readers take x".to_owned(),
            help: Some("write it: <axis xyz=\"0 0 1\"/>".to_owned()),
        });
        return;
    };
    let Some(xyz) = numbers::<3>(axis, "xyz") else { return };
    let length = Vector3::from(xyz).norm();
    if (length - 1.0).abs() > AXIS_LENGTH_TOLERANCE {
        let [x, y, z] = xyz.map(|value| value / length);
        faults.push(UrdfFault {
            span: axis.attribute_node("xyz").map_or(0..0, |attribute| attribute.range_value()),
            title: format!("{}: axis has length {length}, must be 1", place(joint)),
            label: "not a unit vector".to_owned(),
            help: (length > 0.0).then(|| format!("<axis xyz=\"{x} {y} {z}\"/>")),
        });
    }
}

fn check_limit(text: &str, joint: Node<'_, '_>, faults: &mut Vec<UrdfFault>) {
    let Some(limit) = named_children(joint, "limit").next() else {
        faults.push(UrdfFault {
            span: tag_span(text, joint),
            title: format!("{}: no <limit>", place(joint)),
            label: "needs lower, upper, effort and velocity".to_owned(),
            help: None,
        });
        return;
    };
    if let (Some([lower]), Some([upper])) = (numbers::<1>(limit, "lower"), numbers::<1>(limit, "upper"))
        && lower >= upper
    {
        faults.push(UrdfFault {
            span: tag_span(text, limit),
            title: format!("{}: lower {lower} is not below upper {upper}", place(joint)),
            label: "leaves no room to move".to_owned(),
            help: None,
        });
    }
}

/// Fingers move by equal amounts: nothing else mimics.
fn check_mimic(joint: Node<'_, '_>, faults: &mut Vec<UrdfFault>) {
    let Some(mimic) = named_children(joint, "mimic").next() else { return };
    for (name, wanted) in [("multiplier", 1.0), ("offset", 0.0)] {
        let Some([value]) = numbers::<1>(mimic, name) else { continue };
        #[expect(clippy::float_cmp, reason = "the text says 1 or 0, or something else")]
        if value != wanted {
            faults.push(UrdfFault {
                span: mimic.attribute_node(name).map_or(0..0, |attribute| attribute.range_value()),
                title: format!("{}: mimic {name} {value} must be {wanted}", place(joint)),
                label: "both fingers move by the same amount".to_owned(),
                help: None,
            });
        }
    }
}
