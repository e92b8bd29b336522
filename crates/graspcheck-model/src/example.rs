//! Two small arms built in code, for examples and first steps: numbers that one can check by hand.
//!
//! Real arms come from a URDF and a `robot.toml`; see [`assemble`](crate::assemble).

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use crate::{
    Pose,
    inertia::Inertial,
    robot::{Family, Finger, Gripper, Joint, JointKind, JointLimits, Link, RobotModel},
    shape::Shape,
    structure::PlanarGeometry,
};

/// The SCARA R-R-P-R with links of 0.25 m and 0.20 m, limits ±85°, ±120°, −330 … 5 mm, −20° … 1080°; masses of
/// 8, 5, 1 and 0.5 kg in the middle of the links. The tool points down, 0.1 m below the end of the quill.
///
/// ```
/// let robot = graspcheck_model::example::scara();
/// let tool = robot.world_from_tool(&[0.0, 0.0, 0.0, 0.0]);
/// assert!((tool.translation.vector.x - 0.45).abs() < 1e-15); // stretched along x
/// ```
#[must_use]
pub fn scara() -> RobotModel {
    use JointKind::{Prismatic, Revolute};
    let joints = vec![
        joint("shoulder", Revolute, [0.0, 0.0, 0.4], [-85.0_f64, 85.0].map(f64::to_radians)),
        joint("elbow", Revolute, [0.25, 0.0, 0.0], [-120.0_f64, 120.0].map(f64::to_radians)),
        joint("quill", Prismatic, [0.2, 0.0, 0.0], [-0.33, 0.005]),
        joint("wrist", Revolute, [0.0, 0.0, 0.0], [-20.0_f64, 1080.0].map(f64::to_radians)),
    ];
    let masses = [(8.0, 0.125), (5.0, 0.1), (1.0, 0.0), (0.5, 0.0)];
    let down = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
    arm("scara", joints, &masses, Pose::from_parts(Translation3::new(0.0, 0.0, -0.1), down))
}

/// The planar R-R-R of the textbooks: links of 4, 3 and 1 m and 20, 15 and 3 kg, limits ±270°, ±170°, ±180°.
///
/// ```
/// let robot = graspcheck_model::example::planar();
/// let tool = robot.world_from_tool(&[0.0, 0.0, 0.0]);
/// assert!((tool.translation.vector.x - 8.0).abs() < 1e-15);
/// ```
#[must_use]
pub fn planar() -> RobotModel {
    let symmetric = |degrees: f64| [-degrees.to_radians(), degrees.to_radians()];
    let joints = vec![
        joint("shoulder", JointKind::Revolute, [0.0; 3], symmetric(270.0)),
        joint("elbow", JointKind::Revolute, [4.0, 0.0, 0.0], symmetric(170.0)),
        joint("wrist", JointKind::Revolute, [3.0, 0.0, 0.0], symmetric(180.0)),
    ];
    let masses = [(20.0, 2.0), (15.0, 1.5), (3.0, 0.5)];
    arm("planar", joints, &masses, Translation3::new(1.0, 0.0, 0.0).into())
}

/// A joint along z at `xyz` (m) in the frame of the link before it.
fn joint(name: &str, kind: JointKind, xyz: [f64; 3], [position_min, position_max]: [f64; 2]) -> Joint {
    Joint {
        name: name.to_owned(),
        kind,
        parent_from_joint: Isometry3::from_parts(Vector3::from(xyz).into(), UnitQuaternion::identity()),
        axis: Vector3::z_axis(),
        limits: JointLimits {
            position_min,
            position_max,
            velocity: 2.0,
            acceleration: 10.0,
            jerk: 100.0,
            effort: 100.0,
        },
        damping: 0.0,
        friction: 0.0,
        rotor_inertia: 0.0,
    }
}

/// An arm of links that are balls of 0.1 m with a mass (kg) at a distance along their x (m), and a gripper without
/// weight.
fn arm(name: &str, joints: Vec<Joint>, masses: &[(f64, f64)], link_from_tool: Pose) -> RobotModel {
    let link = |name: &str, inertial| Link { name: name.to_owned(), inertial, shapes: Vec::new() };
    let ball = |&(mass, x): &(f64, f64)| Inertial {
        center: Point3::new(x, 0.0, 0.0),
        ..Shape::Sphere { radius: 0.1 }.inertial(mass)
    };
    let finger = |name: &str, side: f64| Finger {
        link: link(name, Inertial::massless()),
        joint: format!("{name}_slide"),
        link_from_finger: link_from_tool,
        axis: nalgebra::Unit::new_normalize(Vector3::new(0.0, side, 0.0)),
    };
    let mut robot = RobotModel {
        name: name.to_owned(),
        family: Family::General,
        world_from_base: Pose::identity(),
        base: link("base", Inertial::massless()),
        links: joints.iter().zip(masses).map(|(joint, mass)| link(&joint.name, ball(mass))).collect(),
        joints,
        link_from_tool,
        gripper: Gripper {
            fingers: [finger("finger_left", 1.0), finger("finger_right", -1.0)],
            opening_max: 0.08,
            free_opening: 0.01,
            force_max: 50.0,
            finger_speed: 0.1,
        },
        allowed_contacts: Vec::new(),
    };
    if let Ok(geometry) = PlanarGeometry::of(&robot) {
        robot.family = geometry.family();
    }
    robot
}
