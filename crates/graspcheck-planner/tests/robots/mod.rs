//! A SCARA and a planar R-R-R with the lengths and limits of the worked examples, in simple cells, built in
//! code for tests and benches.

#![allow(dead_code, reason = "each test file uses some of these")]
#![allow(unreachable_pub, reason = "shared between test crates, none of which is a library")]

use std::f64::consts::{FRAC_PI_2, PI};

use graspcheck_model::{
    Pose,
    cell::{Cell, CellBody, ClearanceRule},
    inertia::Inertial,
    object::{Handle, Object},
    robot::{AllowedContact, Family, Finger, Gripper, Joint, JointKind, JointLimits, Link, RobotModel},
    shape::{PlacedShape, Shape},
    task::{Pace, PickAndPlace},
};
use nalgebra::{Isometry3, Matrix3, Point3, Translation3, Unit, UnitQuaternion, Vector3};

/// A pose from a position (m) and roll, pitch, yaw (rad).
pub fn pose(xyz: [f64; 3], rpy: [f64; 3]) -> Pose {
    Isometry3::from_parts(
        Translation3::from(Vector3::from(xyz)),
        UnitQuaternion::from_euler_angles(rpy[0], rpy[1], rpy[2]),
    )
}

fn at(xyz: [f64; 3]) -> Pose {
    pose(xyz, [0.0; 3])
}

fn boxed(size: [f64; 3]) -> Shape {
    Shape::Box { half_extents: Vector3::from(size) / 2.0 }
}

fn link(name: &str, shapes: Vec<(Pose, Shape)>) -> Link {
    let inertial = Inertial { mass: 1.0, center: Point3::origin(), tensor: Matrix3::identity() };
    let place = |(body_from_shape, shape)| PlacedShape { body_from_shape, shape };
    Link { name: name.to_owned(), inertial, shapes: shapes.into_iter().map(place).collect() }
}

/// Position limits, then largest velocity, acceleration and jerk.
fn joint(name: &str, kind: JointKind, from_parent: [f64; 3], range: [f64; 2], dynamic: [f64; 3]) -> Joint {
    let limits = JointLimits {
        position_min: range[0],
        position_max: range[1],
        velocity: dynamic[0],
        acceleration: dynamic[1],
        jerk: dynamic[2],
        effort: 100.0,
    };
    Joint {
        name: name.to_owned(),
        kind,
        parent_from_joint: at(from_parent),
        axis: Vector3::z_axis(),
        limits,
        damping: 0.0,
        friction: 0.0,
        rotor_inertia: 0.0,
    }
}

fn finger(name: &str, link_from_tool: Pose, side: f64, size: [f64; 3]) -> Finger {
    // The tip is 8 mm beyond the tool's origin.
    let pad_center = at([0.008 - 0.5 * size[0], 0.5 * side * size[1], 0.0]);
    Finger {
        link: link(name, vec![(pad_center, boxed(size))]),
        joint: format!("{name}_slide"),
        link_from_finger: link_from_tool,
        axis: Unit::new_normalize(Vector3::new(0.0, side, 0.0)),
    }
}

fn neighbours(names: &[&str]) -> Vec<AllowedContact> {
    let pair = |a: &str, b: &str| AllowedContact {
        a: a.to_owned(),
        b: b.to_owned(),
        reason: "a joint connects them".to_owned(),
    };
    let mut all: Vec<AllowedContact> = names.windows(2).map(|two| pair(two[0], two[1])).collect();
    let hand = names[names.len() - 1];
    all.extend([pair(hand, "finger_left"), pair(hand, "finger_right"), pair("finger_left", "finger_right")]);
    all
}

/// R-R-P-R, 0.25 m + 0.20 m; the tool's middle is 0.34 m high at quill 0 and points down.
pub fn scara() -> RobotModel {
    use JointKind::{Prismatic, Revolute};
    let degrees = |low: f64, high: f64| [low.to_radians(), high.to_radians()];
    let link_from_tool = pose([0.0, 0.0, -0.1], [0.0, FRAC_PI_2, 0.0]);
    let pad = [0.048, 0.01, 0.024];
    RobotModel {
        name: "scara".to_owned(),
        family: Family::Scara { upper: 0.25, fore: 0.2 },
        world_from_base: Pose::identity(),
        base: link("base", vec![(at([0.0, 0.0, 0.22]), boxed([0.1, 0.1, 0.44]))]),
        joints: vec![
            joint("shoulder", Revolute, [0.0, 0.0, 0.44], degrees(-85.0, 85.0), [7.5, 60.0, 3000.0]),
            joint("elbow", Revolute, [0.25, 0.0, 0.07], degrees(-120.0, 120.0), [10.0, 100.0, 5000.0]),
            joint("quill", Prismatic, [0.2, 0.0, -0.07], [-0.33, 0.005], [1.0, 15.0, 1000.0]),
            joint("wrist", Revolute, [0.0; 3], degrees(-20.0, 1080.0), [20.0, 200.0, 15000.0]),
        ],
        links: vec![
            link("upper_arm", vec![(at([0.125, 0.0, 0.035]), boxed([0.33, 0.1, 0.06]))]),
            link("forearm", vec![(at([0.1, 0.0, 0.05]), boxed([0.27, 0.09, 0.08]))]),
            link(
                "quill",
                vec![(at([0.0, 0.0, 0.28]), Shape::Cylinder { radius: 0.0125, half_length: 0.28 })],
            ),
            link("hand", vec![(at([0.0, 0.0, -0.045]), boxed([0.05, 0.13, 0.03]))]),
        ],
        link_from_tool,
        gripper: Gripper {
            fingers: [
                finger("finger_left", link_from_tool, 1.0, pad),
                finger("finger_right", link_from_tool, -1.0, pad),
            ],
            opening_max: 0.07,
            free_opening: 0.006,
            force_max: 20.0,
            finger_speed: 0.06,
        },
        allowed_contacts: neighbours(&["base", "upper_arm", "forearm", "quill", "hand"]),
    }
}

/// R-R-R, 4, 3 and 1 m, moving in the base's x-y plane; the tool points along link 3.
pub fn rrr() -> RobotModel {
    use JointKind::Revolute;
    let symmetric = |angle: f64| [-angle, angle];
    let link_from_tool = at([1.0, 0.0, 0.0]);
    let pad = [0.3, 0.04, 0.1];
    RobotModel {
        name: "rrr".to_owned(),
        family: Family::PlanarRrr { upper: 4.0, fore: 3.0, hand: 1.0 },
        world_from_base: Pose::identity(),
        base: link("base", vec![(at([0.0, 0.0, 0.55]), boxed([0.3, 0.3, 0.3]))]),
        joints: vec![
            joint("shoulder", Revolute, [0.0; 3], symmetric(1.5 * PI), [1.5, 2.5, 25.0]),
            joint("elbow", Revolute, [4.0, 0.0, 0.0], symmetric(170.0_f64.to_radians()), [1.5, 2.5, 25.0]),
            joint("wrist", Revolute, [3.0, 0.0, 0.0], symmetric(PI), [2.5, 4.0, 40.0]),
        ],
        links: vec![
            link("upper_arm", vec![(at([2.0, 0.0, 0.6]), boxed([4.2, 0.2, 0.2]))]),
            link("forearm", vec![(at([1.5, 0.0, 0.3]), boxed([3.2, 0.2, 0.2]))]),
            link("hand", vec![(at([0.35, 0.0, 0.0]), boxed([0.7, 0.2, 0.2]))]),
        ],
        link_from_tool,
        gripper: Gripper {
            fingers: [
                finger("finger_left", link_from_tool, 1.0, pad),
                finger("finger_right", link_from_tool, -1.0, pad),
            ],
            opening_max: 0.36,
            free_opening: 0.04,
            force_max: 100.0,
            finger_speed: 0.15,
        },
        allowed_contacts: neighbours(&["base", "upper_arm", "forearm", "hand"]),
    }
}

/// A cell of boxes: name, size and place.
pub fn cell(required: f64, boxes: &[(&str, [f64; 3], [f64; 3])]) -> Cell {
    let body = |(name, size, place): &(&str, [f64; 3], [f64; 3])| CellBody {
        name: (*name).to_owned(),
        shape: boxed(*size),
        world_from_shape: at(*place),
    };
    Cell {
        gravity: Vector3::new(0.0, 0.0, -9.81),
        bodies: boxes.iter().map(body).collect(),
        clearance: ClearanceRule { required, pairs: vec![] },
    }
}

/// Share of the limits for all phases.
pub fn pace(share: f64) -> Pace {
    Pace { share, law: Default::default(), sync: Default::default(), phases: vec![], set_points: None }
}

/// A cube of 30 mm with handles from above across both of its sides.
pub fn cube(place: [f64; 3], yaw: f64) -> Object {
    let handle = |name: &str, turn: f64| Handle {
        name: name.to_owned(),
        object_from_handle: pose([0.0; 3], [0.0, 0.0, turn]) * pose([0.0; 3], [0.0, FRAC_PI_2, 0.0]),
        width: 0.03,
        half_turn: true,
    };
    Object {
        name: "cube".to_owned(),
        shape: boxed([0.03; 3]),
        mass: 0.1,
        friction: 0.6,
        world_from_object: pose(place, [0.0, 0.0, yaw]),
        handles: vec![handle("side y", 0.0), handle("side x", FRAC_PI_2)],
    }
}

/// The bench, and the wall across it, 150 mm high.
pub fn bench_with_wall() -> Cell {
    cell(
        0.002,
        &[("bench", [0.6, 0.7, 0.02], [0.22, 0.0, -0.01]), ("wall", [0.24, 0.02, 0.15], [0.3, 0.0, 0.075])],
    )
}

/// A SCARA's pick of [`cube`] over the wall.
pub fn scara_pick() -> (Object, PickAndPlace) {
    let task = PickAndPlace {
        start: vec![-1.0, 1.7, -0.02, 5.5],
        world_from_placed: pose([0.33, 0.15, 0.015], [0.0, 0.0, -1.2]),
        pregrasp_distance: 0.06,
        departure: Vector3::new(0.0, 0.0, 0.18),
        arrival: Vector3::new(0.0, 0.0, 0.18),
        retreat_distance: 0.06,
        grip_force: 12.0,
        close_duration: 0.3,
        open_duration: 0.3,
    };
    (cube([0.28, -0.18, 0.015], 0.35), task)
}

/// A block of 200 mm that the R-R-R grasps along the direction `approach` (rad, in the plane), carries and
/// puts down elsewhere.
pub fn rrr_pick(approach: f64) -> (Object, PickAndPlace) {
    let object = Object {
        name: "block".to_owned(),
        shape: boxed([0.2; 3]),
        mass: 2.0,
        friction: 0.6,
        world_from_object: pose([3.0, 3.5, 0.0], [0.0, 0.0, approach]),
        handles: vec![Handle {
            name: "side".to_owned(),
            object_from_handle: Pose::identity(),
            width: 0.2,
            half_turn: true,
        }],
    };
    let task = PickAndPlace {
        start: vec![0.3, 1.2, 0.0],
        world_from_placed: pose([4.2, -2.5, 0.0], [0.0, 0.0, -0.6]),
        pregrasp_distance: 0.5,
        departure: Vector3::new(-0.3, -0.2, 0.0),
        arrival: Vector3::new(-0.4, 0.0, 0.0),
        retreat_distance: 0.5,
        grip_force: 60.0,
        close_duration: 0.8,
        open_duration: 0.8,
    };
    (object, task)
}
