//! The arms of the trials: the two of the asset folder, and random chains of six joints.

use std::f64::consts::PI;

use graspcheck_model::{
    Pose,
    robot::{AllowedContact, Joint, JointKind, JointLimits, RobotModel},
    settings::{GripperSettings, JointSettings, RobotSettings, ToolSettings},
    shape::{PlacedShape, Shape},
    urdf,
};
use nalgebra::{Isometry3, Point3, Translation3, Unit, UnitQuaternion, Vector3};

use super::fixtures::{self, Draw};

/// A kind of arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arm {
    Scara,
    Rrr,
    /// Six joints about and along any axes, another arm for every scene.
    Chain,
}

impl Arm {
    pub const ALL: [Self; 3] = [Self::Scara, Self::Rrr, Self::Chain];

    pub fn name(self) -> &'static str {
        match self {
            Self::Scara => "scara",
            Self::Rrr => "rrr",
            Self::Chain => "chain",
        }
    }

    /// A length by which the arm's surroundings are scaled: one for an arm of about half a metre.
    pub fn scale(self) -> f64 {
        match self {
            Self::Scara | Self::Chain => 1.0,
            Self::Rrr => 8.0,
        }
    }

    /// The arm itself, or one of the chains.
    pub fn robot(self, draw: &mut Draw) -> RobotModel {
        match self {
            Self::Scara => scara(),
            Self::Rrr => rrr(),
            Self::Chain => chain(draw),
        }
    }
}

/// The SCARA of the asset folder.
pub fn scara() -> RobotModel {
    let down = UnitQuaternion::from_euler_angles(0.0, PI / 2.0, 0.0);
    // The tool's y is the hand's x.
    let across = UnitQuaternion::from_euler_angles(0.0, 0.0, -PI / 2.0);
    let settings = RobotSettings {
        world_from_base: Pose::identity(),
        joints: vec![
            joint("shoulder", 60.0, 3000.0, 0.12),
            joint("elbow", 100.0, 5000.0, 0.04),
            joint("quill", 15.0, 1000.0, 6.0),
            joint("wrist", 200.0, 15000.0, 0.0015),
        ],
        tool: ToolSettings {
            link: "hand".to_owned(),
            link_from_tool: Isometry3::from_parts(Translation3::new(0.0, 0.0, -0.1), across * down),
        },
        gripper: gripper(0.07, 0.006, 20.0, 0.06),
        allowed_contacts: neighbours(&["base", "upper_arm", "forearm", "quill", "hand"]),
    };
    assembled("scara", include_str!("../../../../assets/robots/scara/scara.urdf"), &settings)
}

/// The planar R-R-R of the asset folder.
pub fn rrr() -> RobotModel {
    let settings = RobotSettings {
        world_from_base: Pose::identity(),
        joints: vec![
            joint("shoulder", 2.5, 25.0, 5.0),
            joint("elbow", 2.5, 25.0, 2.0),
            joint("wrist", 4.0, 40.0, 0.2),
        ],
        tool: ToolSettings { link: "hand".to_owned(), link_from_tool: Pose::translation(1.0, 0.0, 0.0) },
        gripper: gripper(0.36, 0.04, 100.0, 0.15),
        allowed_contacts: neighbours(&["base", "upper_arm", "forearm", "hand"]),
    };
    assembled("rrr", include_str!("../../../../assets/robots/rrr/rrr.urdf"), &settings)
}

fn joint(name: &str, acceleration: f64, jerk: f64, rotor_inertia: f64) -> JointSettings {
    JointSettings { name: name.to_owned(), acceleration, jerk, rotor_inertia }
}

fn gripper(opening_max: f64, free_opening: f64, force_max: f64, finger_speed: f64) -> GripperSettings {
    let fingers = ["finger_left_slide", "finger_right_slide"].map(str::to_owned);
    GripperSettings { fingers, opening_max, free_opening, force_max, finger_speed }
}

fn neighbours(names: &[&str]) -> Vec<AllowedContact> {
    let hand = names[names.len() - 1];
    let fingers = [(hand, "finger_left"), (hand, "finger_right"), ("finger_left", "finger_right")];
    let allowed = |(a, b): (&str, &str)| AllowedContact {
        a: a.to_owned(),
        b: b.to_owned(),
        reason: "a joint connects them".to_owned(),
    };
    names.windows(2).map(|pair| (pair[0], pair[1])).chain(fingers).map(allowed).collect()
}

fn assembled(name: &str, text: &str, settings: &RobotSettings) -> RobotModel {
    let document = urdf::parse(text).expect("the asset is a URDF");
    RobotModel::assemble(name, &document, settings, &mut |mesh| Err(mesh.to_owned()))
        .expect("settings and asset fit each other")
}

/// Six joints, two thirds of them revolute, about and along random axes, with a random solid or two on every link.
fn chain(draw: &mut Draw) -> RobotModel {
    let mut joints: Vec<Joint> = Vec::new();
    let mut links = Vec::new();
    for index in 0..6 {
        let kind = if draw.between(0.0, 1.0) < 0.67 { JointKind::Revolute } else { JointKind::Prismatic };
        let step = direction(draw) * draw.between(0.05, 0.25);
        let parent_from_joint = Isometry3::from_parts(step.into(), rotation(draw));
        let mut joint = fixtures::joint(&format!("joint_{index}"), kind, parent_from_joint, direction(draw));
        joint.limits = JointLimits { velocity: 4.0, acceleration: 60.0, jerk: 5e3, ..joint.limits };
        joint.rotor_inertia = draw.between(0.0, 0.2);
        joint.damping = draw.between(0.0, 1.0);
        joint.friction = draw.between(0.0, 1.0);
        let count = if draw.between(0.0, 1.0) < 0.3 { 2 } else { 1 };
        let shapes = (0..count).map(|_| {
            let place =
                Isometry3::from_parts((direction(draw) * draw.between(0.0, 0.08)).into(), rotation(draw));
            (place, solid(draw, 0.015, 0.06))
        });
        let mut link = fixtures::link(&format!("link_{index}"), shapes.collect());
        let PlacedShape { body_from_shape, shape } = &link.shapes[0];
        link.inertial = shape.inertial(draw.between(0.5, 5.0)).transformed(body_from_shape);
        joints.push(joint);
        links.push(link);
    }
    let mut robot = fixtures::robot(joints, links);
    robot.world_from_base =
        Isometry3::from_parts((direction(draw) * draw.between(0.0, 0.5)).into(), rotation(draw));
    robot.base.shapes =
        vec![PlacedShape { body_from_shape: Pose::identity(), shape: solid(draw, 0.03, 0.08) }];
    for finger in &mut robot.gripper.fingers {
        finger.link.inertial = finger.link.shapes[0].shape.inertial(0.1);
    }
    robot
}

/// A random box, capsule, cylinder, ball or hull with half lengths in a range, m. One in six is thin as a sheet.
pub fn solid(draw: &mut Draw, least: f64, most: f64) -> Shape {
    let kind = draw.between(0.0, 5.0);
    let thin = draw.between(0.0, 6.0) < 1.0;
    let mut half = || draw.between(least, most);
    let smallest = |half: f64| if thin { 0.05 * half } else { half };
    if kind < 1.5 {
        Shape::Box { half_extents: Vector3::new(half(), smallest(half()), half()) }
    } else if kind < 2.5 {
        Shape::Capsule { radius: smallest(0.5 * half()), half_length: half() }
    } else if kind < 3.5 {
        Shape::Cylinder { radius: half(), half_length: smallest(half()) }
    } else if kind < 4.0 {
        Shape::Sphere { radius: half() }
    } else {
        let size = half();
        let points = (0..9).map(|_| Point3::from(direction(draw) * size)).collect();
        Shape::Hull { points }
    }
}

pub fn direction(draw: &mut Draw) -> Vector3<f64> {
    let z = draw.between(-1.0, 1.0);
    let turn = draw.between(-PI, PI);
    let across = (1.0 - z * z).sqrt();
    Vector3::new(across * turn.cos(), across * turn.sin(), z)
}

pub fn rotation(draw: &mut Draw) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Unit::new_normalize(direction(draw)), draw.between(-PI, PI))
}
