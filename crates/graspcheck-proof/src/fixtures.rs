//! Small robots, cells and plans made by code, for tests and benches.

use graspcheck_model::{
    Pose,
    cell::{Cell, CellBody, ClearanceRule},
    inertia::Inertial,
    plan::{Holding, Phase, Plan},
    robot::{AllowedContact, Family, Finger, Gripper, Joint, JointKind, JointLimits, Link, RobotModel},
    shape::{PlacedShape, Shape},
};
use graspcheck_motion::{Polynomial, Trajectory};
use nalgebra::{Isometry3, Matrix3, Point3, Translation3, Unit, UnitQuaternion, Vector3};

pub(crate) fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::translation(x, y, z)
}

pub(crate) fn boxed(x: f64, y: f64, z: f64) -> Shape {
    Shape::Box { half_extents: Vector3::new(x, y, z) }
}

pub(crate) fn joint(name: &str, kind: JointKind, parent_from_joint: Pose, axis: Vector3<f64>) -> Joint {
    let limits = JointLimits {
        position_min: -10.0,
        position_max: 10.0,
        velocity: 10.0,
        acceleration: 100.0,
        jerk: 1e4,
        effort: 100.0,
    };
    let axis = Unit::new_normalize(axis);
    let name = name.to_owned();
    Joint { name, kind, parent_from_joint, axis, limits, damping: 0.0, friction: 0.0, rotor_inertia: 0.0 }
}

pub(crate) fn link(name: &str, shapes: Vec<(Pose, Shape)>) -> Link {
    let inertial = Inertial { mass: 1.0, center: Point3::origin(), tensor: Matrix3::identity() };
    let place = |(body_from_shape, shape)| PlacedShape { body_from_shape, shape };
    Link { name: name.to_owned(), inertial, shapes: shapes.into_iter().map(place).collect() }
}

/// An arm at the world's origin whose gripper points along -z of the last link. Its fingers, 10 mm thick,
/// 20 mm wide and 40 mm long, close along y, and their tips are 30 mm below the tool frame. Neighbours may
/// touch.
pub(crate) fn robot(joints: Vec<Joint>, links: Vec<Link>) -> RobotModel {
    let link_from_tool = Isometry3::from_parts(
        Translation3::new(0.0, 0.0, -0.06),
        UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2),
    );
    let finger = |name: &str, side: f64| Finger {
        link: link(name, vec![(at(0.0, 0.005 * side, -0.01), boxed(0.01, 0.005, 0.02))]),
        joint: format!("{name}_slide"),
        link_from_finger: at(0.0, 0.0, -0.06),
        axis: Unit::new_normalize(Vector3::new(0.0, side, 0.0)),
    };
    let fingers = ["finger_left", "finger_right"];
    let names: Vec<&str> = links.iter().map(|link| link.name.as_str()).collect();
    let mut allowed_contacts: Vec<AllowedContact> = Vec::new();
    let mut allow = |a: &str, b: &str, reason: &str| {
        allowed_contacts.push(AllowedContact { a: a.to_owned(), b: b.to_owned(), reason: reason.to_owned() });
    };
    allow("base", names[0], "the first bearing");
    for pair in names.windows(2) {
        allow(pair[0], pair[1], "a bearing");
    }
    for finger in fingers {
        allow(names[names.len() - 1], finger, "the finger slides along the palm");
    }
    allow(fingers[0], fingers[1], "the pads meet");
    RobotModel {
        name: "fixture".to_owned(),
        family: Family::General,
        world_from_base: Pose::identity(),
        base: link("base", vec![]),
        joints,
        links,
        link_from_tool,
        gripper: Gripper {
            fingers: [finger(fingers[0], 1.0), finger(fingers[1], -1.0)],
            opening_max: 0.1,
            free_opening: 0.005,
            force_max: 50.0,
            finger_speed: 0.1,
        },
        allowed_contacts,
    }
}

/// A SCARA arm R-R-P-R of 0.325 m and 0.275 m, its shoulder 0.4 m high.
pub(crate) fn scara() -> RobotModel {
    use JointKind::{Prismatic, Revolute};
    let z = Vector3::z();
    robot(
        vec![
            joint("shoulder", Revolute, at(0.0, 0.0, 0.4), z),
            joint("elbow", Revolute, at(0.325, 0.0, 0.0), z),
            joint("quill", Prismatic, at(0.275, 0.0, 0.0), z),
            joint("wrist", Revolute, Pose::identity(), z),
        ],
        vec![
            link("upper_arm", vec![(at(0.1625, 0.0, 0.0), boxed(0.2, 0.06, 0.05))]),
            link("forearm", vec![(at(0.1375, 0.0, 0.09), boxed(0.18, 0.05, 0.04))]),
            link("quill_rod", vec![(Pose::identity(), Shape::Cylinder { radius: 0.012, half_length: 0.2 })]),
            link("hand", vec![(at(0.0, 0.0, -0.2), boxed(0.03, 0.05, 0.02))]),
        ],
    )
}

/// An arm of six revolute joints with a shoulder, an elbow and a wrist whose axes are a few degrees off square, so
/// that no two are parallel.
pub(crate) fn six_axes() -> RobotModel {
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let axes = [z, y + z * 0.03, y - x * 0.02, x + z * 0.04, y + x * 0.03, x - y * 0.02];
    let origins = [
        at(0.0, 0.0, 0.3),
        at(0.05, 0.0, 0.1),
        at(0.0, 0.02, 0.4),
        at(0.1, 0.0, 0.05),
        at(0.3, 0.0, 0.0),
        at(0.08, 0.0, 0.01),
    ];
    let names = ["waist", "shoulder", "elbow", "roll", "bend", "twist"];
    let links = ["column", "upper_arm", "forearm", "wrist", "cuff", "hand"];
    let joints = names.into_iter().zip(origins).zip(axes);
    let joints =
        joints.map(|((name, origin), axis)| joint(name, JointKind::Revolute, origin, axis)).collect();
    let mut robot = robot(joints, links.into_iter().map(|name| link(name, vec![])).collect());
    for (k, link) in robot.links.iter_mut().enumerate() {
        let mass = 8.0 / (k + 1) as f64;
        link.inertial.mass = mass;
        link.inertial.center = [0.08, 0.01, 0.05].into();
        link.inertial.tensor = Matrix3::from_diagonal(&Vector3::new(0.01, 0.012, 0.008)) * mass;
    }
    robot
}

pub(crate) fn cell(required: f64, bodies: Vec<(&str, Shape, Pose)>) -> Cell {
    let body = |(name, shape, world_from_shape): (&str, Shape, Pose)| CellBody {
        name: name.to_owned(),
        shape,
        world_from_shape,
    };
    Cell {
        gravity: Vector3::new(0.0, 0.0, -9.81),
        bodies: bodies.into_iter().map(body).collect(),
        clearance: ClearanceRule { required, pairs: vec![] },
    }
}

/// A quintic from rest to rest in one phase, with the gripper at a constant opening and no object.
pub(crate) fn rest_to_rest(from: &[f64], to: &[f64], duration: f64) -> Plan {
    let pieces = from
        .iter()
        .zip(to)
        .map(|(&a, &b)| Polynomial::quintic_hermite([a, 0.0, 0.0], [b, 0.0, 0.0], duration))
        .collect();
    let trajectory =
        Trajectory::new(from.len(), vec![0.0, duration], pieces).expect("the knots and pieces fit");
    let opening = Trajectory::hold(&[0.05], duration).expect("the duration is positive");
    let phase = Phase { name: "move".to_owned(), start: 0.0, end: duration, holding: Holding::Nothing };
    Plan { trajectory, opening, phases: vec![phase], grasp: None, paths: Vec::new() }
}

/// A generator of numbers that look random (SplitMix64, Steele, Lea and Flood 2014).
pub(crate) struct Draw(pub(crate) u64);

impl Draw {
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        low + (high - low) * ((z >> 11) as f64 / (1_u64 << 53) as f64)
    }
}
