//! The elements and attributes that a URDF may have, as data.

/// An element: its attributes and children.
pub(super) struct Element {
    pub(super) name: &'static str,
    pub(super) attributes: &'static [Attribute],
    pub(super) children: &'static [Child],
}

/// An attribute of an element.
pub(super) struct Attribute {
    pub(super) name: &'static str,
    pub(super) required: bool,
    pub(super) value: Value,
}

/// What an attribute's text must be.
#[derive(Clone, Copy)]
pub(super) enum Value {
    /// Any text that is not empty.
    Text,
    /// This many finite numbers with spaces between, each with this sign.
    Numbers(usize, Sign),
}

/// Which signs of a number are allowed.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Sign {
    Any,
    Positive,
    NotNegative,
}

/// A child of an element, and how often it may stand.
pub(super) struct Child {
    pub(super) element: &'static Element,
    pub(super) count: Count,
}

/// How often a child may stand.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Count {
    AtMostOnce,
    Once,
    Any,
}

use Count::{Any, AtMostOnce, Once};
use Sign::{NotNegative, Positive};
use Value::{Numbers, Text};

const fn required(name: &'static str, value: Value) -> Attribute {
    Attribute { name, required: true, value }
}

const fn optional(name: &'static str, value: Value) -> Attribute {
    Attribute { name, required: false, value }
}

const fn child(count: Count, element: &'static Element) -> Child {
    Child { element, count }
}

const NUMBER: Value = Numbers(1, Sign::Any);
const VECTOR: Value = Numbers(3, Sign::Any);

/// The whole document.
pub(super) static ROBOT: Element = Element {
    name: "robot",
    attributes: &[required("name", Text), optional("version", Text)],
    children: &[child(Any, &LINK), child(Any, &JOINT), child(Any, &MATERIAL)],
};

static LINK: Element = Element {
    name: "link",
    attributes: &[required("name", Text)],
    children: &[child(AtMostOnce, &INERTIAL), child(Any, &VISUAL), child(Any, &COLLISION)],
};

static INERTIAL: Element = Element {
    name: "inertial",
    attributes: &[],
    children: &[child(AtMostOnce, &ORIGIN), child(Once, &MASS), child(Once, &INERTIA)],
};

static MASS: Element =
    Element { name: "mass", attributes: &[required("value", Numbers(1, Positive))], children: &[] };

static INERTIA: Element = Element {
    name: "inertia",
    attributes: &[
        required("ixx", NUMBER),
        required("ixy", NUMBER),
        required("ixz", NUMBER),
        required("iyy", NUMBER),
        required("iyz", NUMBER),
        required("izz", NUMBER),
    ],
    children: &[],
};

static ORIGIN: Element = Element {
    name: "origin",
    attributes: &[optional("xyz", VECTOR), optional("rpy", VECTOR)],
    children: &[],
};

static VISUAL: Element = Element {
    name: "visual",
    attributes: &[optional("name", Text)],
    children: &[child(AtMostOnce, &ORIGIN), child(Once, &GEOMETRY), child(AtMostOnce, &MATERIAL)],
};

static COLLISION: Element = Element {
    name: "collision",
    attributes: &[optional("name", Text)],
    children: &[child(AtMostOnce, &ORIGIN), child(Once, &GEOMETRY)],
};

/// Exactly one of its children must stand; [`super::values`] counts them.
static GEOMETRY: Element = Element {
    name: "geometry",
    attributes: &[],
    children: &[
        child(AtMostOnce, &BOX),
        child(AtMostOnce, &SPHERE),
        child(AtMostOnce, &CYLINDER),
        child(AtMostOnce, &CAPSULE),
        child(AtMostOnce, &MESH),
    ],
};

static BOX: Element =
    Element { name: "box", attributes: &[required("size", Numbers(3, Positive))], children: &[] };

static SPHERE: Element =
    Element { name: "sphere", attributes: &[required("radius", Numbers(1, Positive))], children: &[] };

static CYLINDER: Element = Element {
    name: "cylinder",
    attributes: &[required("radius", Numbers(1, Positive)), required("length", Numbers(1, Positive))],
    children: &[],
};

static CAPSULE: Element = Element {
    name: "capsule",
    attributes: &[required("radius", Numbers(1, Positive)), required("length", Numbers(1, Positive))],
    children: &[],
};

static MESH: Element = Element {
    name: "mesh",
    attributes: &[required("filename", Text), optional("scale", Numbers(3, Positive))],
    children: &[],
};

static MATERIAL: Element = Element {
    name: "material",
    attributes: &[required("name", Text)],
    children: &[child(AtMostOnce, &COLOR), child(AtMostOnce, &TEXTURE)],
};

static COLOR: Element =
    Element { name: "color", attributes: &[required("rgba", Numbers(4, NotNegative))], children: &[] };

static TEXTURE: Element =
    Element { name: "texture", attributes: &[required("filename", Text)], children: &[] };

static JOINT: Element = Element {
    name: "joint",
    attributes: &[required("name", Text), required("type", Text)],
    children: &[
        child(AtMostOnce, &ORIGIN),
        child(Once, &PARENT),
        child(Once, &CHILD),
        child(AtMostOnce, &AXIS),
        child(AtMostOnce, &LIMIT),
        child(AtMostOnce, &DYNAMICS),
        child(AtMostOnce, &MIMIC),
    ],
};

static PARENT: Element = Element { name: "parent", attributes: &[required("link", Text)], children: &[] };

static CHILD: Element = Element { name: "child", attributes: &[required("link", Text)], children: &[] };

static AXIS: Element = Element { name: "axis", attributes: &[required("xyz", VECTOR)], children: &[] };

static LIMIT: Element = Element {
    name: "limit",
    attributes: &[
        required("lower", NUMBER),
        required("upper", NUMBER),
        required("effort", Numbers(1, Positive)),
        required("velocity", Numbers(1, Positive)),
    ],
    children: &[],
};

static DYNAMICS: Element = Element {
    name: "dynamics",
    attributes: &[
        optional("damping", Numbers(1, NotNegative)),
        optional("friction", Numbers(1, NotNegative)),
    ],
    children: &[],
};

static MIMIC: Element = Element {
    name: "mimic",
    attributes: &[required("joint", Text), optional("multiplier", NUMBER), optional("offset", NUMBER)],
    children: &[],
};
