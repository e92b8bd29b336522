//! Arms for tests and benches, built in code.

#![allow(dead_code, reason = "each test file uses some of these arms")]

use std::f64::consts::{FRAC_PI_2, PI};

use graspcheck_model::{
    Pose,
    inertia::Inertial,
    robot::{Family, Finger, Gripper, Joint, JointKind, JointLimits, Link, RobotModel},
    settings::{GripperSettings, JointSettings, RobotSettings, ToolSettings},
    shape::Shape,
    structure::PlanarGeometry,
    urdf,
};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

/// A pose from a position (m) and roll, pitch, yaw (rad).
pub(crate) fn pose(xyz: [f64; 3], rpy: [f64; 3]) -> Pose {
    Isometry3::from_parts(
        Translation3::from(Vector3::from(xyz)),
        UnitQuaternion::from_euler_angles(rpy[0], rpy[1], rpy[2]),
    )
}

/// A joint along z with position limits and nothing else that matters to kinematics.
pub(crate) fn joint(name: &str, kind: JointKind, parent_from_joint: Pose, limits: [f64; 2]) -> Joint {
    Joint {
        name: name.to_owned(),
        kind,
        parent_from_joint,
        axis: Vector3::z_axis(),
        limits: JointLimits {
            position_min: limits[0],
            position_max: limits[1],
            velocity: 1.0,
            acceleration: 1.0,
            jerk: 1.0,
            effort: 1.0,
        },
        damping: 0.0,
        friction: 0.0,
        rotor_inertia: 0.0,
    }
}

/// A link without shapes.
pub(crate) fn link(name: &str, inertial: Inertial) -> Link {
    Link { name: name.to_owned(), inertial, shapes: Vec::new() }
}

/// A point mass: the tensor is zero.
pub(crate) fn point_mass(mass: f64, at: [f64; 3]) -> Inertial {
    Inertial { center: Point3::from(at), ..Shape::Sphere { radius: 0.0 }.inertial(mass) }
}

/// A solid box of this mass with its centre at `at`, turned by roll, pitch, yaw.
pub(crate) fn solid(mass: f64, size: [f64; 3], at: [f64; 3], rpy: [f64; 3]) -> Inertial {
    Shape::Box { half_extents: Vector3::from(size) / 2.0 }.inertial(mass).transformed(&pose(at, rpy))
}

/// An arm of these joints and links, with weightless fingers along the tool's y.
pub(crate) fn arm(joints: Vec<Joint>, inertials: Vec<Inertial>, link_from_tool: Pose) -> RobotModel {
    let finger = |name: &str, side: f64| Finger {
        link: link(name, Inertial::massless()),
        joint: format!("{name}_slide"),
        link_from_finger: link_from_tool,
        axis: nalgebra::Unit::new_normalize(Vector3::new(0.0, side, 0.0)),
    };
    let mut robot = RobotModel {
        name: "arm".to_owned(),
        family: Family::General,
        world_from_base: Pose::identity(),
        base: link("base", Inertial::massless()),
        links: joints.iter().zip(inertials).map(|(joint, inertial)| link(&joint.name, inertial)).collect(),
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

/// Rotates the tool so that its x axis points down (−z) and its y axis stays where it is.
pub(crate) const DOWN: [f64; 3] = [0.0, FRAC_PI_2, 0.0];

/// The SCARA of the worked examples: 0.25 m + 0.20 m, ±85°, ±120°, −330 … 5 mm, −20° … 1080°.
pub(crate) fn scara() -> RobotModel {
    use JointKind::{Prismatic, Revolute};
    let degrees = |low: f64, high: f64| [low.to_radians(), high.to_radians()];
    let mut joints = vec![
        joint("shoulder", Revolute, pose([0.0, 0.0, 0.4], [0.0; 3]), degrees(-85.0, 85.0)),
        joint("elbow", Revolute, pose([0.25, 0.0, 0.05], [0.0; 3]), degrees(-120.0, 120.0)),
        joint("quill", Prismatic, pose([0.2, 0.0, 0.0], [0.0; 3]), [-0.33, 0.005]),
        joint("wrist", Revolute, pose([0.0; 3], [0.0; 3]), degrees(-20.0, 1080.0)),
    ];
    joints[3].rotor_inertia = 1e-3;
    let inertials = vec![
        solid(8.0, [0.3, 0.1, 0.08], [0.12, 0.01, 0.0], [0.1, 0.0, 0.2]),
        solid(5.0, [0.25, 0.08, 0.1], [0.1, 0.0, 0.02], [0.0, 0.1, 0.0]),
        solid(1.5, [0.03, 0.03, 0.4], [0.0, 0.0, 0.1], [0.0; 3]),
        solid(0.5, [0.05, 0.09, 0.04], [0.0, 0.005, -0.03], [0.3, 0.2, 0.1]),
    ];
    arm(joints, inertials, pose([0.0, 0.0, -0.1], DOWN))
}

/// A SCARA with every freedom that a URDF leaves: a base that stands askew in the world, joint frames
/// turned about z, an elbow that is bent at zero, a tool beside the last axis.
pub(crate) fn askew_scara() -> RobotModel {
    let mut robot = scara();
    robot.world_from_base = pose([0.3, -0.7, 0.2], [0.4, -1.1, 2.0]);
    robot.joints[0].parent_from_joint = pose([0.02, -0.03, 0.4], [0.0, 0.0, 0.6]);
    robot.joints[1].parent_from_joint = pose([0.15, 0.2, 0.05], [0.0, 0.0, -1.3]);
    robot.joints[2].parent_from_joint = pose([-0.1, 0.16, 0.0], [0.0, 0.0, 2.2]);
    robot.joints[3].parent_from_joint = pose([0.01, 0.02, 0.03], [0.0, 0.0, -0.4]);
    robot.link_from_tool = pose([0.03, -0.05, -0.1], [0.3, 1.2, -0.8]);
    robot
}

/// The planar R-R-R of the worked examples: 4, 3, 1 m, 20, 15, 3 kg, ±270°, ±170°, ±180°.
pub(crate) fn rrr() -> RobotModel {
    use JointKind::Revolute;
    let symmetric = |angle: f64| [-angle, angle];
    let joints = vec![
        joint("shoulder", Revolute, pose([0.0; 3], [0.0; 3]), symmetric(1.5 * PI)),
        joint("elbow", Revolute, pose([4.0, 0.0, 0.0], [0.0; 3]), symmetric(170.0_f64.to_radians())),
        joint("wrist", Revolute, pose([3.0, 0.0, 0.0], [0.0; 3]), symmetric(PI)),
    ];
    let inertials = vec![
        solid(20.0, [4.0, 0.2, 0.2], [2.0, 0.0, 0.0], [0.0; 3]),
        solid(15.0, [3.0, 0.2, 0.2], [1.5, 0.0, 0.0], [0.0; 3]),
        solid(3.0, [1.0, 0.2, 0.2], [0.5, 0.0, 0.0], [0.0; 3]),
    ];
    arm(joints, inertials, pose([1.0, 0.0, 0.0], [0.0; 3]))
}

/// An R-R-R with the base's plane vertical in the world, turned joint frames and a bent hand.
pub(crate) fn askew_rrr() -> RobotModel {
    let mut robot = rrr();
    robot.world_from_base = pose([1.0, 2.0, 3.0], [FRAC_PI_2, 0.0, 0.7]);
    robot.joints[0].parent_from_joint = pose([0.1, 0.2, 0.3], [0.0, 0.0, -0.5]);
    robot.joints[1].parent_from_joint = pose([2.4, -3.2, 0.1], [0.0, 0.0, 1.1]);
    robot.joints[2].parent_from_joint = pose([0.0, 3.0, -0.1], [0.0, 0.0, 0.3]);
    robot.link_from_tool = pose([0.8, 0.6, 0.05], [0.2, 0.0, 0.4]);
    robot
}

/// An arm in space with tilted axes of both kinds, where gyroscopic terms do not vanish.
pub(crate) fn spatial() -> RobotModel {
    use JointKind::{Prismatic, Revolute};
    let mut joints = vec![
        joint("a", Revolute, pose([0.1, 0.2, 0.3], [0.3, -0.4, 0.5]), [-PI, PI]),
        joint("b", Revolute, pose([0.5, -0.1, 0.2], [1.2, 0.3, -0.6]), [-PI, PI]),
        joint("c", Prismatic, pose([0.2, 0.3, -0.1], [-0.7, 0.9, 0.2]), [-1.0, 1.0]),
        joint("d", Revolute, pose([0.1, 0.4, 0.1], [0.5, 1.3, -1.0]), [-PI, PI]),
    ];
    joints[0].axis = nalgebra::Unit::new_normalize(Vector3::new(1.0, 2.0, -0.5));
    joints[2].axis = nalgebra::Unit::new_normalize(Vector3::new(-0.3, 0.4, 1.0));
    joints[3].rotor_inertia = 0.07;
    let inertials = vec![
        solid(4.0, [0.3, 0.5, 0.2], [0.2, -0.1, 0.15], [0.2, 0.4, -0.3]),
        solid(3.0, [0.2, 0.3, 0.6], [-0.1, 0.2, 0.1], [0.7, -0.2, 0.1]),
        solid(2.0, [0.5, 0.1, 0.2], [0.1, 0.1, -0.2], [0.0, 0.5, 0.9]),
        solid(1.0, [0.2, 0.4, 0.1], [0.0, 0.3, 0.1], [0.4, 0.4, 0.4]),
    ];
    let mut robot = arm(joints, inertials, pose([0.1, -0.2, 0.3], [0.1, 0.2, 0.3]));
    robot.world_from_base = pose([0.5, 0.6, 0.7], [0.9, -0.3, 0.2]);
    robot
}

/// The arm of six revolute joints in `six.urdf`, read as any robot is. Its wrist axes do not meet.
pub(crate) fn six() -> RobotModel {
    let joint = |name: &str| JointSettings {
        name: name.to_owned(),
        acceleration: 10.0,
        jerk: 100.0,
        rotor_inertia: 0.0,
    };
    let settings = RobotSettings {
        world_from_base: pose([0.1, -0.2, 0.3], [0.0, 0.0, 0.4]),
        joints: ["j1", "j2", "j3", "j4", "j5", "j6"].map(joint).to_vec(),
        tool: ToolSettings {
            link: "hand".to_owned(),
            link_from_tool: pose([0.0, 0.0, 0.12], [0.0, -FRAC_PI_2, 0.0]),
        },
        gripper: GripperSettings {
            fingers: ["finger_left_slide".to_owned(), "finger_right_slide".to_owned()],
            opening_max: 0.08,
            free_opening: 0.005,
            force_max: 40.0,
            finger_speed: 0.05,
        },
        allowed_contacts: Vec::new(),
    };
    let document = urdf::parse(include_str!("six.urdf")).expect("a good text");
    RobotModel::assemble("six", &document, &settings, &mut |_| Err("it has no meshes".to_owned()))
        .expect("a good robot")
}
