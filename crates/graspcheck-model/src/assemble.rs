//! From URDF and settings to a [`RobotModel`].
//!
//! Links that a fixed joint holds are merged into the link that carries them: their solids and masses move
//! with it under its name. A collision mesh is replaced by its convex hull, which contains it: a proof
//! that the hull is free holds for the mesh, a collision of the hull may be one of a hollow of the mesh.
//! The rotation of an inertial frame is honoured.
//!
//! ```
//! use graspcheck_model::{robot::RobotModel, settings::*, urdf, Pose};
//!
//! // A link with a box of 20 mm; that of a finger ends at the pad, y = 0.
//! let link = |name: &str, y: f64| format!(r#"<link name="{name}">
//!     <inertial><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>
//!     <collision><origin xyz="0 {y} 0"/><geometry><box size="0.02 0.02 0.02"/></geometry></collision></link>"#);
//! let slide = |name: &str, y: i32, mimic: &str| format!(r#"<joint name="{name}_slide" type="prismatic">
//!     <parent link="arm"/><child link="{name}"/><axis xyz="0 {y} 0"/>
//!     <limit lower="0" upper="0.04" velocity="0.1" effort="50"/>{mimic}</joint>"#);
//! let text = format!(r#"<robot name="one"><link name="base"/>{}{}{}
//!     <joint name="lift" type="prismatic"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
//!     <limit lower="0" upper="0.3" velocity="1" effort="100"/></joint>{}{}</robot>"#,
//!     link("arm", 0.0), link("left", 0.01), link("right", -0.01),
//!     slide("left", 1, ""), slide("right", -1, r#"<mimic joint="left_slide"/>"#));
//! let document = urdf::parse(&text).expect("a good text");
//! let mut settings = RobotSettings {
//!     world_from_base: Pose::identity(),
//!     joints: vec![JointSettings { name: "lift".into(), acceleration: 10.0, jerk: 100.0, rotor_inertia: 0.0 }],
//!     tool: ToolSettings { link: "arm".into(), link_from_tool: Pose::identity() },
//!     gripper: GripperSettings {
//!         fingers: ["left_slide".into(), "right_slide".into()],
//!         opening_max: 0.08, free_opening: 0.01, force_max: 50.0, finger_speed: 0.1,
//!     },
//!     allowed_contacts: Vec::new(),
//! };
//! let mut no_meshes = |name: &str| Err(format!("there is no mesh {name}"));
//! let robot = RobotModel::assemble("one", &document, &settings, &mut no_meshes).expect("all fits");
//! assert_eq!((robot.dof(), robot.world_from_tool(&[0.2]).translation.z), (1, 0.2));
//!
//! settings.joints[0].jerk = -3.0;
//! let faults = RobotModel::assemble("one", &document, &settings, &mut no_meshes).expect_err("a bad limit");
//! assert!(faults[0].title.contains("lift"), "{}", faults[0].title);
//! ```

use std::{collections::BTreeMap, io::Cursor, ops::Range};

use nalgebra::{Matrix3, Point3, Translation3, Unit, UnitQuaternion, Vector3};

use crate::{
    Pose,
    convex_hull::ConvexHull,
    inertia::Inertial,
    robot::{Family, Finger, Gripper, Joint, JointKind, JointLimits, Link, RobotModel},
    settings::{GripperSettings, JointSettings, RobotSettings},
    shape::{PlacedShape, Shape},
    structure::PlanarGeometry,
    urdf::UrdfDocument,
};

/// How far the pads may be from the tool's middle plane at position 0, m, and a finger's axis from the
/// tool's y, rad: a length written to the micrometre.
const FINGER_TOLERANCE: f64 = 1e-6;

/// Words that stand for several bodies or for frames and are no names of links.
const RESERVED_NAMES: [&str; 4] = ["robot", "gripper", "tool", "world"];

/// Something wrong in a robot's URDF and settings taken together, as plain data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AssetFault {
    /// Place and fact, a lower-case fragment, e.g. `joint elbow: jerk -3 rad/s³ must be positive`.
    pub title: String,
    /// What to say at the place.
    pub detail: String,
    /// Where.
    pub place: FaultPlace,
    /// What to change, where that is known.
    pub help: Option<String>,
}

/// Where an [`AssetFault`] is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FaultPlace {
    /// In the URDF, in bytes of its text.
    Urdf(Range<usize>),
    /// In the settings: a path with dots by the keys of `robot.toml` without their units, such as
    /// `joint.elbow.jerk`, `tool.link`, `gripper.opening_max`, `allowed_contact`.
    Settings(String),
}

impl RobotModel {
    /// The robot `name` that a URDF and settings describe. `meshes` gives the bytes of a mesh file named
    /// in the URDF, or a lower-case sentence that says why it cannot.
    ///
    /// # Errors
    /// All faults at once: a mesh that cannot be read, a joint without settings, settings of a joint that is
    /// not there, numbers out of range, fingers that do not close along the tool's y axis, …
    pub fn assemble(
        name: &str,
        urdf: &UrdfDocument,
        settings: &RobotSettings,
        meshes: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
    ) -> Result<Self, Vec<AssetFault>> {
        let mut assembly = Assembly { urdf, settings, rigid: rigid_frames(urdf), faults: Vec::new() };
        assembly.check_settings();
        let mut links: BTreeMap<String, Link> = BTreeMap::new();
        for body in assembly.body_names() {
            let link = assembly.body(&body, meshes);
            links.insert(body, link);
        }
        let robot = assembly.robot(name, &links);
        if let Some(robot) = &robot {
            assembly.check_fingers(robot);
        }
        assembly.check_contacts();
        match robot {
            Some(robot) if assembly.faults.is_empty() => Ok(robot),
            _ => Err(assembly.faults),
        }
    }
}

/// A link fixed to a body.
struct Rigid {
    /// The moving link (or root) that carries it; itself for such a link.
    body: String,
    body_from_link: Pose,
}

/// For every link the body that carries it.
fn rigid_frames(urdf: &UrdfDocument) -> BTreeMap<String, Rigid> {
    let joint_above = |link: &str| urdf.robot.joints.iter().find(|joint| joint.child.link == link);
    let frame = |link: &str| {
        let (mut body, mut body_from_link) = (link, Pose::identity());
        while let Some(joint) =
            joint_above(body).filter(|joint| joint.joint_type == urdf_rs::JointType::Fixed)
        {
            body_from_link = pose(&joint.origin) * body_from_link;
            body = &joint.parent.link;
        }
        Rigid { body: body.to_owned(), body_from_link }
    };
    urdf.robot.links.iter().map(|link| (link.name.clone(), frame(&link.name))).collect()
}

/// The work in progress.
struct Assembly<'a> {
    urdf: &'a UrdfDocument,
    settings: &'a RobotSettings,
    rigid: BTreeMap<String, Rigid>,
    faults: Vec<AssetFault>,
}

impl Assembly<'_> {
    fn setting_fault(&mut self, key: impl Into<String>, title: String, detail: impl Into<String>) {
        let place = FaultPlace::Settings(key.into());
        self.faults.push(AssetFault { title, detail: detail.into(), place, help: None });
    }

    fn urdf_joint(&self, name: &str) -> Option<&urdf_rs::Joint> {
        self.urdf.robot.joints.iter().find(|joint| joint.name == name)
    }

    /// The names of all bodies: base, moving links from base to tool, fingers.
    fn body_names(&self) -> Vec<String> {
        let chain = &self.urdf.chain;
        let moved = chain.arm.iter().chain(&chain.fingers);
        let children = moved.filter_map(|name| self.urdf_joint(name)).map(|joint| joint.child.link.clone());
        std::iter::once(chain.root.clone()).chain(children).collect()
    }

    /// The settings of joints, tool and gripper, each in itself and against the URDF.
    fn check_settings(&mut self) {
        let settings = self.settings;
        let finite = |pose: &Pose| pose.to_homogeneous().iter().all(|value| value.is_finite());
        for (key, pose) in
            [("world_from_base", &settings.world_from_base), ("tool", &settings.tool.link_from_tool)]
        {
            if !finite(pose) {
                self.setting_fault(key, format!("{key}: a number is not finite"), "must be finite");
            }
        }
        let arm = &self.urdf.chain.arm;
        for (index, joint) in settings.joints.iter().enumerate() {
            let key = format!("joint.{}", joint.name);
            let title = format!("joint {}", joint.name);
            if self.urdf.chain.fingers.contains(&joint.name) {
                self.setting_fault(
                    key,
                    format!("{title}: settings of a finger"),
                    "the gripper's numbers say it all",
                );
            } else if !arm.contains(&joint.name) {
                let detail = format!("the joints of the arm are {}", arm.join(", "));
                self.setting_fault(key, format!("{title}: no such joint in the arm"), detail);
            } else if settings.joints[..index].iter().any(|other| other.name == joint.name) {
                self.setting_fault(key, format!("{title}: settings stand twice"), "already set");
            } else {
                self.check_joint_settings(joint);
            }
        }
        for name in arm {
            if !settings.joints.iter().any(|joint| joint.name == *name) {
                let title = format!("joint {name}: no settings");
                self.setting_fault("joint", title, "needs acceleration, jerk and rotor inertia");
            }
        }
        self.check_gripper_settings(&settings.gripper);
    }

    fn check_joint_settings(&mut self, joint: &JointSettings) {
        let unit = match self.urdf.joint_kind(&joint.name) {
            Some(JointKind::Prismatic) => "m",
            _ => "rad",
        };
        for (what, value, per) in [("acceleration", joint.acceleration, "s²"), ("jerk", joint.jerk, "s³")] {
            if !is_positive(value) {
                let title = format!("joint {}: {what} {value} {unit}/{per} must be positive", joint.name);
                self.setting_fault(
                    format!("joint.{}.{what}", joint.name),
                    title,
                    "must be positive and finite",
                );
            }
        }
        if !(joint.rotor_inertia >= 0.0 && joint.rotor_inertia.is_finite()) {
            let title =
                format!("joint {}: rotor inertia {} must not be negative", joint.name, joint.rotor_inertia);
            self.setting_fault(format!("joint.{}.rotor_inertia", joint.name), title, "must be 0 or more");
        }
    }

    fn check_gripper_settings(&mut self, gripper: &GripperSettings) {
        let tied = &self.urdf.chain.fingers;
        for finger in &gripper.fingers {
            if !tied.contains(finger) {
                let title = format!("gripper: {finger} is not a joint of a finger");
                let detail = format!("the URDF ties {} and {}", tied[0], tied[1]);
                self.setting_fault("gripper.fingers", title, detail);
            }
        }
        if gripper.fingers[0] == gripper.fingers[1] {
            let title = format!("gripper: finger {} stands twice", gripper.fingers[0]);
            self.setting_fault("gripper.fingers", title, "needs two fingers");
        }
        let (mut stroke, mut effort, mut speed) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
        for joint in tied.clone().iter().filter_map(|name| self.urdf_joint(name)) {
            stroke = stroke.min(joint.limit.upper);
            effort = effort.min(joint.limit.effort);
            speed = speed.min(joint.limit.velocity);
        }
        for (what, value, limit, source, unit) in [
            ("opening_max", gripper.opening_max, 2.0 * stroke, "twice the upper limit of a finger", "m"),
            ("force_max", gripper.force_max, effort, "the effort limit of a finger", "N"),
            ("finger_speed", gripper.finger_speed, speed, "the velocity limit of a finger", "m/s"),
        ] {
            let key = format!("gripper.{what}");
            let words = what.replace('_', " ");
            if !is_positive(value) {
                let title = format!("gripper: {words} {value} {unit} must be positive");
                self.setting_fault(key, title, "must be positive and finite");
            } else if value > limit * (1.0 + f64::EPSILON) {
                let title =
                    format!("gripper: {words} {value} {unit} exceeds {limit} {unit}, {source} in the URDF");
                self.setting_fault(key, title, format!("at most {limit} {unit}"));
            }
        }
        if !(gripper.free_opening >= 0.0 && gripper.free_opening.is_finite()) {
            let title = format!("gripper: free opening {} m must not be negative", gripper.free_opening);
            self.setting_fault("gripper.free_opening", title, "must be 0 or more");
        }
    }

    /// A body with everything that is fixed to it.
    fn body(&mut self, name: &str, meshes: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>) -> Link {
        if RESERVED_NAMES.contains(&name) {
            self.faults.push(AssetFault {
                title: format!("link {name}: the name is taken"),
                detail: "stands for several bodies or a frame".to_owned(),
                place: FaultPlace::Urdf(self.urdf.link_span(name)),
                help: None,
            });
        }
        let (mut inertials, mut shapes) = (Vec::new(), Vec::new());
        for link in &self.urdf.robot.links {
            let Some(rigid) = self.rigid.get(&link.name).filter(|rigid| rigid.body == name) else { continue };
            let body_from_link = rigid.body_from_link;
            inertials.push(inertial(&link.inertial).transformed(&body_from_link));
            for collision in &link.collision {
                match shape(&collision.geometry, meshes) {
                    Ok(shape) => {
                        let body_from_shape = body_from_link * pose(&collision.origin);
                        shapes.push(PlacedShape { body_from_shape, shape });
                    }
                    Err(unreadable) => self.faults.push(AssetFault {
                        title: format!(
                            "link {}: mesh {}: {}",
                            link.name, unreadable.filename, unreadable.reason
                        ),
                        detail: "cannot be used for collision".to_owned(),
                        place: FaultPlace::Urdf(self.urdf.mesh_span(&unreadable.filename)),
                        help: None,
                    }),
                }
            }
        }
        Link { name: name.to_owned(), inertial: Inertial::combine(&inertials), shapes }
    }

    /// The model, if all its parts are there.
    fn robot(&mut self, name: &str, links: &BTreeMap<String, Link>) -> Option<RobotModel> {
        let chain = &self.urdf.chain;
        let mut joints = Vec::new();
        let mut moving = Vec::new();
        for joint in &chain.arm {
            joints.push(self.joint(joint)?);
            moving.push(links.get(&self.urdf_joint(joint)?.child.link)?.clone());
        }
        let last = moving.last()?.name.clone();
        let tool = &self.settings.tool;
        let Some(carrier) = self.rigid.get(&tool.link).filter(|rigid| rigid.body == last) else {
            let title = format!("tool: link {} is not the last link of the arm", tool.link);
            self.setting_fault("tool.link", title, format!("the last link is {last}"));
            return None;
        };
        let link_from_tool = carrier.body_from_link * tool.link_from_tool;
        let [driving, following] = &chain.fingers;
        let settings = &self.settings.gripper;
        let gripper = Gripper {
            fingers: [self.finger(driving, links)?, self.finger(following, links)?],
            opening_max: settings.opening_max,
            free_opening: settings.free_opening,
            force_max: settings.force_max,
            finger_speed: settings.finger_speed,
        };
        let mut robot = RobotModel {
            name: name.to_owned(),
            family: Family::General,
            world_from_base: self.settings.world_from_base,
            base: links.get(&chain.root)?.clone(),
            joints,
            links: moving,
            link_from_tool,
            gripper,
            allowed_contacts: self.settings.allowed_contacts.clone(),
        };
        if let Ok(geometry) = PlanarGeometry::of(&robot) {
            robot.family = geometry.family();
        }
        Some(robot)
    }

    /// A joint of the arm; none when its settings are missing, which was reported.
    fn joint(&self, name: &str) -> Option<Joint> {
        let joint = self.urdf_joint(name)?;
        let settings = self.settings.joints.iter().find(|settings| settings.name == name)?;
        let dynamics = joint.dynamics.clone().unwrap_or_default();
        Some(Joint {
            name: name.to_owned(),
            kind: self.urdf.joint_kind(name)?,
            parent_from_joint: self.rigid.get(&joint.parent.link)?.body_from_link * pose(&joint.origin),
            axis: axis(joint),
            limits: JointLimits {
                position_min: joint.limit.lower,
                position_max: joint.limit.upper,
                velocity: joint.limit.velocity,
                acceleration: settings.acceleration,
                jerk: settings.jerk,
                effort: joint.limit.effort,
            },
            damping: dynamics.damping,
            friction: dynamics.friction,
            rotor_inertia: settings.rotor_inertia,
        })
    }

    fn finger(&self, name: &str, links: &BTreeMap<String, Link>) -> Option<Finger> {
        let joint = self.urdf_joint(name)?;
        Some(Finger {
            link: links.get(&joint.child.link)?.clone(),
            joint: name.to_owned(),
            link_from_finger: self.rigid.get(&joint.parent.link)?.body_from_link * pose(&joint.origin),
            axis: axis(joint),
        })
    }

    /// The fingers open along the tool's y in opposite directions, and their pads touch in the tool's
    /// middle plane at position 0.
    fn check_fingers(&mut self, robot: &RobotModel) {
        let tool_from_link = robot.link_from_tool.inverse();
        let opens = [0, 1].map(|index| {
            let finger = &robot.gripper.fingers[index];
            tool_from_link.rotation * finger.link_from_finger.rotation * finger.axis.into_inner()
        });
        for (finger, direction) in robot.gripper.fingers.iter().zip(&opens) {
            let span = self.urdf.joint_span(&finger.joint);
            let across = Vector3::new(direction.x, 0.0, direction.z).norm();
            if across > FINGER_TOLERANCE {
                let [x, y, z] = <[f64; 3]>::from(*direction);
                self.faults.push(AssetFault {
                    title: format!(
                        "joint {}: opens along ({x:.6} {y:.6} {z:.6}) of the tool frame",
                        finger.joint
                    ),
                    detail: "must open along the tool's y axis".to_owned(),
                    place: FaultPlace::Urdf(span),
                    help: Some("turn the axis of the joint, or the tool frame in robot.toml".to_owned()),
                });
                continue;
            }
            let lower = self.urdf_joint(&finger.joint).map_or(0.0, |joint| joint.limit.lower);
            if lower > 0.0 {
                self.faults.push(AssetFault {
                    title: format!("joint {}: lower limit {lower} m keeps the pads apart", finger.joint),
                    detail: "must reach 0, where the pads touch".to_owned(),
                    place: FaultPlace::Urdf(self.urdf.joint_span(&finger.joint)),
                    help: None,
                });
            }
            self.check_pad(finger, &(tool_from_link * finger.link_from_finger), direction);
        }
        if opens[0].dot(&opens[1]) > 0.0 {
            let names = robot.gripper.fingers.each_ref().map(|finger| finger.joint.as_str());
            self.faults.push(AssetFault {
                title: format!("joints {} and {}: both open the same way", names[0], names[1]),
                detail: "must open in opposite directions".to_owned(),
                place: FaultPlace::Urdf(self.urdf.joint_span(names[1])),
                help: Some("turn the axis of one of them round".to_owned()),
            });
        }
    }

    /// The foremost face of a finger at position 0 lies in the tool's x-z plane.
    fn check_pad(&mut self, finger: &Finger, tool_from_finger: &Pose, opens: &Vector3<f64>) {
        let inner = finger.link.shapes.iter().map(|placed| {
            let tool_from_shape = tool_from_finger * placed.body_from_shape;
            let inward = tool_from_shape.rotation.inverse() * -opens;
            opens.dot(&(tool_from_shape * placed.shape.support(&inward)).coords)
        });
        let face = inner.fold(f64::INFINITY, f64::min);
        let (title, detail) = if face.is_infinite() {
            (format!("link {}: a finger without <collision>", finger.link.name), "needs a pad that touches")
        } else if face.abs() > FINGER_TOLERANCE {
            let title = format!(
                "link {}: the pad is {face:.6} m from the tool's middle plane at position 0",
                finger.link.name
            );
            (title, "the pads must touch at position 0")
        } else {
            return;
        };
        self.faults.push(AssetFault {
            title,
            detail: detail.to_owned(),
            place: FaultPlace::Urdf(self.urdf.link_span(&finger.link.name)),
            help: None,
        });
    }

    /// Allowed contacts name two bodies and a reason.
    fn check_contacts(&mut self) {
        let bodies = self.body_names();
        for contact in &self.settings.allowed_contacts {
            let pair = format!("allowed contact {} - {}", contact.a, contact.b);
            for name in [&contact.a, &contact.b] {
                if bodies.contains(name) {
                    continue;
                }
                let detail = match self.rigid.get(name) {
                    Some(rigid) => format!("{name} is fixed to {}: name that", rigid.body),
                    None => format!("the bodies are {}", bodies.join(", ")),
                };
                self.setting_fault("allowed_contact", format!("{pair}: no body {name}"), detail);
            }
            if contact.a == contact.b {
                self.setting_fault(
                    "allowed_contact",
                    format!("{pair}: a body with itself"),
                    "needs two bodies",
                );
            }
            if contact.reason.trim().is_empty() {
                self.setting_fault("allowed_contact", format!("{pair}: no reason"), "say why they may touch");
            }
        }
    }
}

fn is_positive(value: f64) -> bool {
    value > 0.0 && value.is_finite()
}

/// The pose of a URDF `<origin>`: fixed-axis roll, pitch, yaw.
fn pose(origin: &urdf_rs::Pose) -> Pose {
    let [roll, pitch, yaw] = *origin.rpy;
    Pose::from_parts(
        Translation3::from(Vector3::from(*origin.xyz)),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    )
}

/// The axis of a joint; the strict pass has checked that its length is 1 to six digits.
fn axis(joint: &urdf_rs::Joint) -> Unit<Vector3<f64>> {
    Unit::new_normalize(Vector3::from(*joint.axis.xyz))
}

/// Mass properties in the frame of the link; a link without `<inertial>` is a frame without mass.
fn inertial(inertial: &urdf_rs::Inertial) -> Inertial {
    let urdf_rs::Inertia { ixx, ixy, ixz, iyy, iyz, izz } = inertial.inertia;
    let in_own_frame = Inertial {
        mass: inertial.mass.value,
        center: Point3::origin(),
        tensor: Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz),
    };
    in_own_frame.transformed(&pose(&inertial.origin))
}

/// A mesh that is no solid.
struct Unreadable {
    filename: String,
    reason: String,
}

/// The solid of a URDF `<geometry>`. A capsule's length is that of its cylinder.
fn shape(
    geometry: &urdf_rs::Geometry,
    meshes: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
) -> Result<Shape, Unreadable> {
    Ok(match geometry {
        urdf_rs::Geometry::Box { size } => Shape::Box { half_extents: Vector3::from(**size) / 2.0 },
        urdf_rs::Geometry::Sphere { radius } => Shape::Sphere { radius: *radius },
        urdf_rs::Geometry::Cylinder { radius, length } => {
            Shape::Cylinder { radius: *radius, half_length: length / 2.0 }
        }
        urdf_rs::Geometry::Capsule { radius, length } => {
            Shape::Capsule { radius: *radius, half_length: length / 2.0 }
        }
        urdf_rs::Geometry::Mesh { filename, scale } => {
            let scale = scale.map_or([1.0; 3], |scale| *scale);
            let points = meshes(filename).and_then(|bytes| hull_of_stl(&bytes, Vector3::from(scale)));
            let points = points.map_err(|reason| Unreadable { filename: filename.clone(), reason })?;
            Shape::Hull { points }
        }
    })
}

/// The corners of the convex hull of an STL file, m.
fn hull_of_stl(bytes: &[u8], scale: Vector3<f64>) -> Result<Vec<Point3<f64>>, String> {
    let mesh = stl_io::read_stl(&mut Cursor::new(bytes)).map_err(|error| format!("not an STL: {error}"))?;
    let corners = mesh.vertices.iter().map(|vertex| {
        let [x, y, z] = vertex.0.map(f64::from);
        Point3::from(Vector3::new(x, y, z).component_mul(&scale))
    });
    ConvexHull::of(&corners.collect::<Vec<_>>()).map(|hull| hull.points).map_err(|error| error.to_string())
}
