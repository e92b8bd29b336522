//! Robots, cells, objects and plans of the tests, built in code.

use graspcheck_model::{
    Pose,
    cell::{Cell, CellBody, ClearanceRule},
    execution::{ContactModel, Controller, Execution},
    inertia::Inertial,
    object::Object,
    plan::{Grasp, Holding, Phase, Plan},
    robot::{AllowedContact, Family, Finger, Gripper, Joint, JointKind, JointLimits, Link, RobotModel},
    shape::{PlacedShape, Shape},
};
use graspcheck_motion::{Polynomial, Trajectory};
use nalgebra::{Matrix3, Point3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};

pub(crate) const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// Edge of the cube, m.
pub(crate) const CUBE: f64 = 0.04;

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::translation(x, y, z)
}

/// A box of uniform density with this centre in the link's frame.
fn box_link(name: &str, mass: f64, center: [f64; 3], half_extents: [f64; 3]) -> Link {
    let shape = Shape::Box { half_extents: half_extents.into() };
    let body_from_shape = at(center[0], center[1], center[2]);
    Link {
        name: name.to_owned(),
        inertial: shape.inertial(mass).transformed(&body_from_shape),
        shapes: vec![PlacedShape { body_from_shape, shape }],
    }
}

fn joint(name: &str, kind: JointKind, parent_from_joint: Pose, limits: JointLimits) -> Joint {
    Joint {
        name: name.to_owned(),
        kind,
        parent_from_joint,
        axis: Vector3::z_axis(),
        limits,
        damping: 0.0,
        friction: 0.0,
        rotor_inertia: 0.0,
    }
}

fn limits(position: [f64; 2], velocity: f64, acceleration: f64, jerk: f64, effort: f64) -> JointLimits {
    JointLimits { position_min: position[0], position_max: position[1], velocity, acceleration, jerk, effort }
}

/// Two fingers whose pads meet at `link_from_tool`'s origin and close along its y axis.
fn gripper(link_from_tool: Pose, finger_mass: f64) -> Gripper {
    let finger = |name: &str, side: f64| Finger {
        // The pads reach 15 mm beyond the tool's origin (x points out) and 35 mm back from it.
        link: box_link(name, finger_mass, [-0.01, side * 0.005, 0.0], [0.025, 0.005, 0.012]),
        joint: format!("{name}_slide"),
        link_from_finger: link_from_tool,
        axis: Unit::new_normalize(Vector3::y() * side),
    };
    Gripper {
        fingers: [finger("finger_left", 1.0), finger("finger_right", -1.0)],
        opening_max: 0.08,
        free_opening: 0.01,
        force_max: 40.0,
        finger_speed: 0.05,
    }
}

/// The pairs that a joint connects, and the two fingers, each of which may touch.
fn connected(links: &[&str]) -> Vec<AllowedContact> {
    let contact = |a: &str, b: &str, reason: &str| AllowedContact {
        a: a.to_owned(),
        b: b.to_owned(),
        reason: reason.to_owned(),
    };
    let hand = links[links.len() - 1];
    let mut contacts: Vec<AllowedContact> =
        links.windows(2).map(|pair| contact(pair[0], pair[1], "a joint connects them")).collect();
    contacts.extend(["finger_left", "finger_right"].map(|finger| contact(hand, finger, "it slides along")));
    contacts.push(contact("finger_left", "finger_right", "the pads meet on nothing"));
    contacts
}

/// A SCARA of 0.25 m + 0.20 m, its axis 1 at 0.4 m height, its tool pointing down.
pub(crate) fn scara() -> RobotModel {
    let mut wrist = joint(
        "wrist",
        JointKind::Revolute,
        Pose::identity(),
        limits([-0.35, 18.8], 20.0, 200.0, 15_000.0, 3.0),
    );
    wrist.rotor_inertia = 2e-3;
    let down = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
    let link_from_tool = Pose::from_parts(Translation3::new(0.0, 0.0, -0.1), down);
    RobotModel {
        name: "scara".to_owned(),
        family: Family::Scara { upper: 0.25, fore: 0.2 },
        world_from_base: Pose::identity(),
        base: box_link("column", 20.0, [0.0, 0.0, 0.15], [0.06, 0.06, 0.15]),
        joints: vec![
            joint(
                "shoulder",
                JointKind::Revolute,
                at(0.0, 0.0, 0.4),
                limits([-1.48, 1.48], 7.5, 60.0, 3_000.0, 120.0),
            ),
            joint(
                "elbow",
                JointKind::Revolute,
                at(0.25, 0.0, 0.0),
                limits([-2.09, 2.09], 10.0, 100.0, 5_000.0, 40.0),
            ),
            joint(
                "quill",
                JointKind::Prismatic,
                at(0.2, 0.0, 0.0),
                limits([-0.33, 0.005], 1.0, 15.0, 1_000.0, 150.0),
            ),
            wrist,
        ],
        links: vec![
            box_link("upper_arm", 8.0, [0.125, 0.0, 0.0], [0.16, 0.05, 0.04]),
            box_link("forearm", 5.0, [0.1, 0.0, 0.05], [0.13, 0.04, 0.04]),
            box_link("spindle", 1.5, [0.0, 0.0, 0.1], [0.01, 0.01, 0.15]),
            box_link("hand", 0.5, [0.0, 0.0, -0.04], [0.03, 0.045, 0.01]),
        ],
        link_from_tool,
        gripper: gripper(link_from_tool, 0.05),
        allowed_contacts: connected(&["column", "upper_arm", "forearm", "spindle", "hand"]),
    }
}

/// A planar arm of 4 m, 3 m and 1 m.
pub(crate) fn rrr() -> RobotModel {
    let link_from_tool = at(1.0, 0.0, 0.0);
    RobotModel {
        name: "rrr".to_owned(),
        family: Family::PlanarRrr { upper: 4.0, fore: 3.0, hand: 1.0 },
        world_from_base: Pose::identity(),
        base: box_link("pillar", 100.0, [0.0, 0.0, -0.5], [0.3, 0.3, 0.4]),
        joints: vec![
            joint("j1", JointKind::Revolute, at(0.0, 0.0, 0.0), limits([-4.7, 4.7], 1.5, 2.5, 25.0, 3_500.0)),
            joint("j2", JointKind::Revolute, at(4.0, 0.0, 0.0), limits([-2.9, 2.9], 1.5, 2.5, 25.0, 1_000.0)),
            joint("j3", JointKind::Revolute, at(3.0, 0.0, 0.0), limits([-3.1, 3.1], 2.5, 4.0, 40.0, 80.0)),
        ],
        links: vec![
            box_link("link1", 20.0, [2.0, 0.0, 0.0], [2.0, 0.05, 0.05]),
            box_link("link2", 15.0, [1.5, 0.0, 0.0], [1.5, 0.04, 0.04]),
            box_link("link3", 3.0, [0.4, 0.0, 0.0], [0.4, 0.03, 0.03]),
        ],
        link_from_tool,
        gripper: gripper(link_from_tool, 0.05),
        allowed_contacts: connected(&["pillar", "link1", "link2", "link3"]),
    }
}

/// An arm with tilted axes, a turned base, off-centre rotated inertias, damping and rotors: nothing in it
/// is parallel to anything.
pub(crate) fn tilted() -> RobotModel {
    let turned = |angles: [f64; 3], shift: [f64; 3]| {
        Pose::from_parts(
            Translation3::new(shift[0], shift[1], shift[2]),
            UnitQuaternion::from_euler_angles(angles[0], angles[1], angles[2]),
        )
    };
    let mut robot = rrr();
    robot.name = "tilted".to_owned();
    robot.family = Family::General;
    robot.world_from_base = turned([0.4, -0.3, 0.9], [0.1, -0.2, 0.5]);
    let axes = [Vector3::new(0.3, -0.5, 0.8), Vector3::new(-1.0, 0.0, 0.0), Vector3::new(0.2, 0.9, -0.1)];
    for (index, joint) in robot.joints.iter_mut().enumerate() {
        let k = index as f64;
        joint.axis = Unit::new_normalize(axes[index]);
        joint.parent_from_joint = turned([0.2 + k, 0.5 - k, 0.3 * k], [0.3, 0.1 * k, 0.2]);
        joint.damping = 0.7 + k;
        joint.rotor_inertia = 0.05 * (k + 1.0);
    }
    robot.joints[1].kind = JointKind::Prismatic;
    robot.joints[1].limits.position_min = -0.2;
    robot.joints[1].limits.position_max = 0.3;
    for (index, link) in robot.links.iter_mut().enumerate() {
        let k = index as f64;
        let principal = Matrix3::from_diagonal(&Vector3::new(0.3 + k, 0.5, 0.7 + 0.9 * k));
        let rotation = Rotation3::from_euler_angles(0.7 + k, -0.4, 0.3 * k);
        link.inertial = Inertial {
            mass: 4.0 - k,
            center: Point3::new(0.1, -0.2 * k, 0.15),
            tensor: rotation.matrix() * principal * rotation.matrix().transpose(),
        };
    }
    robot
}

/// Nothing around, with this gravity.
pub(crate) fn empty_cell(gravity: Vector3<f64>) -> Cell {
    Cell { gravity, bodies: Vec::new(), clearance: ClearanceRule { required: 0.005, pairs: Vec::new() } }
}

/// A table of 0.1 m thickness whose top is at `height` below the middle of the cell.
pub(crate) fn table(x: f64, y: f64, top: f64) -> CellBody {
    CellBody {
        name: "table".to_owned(),
        shape: Shape::Box { half_extents: Vector3::new(0.1, 0.1, 0.05) },
        world_from_shape: at(x, y, top - 0.05),
    }
}

/// A cube of 0.1 kg at this pose.
pub(crate) fn cube(world_from_object: Pose) -> Object {
    Object {
        name: "cube".to_owned(),
        shape: Shape::Box { half_extents: Vector3::repeat(CUBE / 2.0) },
        mass: 0.1,
        friction: 0.8,
        world_from_object,
        handles: Vec::new(),
    }
}

/// A grasp of the cube in the middle of the pads.
pub(crate) fn grasp(force: f64) -> Grasp {
    Grasp {
        handle: "sides".to_owned(),
        tool_from_object: Pose::identity(),
        width: CUBE,
        opening: CUBE + 0.02,
        force,
        world_from_start: Pose::identity(),
        world_from_placed: Pose::identity(),
    }
}

/// One millisecond, four substeps, critically damped control of 100 rad/s, stiff contacts.
pub(crate) fn execution() -> Execution {
    Execution {
        dt: 1e-3,
        substeps: 4,
        settle: 0.2,
        controller: Controller::ComputedTorque { bandwidth: 100.0, damping_ratio: 1.0 },
        contact: ContactModel { frequency: 300.0, damping_ratio: 5.0, prediction: 0.002, friction: 0.8 },
        seed: 1,
        control_period: None,
        imperfections: Default::default(),
    }
}

/// A quintic from rest to rest through these joint positions, each reached after its duration.
pub(crate) fn through(start: &[f64], legs: &[(f64, Vec<f64>)]) -> Trajectory {
    let mut knots = vec![0.0];
    let mut pieces = Vec::new();
    let mut from = start.to_vec();
    for (duration, to) in legs {
        knots.push(knots[knots.len() - 1] + duration);
        for (from, to) in from.iter().zip(to) {
            pieces.push(Polynomial::quintic_hermite([*from, 0.0, 0.0], [*to, 0.0, 0.0], *duration));
        }
        from.clone_from(to);
    }
    Trajectory::new(start.len(), knots, pieces).expect("the legs have positive durations")
}

/// A plan that moves the arm from rest to rest with nothing in the gripper.
pub(crate) fn move_plan(start: &[f64], legs: &[(f64, Vec<f64>)]) -> Plan {
    let trajectory = through(start, legs);
    let duration = trajectory.duration();
    Plan {
        trajectory,
        opening: Trajectory::hold(&[0.06], duration).expect("the duration is positive"),
        phases: vec![Phase { name: "move".to_owned(), start: 0.0, end: duration, holding: Holding::Nothing }],
        grasp: None,
        paths: Vec::new(),
    }
}

/// Robot, cell, cube and plan of a lift: close for 0.5 s, lift by 0.1 m in 1 s, hold for 1 s.
pub(crate) struct Lift {
    pub(crate) robot: RobotModel,
    pub(crate) cell: Cell,
    pub(crate) object: Object,
    pub(crate) plan: Plan,
}

/// The lift of a cube with a SCARA whose fingers press with `force`, N.
pub(crate) fn lift(force: f64) -> Lift {
    let robot = scara();
    let low = vec![0.3, 0.5, -0.2, 0.1];
    let high = vec![0.3, 0.5, -0.1, 0.1];
    let world_from_tool = robot.world_from_tool(&low);
    let middle = world_from_tool.translation.vector;
    let mut cell = empty_cell(GRAVITY);
    cell.bodies.push(table(middle.x, middle.y, middle.z - CUBE / 2.0));
    let grasp = grasp(force);
    let below = grasp.width - 0.004;
    let opening = through(&[grasp.opening], &[(0.5, vec![below]), (1.0, vec![below]), (1.0, vec![below])]);
    let phase = |name: &str, start, end, holding| Phase { name: name.to_owned(), start, end, holding };
    let plan = Plan {
        trajectory: through(&low, &[(0.5, low.clone()), (1.0, high.clone()), (1.0, high)]),
        opening,
        phases: vec![
            phase("close", 0.0, 0.5, Holding::Closing),
            phase("lift", 0.5, 1.5, Holding::Held),
            phase("hold", 1.5, 2.5, Holding::Held),
        ],
        grasp: Some(grasp),
        paths: Vec::new(),
    };
    Lift { robot, cell, object: cube(world_from_tool), plan }
}
