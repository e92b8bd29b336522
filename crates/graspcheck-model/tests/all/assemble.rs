//! From URDF and settings to a robot, and what can be wrong with the two together.

use std::f64::consts::FRAC_PI_2;

use graspcheck_model::{
    Pose,
    assemble::{AssetFault, FaultPlace},
    inertia::Inertial,
    robot::{AllowedContact, Family, RobotModel},
    settings::{GripperSettings, JointSettings, RobotSettings, ToolSettings},
    shape::Shape,
    urdf::parse,
};
use nalgebra::{Matrix3, Point3, Vector3};

use crate::arms;

const URDF: &str = include_str!("../arms/small.urdf");

/// A tetrahedron with corners at the origin and one along each axis, as a text STL.
const TETRAHEDRON: &[u8] = b"solid t
facet normal 0 0 -1\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 1 0 0\nendloop\nendfacet
facet normal 0 -1 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0 1\nendloop\nendfacet
facet normal -1 0 0\nouter loop\nvertex 0 0 0\nvertex 0 0 1\nvertex 0 1 0\nendloop\nendfacet
facet normal 1 1 1\nouter loop\nvertex 1 0 0\nvertex 0 1 0\nvertex 0 0 1\nendloop\nendfacet
endsolid t\n";

fn settings() -> RobotSettings {
    let joint = |name: &str, acceleration| JointSettings {
        name: name.to_owned(),
        acceleration,
        jerk: 10.0 * acceleration,
        rotor_inertia: 0.01,
    };
    RobotSettings {
        world_from_base: arms::pose([0.0, 0.0, 0.5], [0.0; 3]),
        joints: vec![joint("wrist", 4.0), joint("shoulder", 2.0), joint("elbow", 3.0)],
        tool: ToolSettings {
            link: "flange".to_owned(),
            link_from_tool: arms::pose([0.02, 0.0, 0.0], [0.0; 3]),
        },
        gripper: GripperSettings {
            fingers: ["finger_right_slide".to_owned(), "finger_left_slide".to_owned()],
            opening_max: 0.08,
            free_opening: 0.005,
            force_max: 40.0,
            finger_speed: 0.05,
        },
        allowed_contacts: vec![AllowedContact {
            a: "hand".to_owned(),
            b: "finger_left".to_owned(),
            reason: "it slides there".to_owned(),
        }],
    }
}

fn assemble(text: &str, settings: &RobotSettings) -> Result<RobotModel, Vec<AssetFault>> {
    let urdf = parse(text).expect("a good text");
    RobotModel::assemble("small", &urdf, settings, &mut |name| match name {
        "forearm.stl" => Ok(TETRAHEDRON.to_vec()),
        _ => Err("no such file".to_owned()),
    })
}

fn good() -> RobotModel {
    assemble(URDF, &settings()).expect("a good robot")
}

#[test]
fn joints_have_what_urdf_and_settings_say() {
    let robot = good();
    let names: Vec<&str> = robot.joints.iter().map(|joint| joint.name.as_str()).collect();
    assert_eq!(names, ["shoulder", "elbow", "wrist"]);
    let links: Vec<&str> = robot.links.iter().map(|link| link.name.as_str()).collect();
    assert_eq!(links, ["upper_arm", "forearm", "hand"]);
    let shoulder = &robot.joints[0];
    let limits = shoulder.limits;
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} {b}");
    for (found, expected) in [
        (limits.position_min, -4.7),
        (limits.position_max, 4.7),
        (limits.velocity, 1.5),
        (limits.acceleration, 2.0),
        (limits.jerk, 20.0),
        (limits.effort, 300.0),
        (shoulder.damping, 0.5),
        (shoulder.friction, 0.25),
        (shoulder.rotor_inertia, 0.01),
        (robot.joints[1].damping, 0.0),
    ] {
        close(found, expected);
    }
    let Family::PlanarRrr { upper, fore, hand } = robot.family else { panic!("{:?}", robot.family) };
    for (found, expected) in [(upper, 1.0), (fore, 0.75)] {
        close(found, expected);
    }
    // Hand to palm 0.1 m, a turn of 0.1 rad, palm to flange 0.1 m, the turn back, flange to tool 0.02 m.
    let tool = Vector3::new(0.1 + 0.1 * 0.1_f64.cos() + 0.02, 0.1 * 0.1_f64.sin(), 0.0);
    assert!((robot.link_from_tool.translation.vector - tool).norm() < 1e-15);
    assert!((hand - tool.norm()).abs() < 1e-15);
    assert!(robot.link_from_tool.rotation.angle() < 1e-15);
}

#[test]
fn a_rotated_inertial_frame_is_honoured() {
    let own = Matrix3::new(0.1, 0.01, 0.0, 0.01, 0.2, 0.0, 0.0, 0.0, 0.25);
    // Fixed axes: first roll about x, then pitch about y, then yaw about z.
    let [roll, pitch, yaw] = [0.3_f64, -0.2, 0.9];
    let about_x = Matrix3::new(1.0, 0.0, 0.0, 0.0, roll.cos(), -roll.sin(), 0.0, roll.sin(), roll.cos());
    let about_y = Matrix3::new(pitch.cos(), 0.0, pitch.sin(), 0.0, 1.0, 0.0, -pitch.sin(), 0.0, pitch.cos());
    let about_z = Matrix3::new(yaw.cos(), -yaw.sin(), 0.0, yaw.sin(), yaw.cos(), 0.0, 0.0, 0.0, 1.0);
    let rotation = about_z * about_y * about_x;
    let inertial = &good().links[0].inertial;
    assert!((inertial.tensor - rotation * own * rotation.transpose()).amax() < 1e-15);
    assert!(
        (inertial.tensor - own).amax() > 0.01,
        "the rotation must matter for this test to mean something"
    );
    assert!((inertial.center - Point3::new(0.5, 0.1, 0.0)).norm() < 1e-15);
}

#[test]
fn fixed_links_are_merged_with_mass_and_shape() {
    let hand = &good().links[2];
    let own = |at: Pose| {
        Inertial { mass: 1.0, center: Point3::origin(), tensor: Matrix3::identity() * 0.1 }.transformed(&at)
    };
    let hand_from_palm = arms::pose([0.1, 0.0, 0.0], [0.0, 0.0, 0.1]);
    let palm = own(hand_from_palm * arms::pose([0.1, 0.0, 0.0], [0.0; 3]));
    let expected = Inertial::combine(&[own(Pose::identity()), palm]);
    assert!((hand.inertial.mass - 2.0).abs() < 1e-15);
    assert!((hand.inertial.tensor - expected.tensor).amax() < 1e-15);
    assert!((hand.inertial.center - expected.center).norm() < 1e-15);
    assert!(matches!(hand.shapes[0].shape, Shape::Sphere { .. }));
    assert!(matches!(hand.shapes[1].shape, Shape::Cylinder { .. }));
    let off = hand.shapes[1].body_from_shape.inverse() * hand_from_palm;
    assert!(off.translation.vector.norm() + off.rotation.angle() < 1e-15);
}

#[test]
fn shapes_have_half_lengths_and_meshes_are_scaled_hulls() {
    let robot = good();
    assert_eq!(robot.base.shapes[0].shape, Shape::Box { half_extents: Vector3::new(0.1, 0.1, 0.05) });
    assert_eq!(robot.links[0].shapes[0].shape, Shape::Capsule { radius: 0.05, half_length: 0.4 });
    let along = robot.links[0].shapes[0].body_from_shape * Vector3::z();
    assert!((along - Vector3::x()).norm() < 1e-15, "the capsule lies along the arm");
    let Shape::Hull { points } = &robot.links[1].shapes[0].shape else { panic!("no hull") };
    assert_eq!(points.len(), 4);
    for corner in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]] {
        assert!(points.iter().any(|point| (point - Point3::from(corner)).norm() < 1e-7), "{points:?}");
    }
}

#[test]
fn fingers_stand_at_half_the_opening_on_both_sides_of_the_tool() {
    let robot = good();
    assert_eq!(robot.gripper.fingers[0].joint, "finger_left_slide", "the driving finger comes first");
    let tool_from_link = robot.link_from_tool.inverse();
    for (finger, side) in [(0, 1.0), (1, -1.0)] {
        for opening in [0.0, 0.03, 0.08] {
            let shapes = robot.gripper.finger_shapes(finger, opening);
            let tool_from_pad = tool_from_link * shapes[0].body_from_shape;
            // The pads are 20 mm thick: their middle is 10 mm behind the face.
            let expected = Vector3::new(-0.02, side * (0.5 * opening + 0.01), 0.0);
            assert!((tool_from_pad.translation.vector - expected).norm() < 1e-15);
        }
    }
}

#[test]
fn a_base_in_the_world_moves_everything() {
    let mut lifted = settings();
    lifted.world_from_base = arms::pose([1.0, 2.0, 3.0], [FRAC_PI_2, 0.0, 0.0]);
    let robot = assemble(URDF, &lifted).unwrap();
    let wrist = robot.world_from_wrist(&[0.0, FRAC_PI_2, 0.0]).translation.vector;
    assert!((wrist - Vector3::new(2.0, 2.0, 3.75)).norm() < 1e-14, "{wrist}");
}

/// Spoils the settings and gives the only fault that comes out.
fn setting_fault(spoil: impl FnOnce(&mut RobotSettings)) -> AssetFault {
    let mut settings = settings();
    spoil(&mut settings);
    let mut faults = assemble(URDF, &settings).expect_err("the settings have a fault");
    assert_eq!(faults.len(), 1, "{faults:#?}");
    faults.remove(0)
}

#[test]
fn every_fault_of_the_settings_is_named_with_its_key() {
    type Spoil = fn(&mut RobotSettings);
    let cases: &[(Spoil, &str, &str)] = &[
        (|s| s.joints[2].jerk = -3.0, "joint.elbow.jerk", "joint elbow: jerk -3 rad/s³ must be positive"),
        (
            |s| s.joints[2].acceleration = f64::NAN,
            "joint.elbow.acceleration",
            "joint elbow: acceleration NaN rad/s² must be positive",
        ),
        (
            |s| s.joints[0].rotor_inertia = -0.1,
            "joint.wrist.rotor_inertia",
            "joint wrist: rotor inertia -0.1 must not be negative",
        ),
        (|s| drop(s.joints.remove(0)), "joint", "joint wrist: no settings"),
        (
            |s| s.joints.push(JointSettings { name: "knee".into(), ..s.joints[0].clone() }),
            "joint.knee",
            "joint knee: no such joint in the arm",
        ),
        (
            |s| s.joints.push(JointSettings { name: "finger_left_slide".into(), ..s.joints[0].clone() }),
            "joint.finger_left_slide",
            "joint finger_left_slide: settings of a finger",
        ),
        (|s| s.joints.push(s.joints[0].clone()), "joint.wrist", "joint wrist: settings stand twice"),
        (
            |s| s.tool.link = "forearm".into(),
            "tool.link",
            "tool: link forearm is not the last link of the arm",
        ),
        (|s| s.tool.link = "palmo".into(), "tool.link", "tool: link palmo is not the last link of the arm"),
        (
            |s| s.gripper.fingers[0] = "elbow".into(),
            "gripper.fingers",
            "gripper: elbow is not a joint of a finger",
        ),
        (
            |s| s.gripper.fingers[0] = "finger_left_slide".into(),
            "gripper.fingers",
            "gripper: finger finger_left_slide stands twice",
        ),
        (|s| s.gripper.opening_max = 0.0, "gripper.opening_max", "gripper: opening max 0 m must be positive"),
        (
            |s| s.gripper.opening_max = 0.1,
            "gripper.opening_max",
            "gripper: opening max 0.1 m exceeds 0.08 m, twice the upper limit of a finger in the URDF",
        ),
        (
            |s| s.gripper.force_max = 60.0,
            "gripper.force_max",
            "gripper: force max 60 N exceeds 50 N, the effort limit of a finger in the URDF",
        ),
        (
            |s| s.gripper.finger_speed = 0.2,
            "gripper.finger_speed",
            "gripper: finger speed 0.2 m/s exceeds 0.1 m/s, the velocity limit of a finger in the URDF",
        ),
        (
            |s| s.gripper.free_opening = -0.001,
            "gripper.free_opening",
            "gripper: free opening -0.001 m must not be negative",
        ),
        (
            |s| s.allowed_contacts[0].a = "palm".into(),
            "allowed_contact",
            "allowed contact palm - finger_left: no body palm",
        ),
        (
            |s| s.allowed_contacts[0].b = "hand".into(),
            "allowed_contact",
            "allowed contact hand - hand: a body with itself",
        ),
        (
            |s| s.allowed_contacts[0].reason = " ".into(),
            "allowed_contact",
            "allowed contact hand - finger_left: no reason",
        ),
        (
            |s| s.world_from_base.translation.x = f64::INFINITY,
            "world_from_base",
            "world_from_base: a number is not finite",
        ),
    ];
    for (spoil, key, title) in cases {
        let fault = setting_fault(spoil);
        assert_eq!(fault.title, *title);
        assert_eq!(fault.place, FaultPlace::Settings((*key).to_owned()), "{title}");
    }
}

#[test]
fn a_link_that_was_merged_is_named_by_its_carrier() {
    let fault = setting_fault(|s| s.allowed_contacts[0].a = "palm".into());
    assert_eq!(fault.detail, "palm is fixed to hand: name that");
}

#[test]
fn every_fault_of_the_urdf_against_the_settings_is_named_at_its_place() {
    for (from, to, title, at) in [
        ("forearm.stl", "missing.stl", "link forearm: mesh missing.stl: no such file", "missing.stl"),
        (
            "<axis xyz=\"0 1 0\"/>",
            "<axis xyz=\"1 0 0\"/>",
            "joint finger_left_slide: opens along (1.000000 0.000000 0.000000) of the tool frame",
            "<joint name=\"finger_left_slide\" type=\"prismatic\">",
        ),
        (
            "<collision><origin xyz=\"0 0.01 0\"/>",
            "<collision><origin xyz=\"0 0.014 0\"/>",
            "link finger_left: the pad is 0.004000 m from the tool's middle plane at position 0",
            "<link name=\"finger_left\">",
        ),
        (
            "<collision><origin xyz=\"0 -0.01 0\"/><geometry><box size=\"0.06 0.02 0.02\"/></geometry></collision>",
            "",
            "link finger_right: a finger without <collision>",
            "<link name=\"finger_right\">",
        ),
        (
            "<limit lower=\"0\" upper=\"0.04\"",
            "<limit lower=\"0.01\" upper=\"0.04\"",
            "joint finger_left_slide: lower limit 0.01 m keeps the pads apart",
            "<joint name=\"finger_left_slide\" type=\"prismatic\">",
        ),
    ] {
        assert!(URDF.contains(from), "{from}");
        let text = URDF.replacen(from, to, 1);
        let faults = assemble(&text, &settings()).expect_err("the URDF has a fault");
        assert_eq!(faults.len(), 1, "{faults:#?}");
        assert_eq!(faults[0].title, title);
        let FaultPlace::Urdf(span) = faults[0].place.clone() else { panic!("{faults:#?}") };
        assert_eq!(&text[span], at);
    }
}

#[test]
fn fingers_that_open_the_same_way_and_reserved_names_are_refused() {
    // The right finger turned round: its pad is then behind the plane, too.
    let text = URDF.replace("<axis xyz=\"0 -1 0\"/>", "<axis xyz=\"0 1 0\"/>");
    let titles: Vec<String> =
        assemble(&text, &settings()).unwrap_err().into_iter().map(|fault| fault.title).collect();
    assert!(
        titles
            .contains(&"joints finger_left_slide and finger_right_slide: both open the same way".to_owned()),
        "{titles:?}"
    );
    let text = URDF.replace("\"forearm\"", "\"gripper\"");
    let faults = assemble(&text, &settings()).unwrap_err();
    assert_eq!(faults[0].title, "link gripper: the name is taken");
}

#[test]
fn a_file_that_is_no_solid_is_refused_with_the_reason() {
    let urdf = parse(URDF).unwrap();
    let flat = b"solid f\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid f\n";
    for (bytes, reason) in [
        (flat.to_vec(), "3 points span no solid"),
        (b"PK\x03\x04 not a mesh".to_vec(), "not an STL"),
        (Vec::new(), "not an STL"),
    ] {
        let faults = RobotModel::assemble("small", &urdf, &settings(), &mut |_| Ok(bytes.clone()))
            .expect_err("the mesh is no solid");
        assert_eq!(faults.len(), 1);
        assert!(faults[0].title.contains(reason), "{}", faults[0].title);
    }
}

#[test]
fn all_faults_of_settings_and_urdf_come_at_once() {
    let mut settings = settings();
    settings.joints[0].jerk = 0.0;
    settings.gripper.force_max = -1.0;
    settings.allowed_contacts[0].a = "nobody".into();
    let faults = assemble(&URDF.replace("forearm.stl", "missing.stl"), &settings).unwrap_err();
    assert_eq!(faults.len(), 4, "{faults:#?}");
}
