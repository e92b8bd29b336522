//! Reading a URDF strictly.
//!
//! Common readers are silent about bad files: a missing `<inertial>` is mass 0, a misspelt attribute is
//! ignored, `nan` is a number, an axis need not have length 1. Here a pass over the XML finds every fault
//! and its place first; only a text without fault goes to [`urdf_rs`].
//!
//! What is accepted is a serial arm with a two-finger gripper:
//! - links with primitive or STL collision shapes, every moving link with mass and inertia;
//! - revolute and prismatic joints with unit axes and limits of position, velocity and effort; fixed joints
//!   join their link to its parent rigidly;
//! - two prismatic joints on the last link of the arm are the fingers, one mimicking the other.
//!
//! `<visual>` is checked for form and otherwise not used: what collides is what is shown.
//!
//! ```
//! use graspcheck_model::urdf;
//!
//! let text = r#"<robot name="arm"><link name="base"/><link name="tip"/>
//!   <joint name="lift" type="prismatic"><parent link="base"/><child link="tip"/><axis xyz="0 0 2"/></joint></robot>"#;
//! let faults = urdf::parse(text).expect_err("it has faults");
//! // All faults come at once, each with its place in the text.
//! let axis = faults.iter().find(|fault| fault.title.contains("axis")).expect("an axis of length 2");
//! assert!(text[axis.span.clone()].contains("0 0 2"));
//! assert!(faults.iter().any(|fault| fault.title == "joint lift: no <limit>"));
//! ```

use std::{collections::BTreeMap, ops::Range};

use crate::robot::JointKind;

mod schema;
mod structure;
mod values;
mod walk;

pub use structure::Chain;

/// Something wrong in a URDF, as plain data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UrdfFault {
    /// Where, in bytes of the text.
    pub span: Range<usize>,
    /// Place and fact, a lower-case fragment, e.g. `joint elbow: no <limit>`.
    pub title: String,
    /// What to say at the place.
    pub label: String,
    /// What to change, where that is known.
    pub help: Option<String>,
}

/// A URDF without fault.
#[derive(Clone, Debug)]
pub struct UrdfDocument {
    /// What it says.
    pub robot: urdf_rs::Robot,
    /// How its links hang together.
    pub chain: Chain,
    places: BTreeMap<(PlaceKind, String), Range<usize>>,
}

/// What a place in the text is the place of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum PlaceKind {
    Link,
    Joint,
    Mesh,
}

impl UrdfDocument {
    /// Where the tag of a link stands in the text, in bytes; the start of the text when there is none.
    #[must_use]
    pub fn link_span(&self, name: &str) -> Range<usize> {
        self.span(PlaceKind::Link, name)
    }

    /// Where the tag of a joint stands in the text, in bytes; the start of the text when there is none.
    #[must_use]
    pub fn joint_span(&self, name: &str) -> Range<usize> {
        self.span(PlaceKind::Joint, name)
    }

    /// Where the name of a mesh file stands first in the text, in bytes; the start of the text when it
    /// does not.
    #[must_use]
    pub fn mesh_span(&self, filename: &str) -> Range<usize> {
        self.span(PlaceKind::Mesh, filename)
    }

    /// The kind of a joint that moves; none for a fixed joint and for a name that no joint has.
    #[must_use]
    pub fn joint_kind(&self, name: &str) -> Option<JointKind> {
        let joint = self.robot.joints.iter().find(|joint| joint.name == name)?;
        match joint.joint_type {
            urdf_rs::JointType::Revolute => Some(JointKind::Revolute),
            urdf_rs::JointType::Prismatic => Some(JointKind::Prismatic),
            _ => None,
        }
    }

    fn span(&self, kind: PlaceKind, name: &str) -> Range<usize> {
        self.places.get(&(kind, name.to_owned())).cloned().unwrap_or(0..0)
    }
}

/// The document that a URDF text holds.
///
/// # Errors
/// All faults of the text, in the order in which they stand in it.
pub fn parse(text: &str) -> Result<UrdfDocument, Vec<UrdfFault>> {
    let xml = roxmltree::Document::parse(text).map_err(|error| vec![malformed(text, &error)])?;
    walk::check_root(text, xml.root_element()).map_err(|fault| vec![fault])?;
    let mut faults = Vec::new();
    walk::check_form(text, xml.root_element(), &mut faults);
    values::check_values(text, xml.root_element(), &mut faults);
    let chain = structure::check_structure(text, xml.root_element(), &mut faults);
    if let (Some(chain), true) = (chain, faults.is_empty()) {
        match urdf_rs::read_from_string(text) {
            Ok(robot) => return Ok(UrdfDocument { robot, chain, places: places(text, &xml) }),
            Err(error) => faults.push(UrdfFault {
                span: walk::tag_span(text, xml.root_element()),
                title: format!("the URDF cannot be read: {error}"),
                label: "in this robot".to_owned(),
                help: None,
            }),
        }
    }
    faults.sort_by_key(|fault| (fault.span.start, fault.span.end));
    Err(faults)
}

/// A text that is not XML at all.
fn malformed(text: &str, error: &roxmltree::Error) -> UrdfFault {
    let at = error.pos();
    let line_start: usize = text.split_inclusive('\n').take(at.row as usize - 1).map(str::len).sum();
    let within: usize =
        text[line_start..].chars().take((at.col as usize).saturating_sub(1)).map(char::len_utf8).sum();
    let start = line_start + within;
    let end = start + text[start..].chars().next().map_or(0, char::len_utf8);
    UrdfFault {
        span: start..end,
        title: format!("not well-formed XML: {error}"),
        label: "here".to_owned(),
        help: None,
    }
}

/// Where links, joints and mesh files stand.
fn places(text: &str, xml: &roxmltree::Document<'_>) -> BTreeMap<(PlaceKind, String), Range<usize>> {
    let mut places = BTreeMap::new();
    for node in xml.descendants().filter(roxmltree::Node::is_element) {
        let (kind, key) = match node.tag_name().name() {
            "link" => (PlaceKind::Link, "name"),
            "joint" => (PlaceKind::Joint, "name"),
            "mesh" => (PlaceKind::Mesh, "filename"),
            _ => continue,
        };
        if let Some(attribute) = node.attribute_node(key) {
            let span = match kind {
                PlaceKind::Mesh => attribute.range_value(),
                PlaceKind::Link | PlaceKind::Joint => walk::tag_span(text, node),
            };
            places.entry((kind, attribute.value().to_owned())).or_insert(span);
        }
    }
    places
}
