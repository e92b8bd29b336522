//! The ROS 2 messages of a recording: structs whose fields are in the order of the wire, and the interface
//! definitions that travel in the file.
//!
//! Text and lists are borrowed when a message is written and owned when it was read.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

/// Text, borrowed on the way out.
pub(super) type Text<'a> = Cow<'a, str>;

/// `builtin_interfaces/Time` and, for markers, `builtin_interfaces/Duration` (the same on the wire).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Time {
    pub(super) sec: i32,
    pub(super) nanosec: u32,
}

impl Time {
    /// The stamp of a time that [`crate::validate`] has accepted.
    pub(super) fn from_ns(time_ns: i64) -> Self {
        let sec = i32::try_from(time_ns.div_euclid(1_000_000_000)).expect("validated: fits a stamp");
        let nanosec = u32::try_from(time_ns.rem_euclid(1_000_000_000)).expect("below 10⁹");
        Self { sec, nanosec }
    }

    /// The time in ns, unless the stamp is negative or not normalised.
    pub(super) fn to_ns(self) -> Option<i64> {
        (self.sec >= 0 && self.nanosec < 1_000_000_000)
            .then(|| i64::from(self.sec) * 1_000_000_000 + i64::from(self.nanosec))
    }
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Header<'a> {
    pub(super) stamp: Time,
    pub(super) frame_id: Text<'a>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct StringMessage<'a> {
    pub(super) data: Text<'a>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct JointState<'a> {
    pub(super) header: Header<'a>,
    pub(super) name: Cow<'a, [String]>,
    pub(super) position: Cow<'a, [f64]>,
    pub(super) velocity: Cow<'a, [f64]>,
    pub(super) effort: Cow<'a, [f64]>,
}

/// `geometry_msgs/PoseStamped`: position and quaternion as they stand in a row.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct PoseStamped<'a> {
    pub(super) header: Header<'a>,
    pub(super) pose: [f64; 7],
}

/// `geometry_msgs/TwistStamped`: linear, then angular velocity.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct TwistStamped<'a> {
    pub(super) header: Header<'a>,
    pub(super) twist: [f64; 6],
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct TransformStamped<'a> {
    /// Its `frame_id` is the parent.
    pub(super) header: Header<'a>,
    pub(super) child_frame_id: Text<'a>,
    pub(super) transform: [f64; 7],
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct TfMessage<'a> {
    pub(super) transforms: Vec<TransformStamped<'a>>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Marker<'a> {
    pub(super) header: Header<'a>,
    pub(super) ns: Text<'a>,
    pub(super) id: i32,
    pub(super) kind: i32,
    pub(super) action: i32,
    pub(super) pose: [f64; 7],
    pub(super) scale: [f64; 3],
    pub(super) color: [f32; 4],
    pub(super) lifetime: Time,
    pub(super) frame_locked: bool,
    pub(super) points: Cow<'a, [[f64; 3]]>,
    pub(super) colors: Vec<[f32; 4]>,
    pub(super) texture_resource: Text<'a>,
    pub(super) texture: CompressedImage<'a>,
    pub(super) uv_coordinates: Vec<[f32; 2]>,
    /// Viewers show it for text markers only; here it names the body.
    pub(super) text: Text<'a>,
    pub(super) mesh_resource: Text<'a>,
    pub(super) mesh_file: MeshFile<'a>,
    pub(super) mesh_use_embedded_materials: bool,
}

impl Marker<'_> {
    pub(super) const CUBE: i32 = 1;
    pub(super) const SPHERE: i32 = 2;
    pub(super) const CYLINDER: i32 = 3;
    pub(super) const LINE_STRIP: i32 = 4;
    pub(super) const TRIANGLE_LIST: i32 = 11;
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct CompressedImage<'a> {
    pub(super) header: Header<'a>,
    pub(super) format: Text<'a>,
    pub(super) data: Vec<u8>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct MeshFile<'a> {
    pub(super) filename: Text<'a>,
    pub(super) data: Vec<u8>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct MarkerArray<'a> {
    pub(super) markers: Vec<Marker<'a>>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Log<'a> {
    pub(super) stamp: Time,
    pub(super) level: u8,
    pub(super) name: Text<'a>,
    pub(super) msg: Text<'a>,
    pub(super) file: Text<'a>,
    pub(super) function: Text<'a>,
    pub(super) line: u32,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct DiagnosticArray<'a> {
    pub(super) header: Header<'a>,
    pub(super) status: Vec<DiagnosticStatus<'a>>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct DiagnosticStatus<'a> {
    pub(super) level: u8,
    pub(super) name: Text<'a>,
    pub(super) message: Text<'a>,
    pub(super) hardware_id: Text<'a>,
    pub(super) values: Cow<'a, [(String, String)]>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Contact<'a> {
    pub(super) header: Header<'a>,
    pub(super) body_a: Text<'a>,
    pub(super) body_b: Text<'a>,
    pub(super) depth_m: f64,
    pub(super) normal_force_n: f64,
    pub(super) point: [f64; 3],
    pub(super) normal: [f64; 3],
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Monitor<'a> {
    pub(super) header: Header<'a>,
    pub(super) phase: u32,
    pub(super) tool_error_m: f64,
    pub(super) tool_error_rad: f64,
    pub(super) velocity_ratio: f64,
    pub(super) acceleration_ratio: f64,
    pub(super) jerk_ratio: f64,
    pub(super) torque_ratio: f64,
    pub(super) saturated_joints: u32,
    pub(super) grip_force_n: f64,
    pub(super) opening_m: f64,
    /// No value or one.
    pub(super) clearance_margin_m: Cow<'a, [f64]>,
    pub(super) contacts: u32,
}

/// Every interface that a topic needs, by `package/Type`.
const INTERFACES: [(&str, &str); 27] = [
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"),
    ("builtin_interfaces/Duration", "int32 sec\nuint32 nanosec\n"),
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"),
    ("std_msgs/String", "string data\n"),
    ("std_msgs/ColorRGBA", "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n"),
    (
        "sensor_msgs/JointState",
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n",
    ),
    ("sensor_msgs/CompressedImage", "std_msgs/Header header\nstring format\nuint8[] data\n"),
    ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/Quaternion", "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"),
    ("geometry_msgs/Pose", "Point position\nQuaternion orientation\n"),
    ("geometry_msgs/PoseStamped", "std_msgs/Header header\nPose pose\n"),
    ("geometry_msgs/Twist", "Vector3 linear\nVector3 angular\n"),
    ("geometry_msgs/TwistStamped", "std_msgs/Header header\nTwist twist\n"),
    ("geometry_msgs/Transform", "Vector3 translation\nQuaternion rotation\n"),
    (
        "geometry_msgs/TransformStamped",
        "std_msgs/Header header\nstring child_frame_id\nTransform transform\n",
    ),
    ("tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"),
    ("visualization_msgs/UVCoordinate", "float32 u\nfloat32 v\n"),
    ("visualization_msgs/MeshFile", "string filename\nuint8[] data\n"),
    ("visualization_msgs/Marker", MARKER),
    ("visualization_msgs/MarkerArray", "Marker[] markers\n"),
    ("rcl_interfaces/Log", LOG),
    ("diagnostic_msgs/KeyValue", "string key\nstring value\n"),
    (
        "diagnostic_msgs/DiagnosticStatus",
        "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\nstring message\n\
         string hardware_id\nKeyValue[] values\n",
    ),
    ("diagnostic_msgs/DiagnosticArray", "std_msgs/Header header\nDiagnosticStatus[] status\n"),
    ("graspcheck_msgs/Contact", CONTACT),
    ("graspcheck_msgs/Monitor", MONITOR),
];

const MARKER: &str = "\
int32 ARROW=0
int32 CUBE=1
int32 SPHERE=2
int32 CYLINDER=3
int32 LINE_STRIP=4
int32 LINE_LIST=5
int32 CUBE_LIST=6
int32 SPHERE_LIST=7
int32 POINTS=8
int32 TEXT_VIEW_FACING=9
int32 MESH_RESOURCE=10
int32 TRIANGLE_LIST=11
int32 ADD=0
int32 MODIFY=0
int32 DELETE=2
int32 DELETEALL=3
std_msgs/Header header
string ns
int32 id
int32 type
int32 action
geometry_msgs/Pose pose
geometry_msgs/Vector3 scale
std_msgs/ColorRGBA color
builtin_interfaces/Duration lifetime
bool frame_locked
geometry_msgs/Point[] points
std_msgs/ColorRGBA[] colors
string texture_resource
sensor_msgs/CompressedImage texture
UVCoordinate[] uv_coordinates
string text
string mesh_resource
MeshFile mesh_file
bool mesh_use_embedded_materials
";

const LOG: &str = "\
byte DEBUG=10
byte INFO=20
byte WARN=30
byte ERROR=40
byte FATAL=50
builtin_interfaces/Time stamp
uint8 level
string name
string msg
string file
string function
uint32 line
";

const CONTACT: &str = "\
# One pair of bodies that touch in one step, in alphabetical order; vectors are in the world frame.
std_msgs/Header header
string body_a
string body_b
# Positive when they overlap.
float64 depth_m
# Sum over the contact points of the pair.
float64 normal_force_n
# The deepest contact point.
float64 point_x_m
float64 point_y_m
float64 point_z_m
# Unit vector from a to b.
float64 normal_x
float64 normal_y
float64 normal_z
";

const MONITOR: &str = "\
# Scalars of one step. Ratios are the largest |planned value| / limit over the joints; torque is as
# commanded, before it is limited.
std_msgs/Header header
# Index in plan.json.
uint32 phase
float64 tool_error_m
float64 tool_error_rad
float64 velocity_ratio
float64 acceleration_ratio
float64 jerk_ratio
float64 torque_ratio
uint32 saturated_joints
# The weaker of the two fingers.
float64 grip_force_n
float64 opening_m
# Distance minus required distance, for the pair where that is least; empty when it was not computed.
float64[] clearance_margin_m
# How many messages /contacts has at this stamp.
uint32 contacts
";

/// The schema of a message type `package/msg/Type`: its definition, then each interface it needs once.
///
/// # Panics
/// When the type, or one that it needs, is not in the table. A test builds them all.
pub(super) fn schema(message_type: &str) -> String {
    let root = message_type.replace("/msg/", "/");
    let mut schema = definition(&root).to_owned();
    let mut needed = vec![root];
    let mut next = 0;
    while next < needed.len() {
        for dependency in dependencies(&needed[next]) {
            if !needed.contains(&dependency) {
                schema += &format!("{}\nMSG: {dependency}\n{}", "=".repeat(80), definition(&dependency));
                needed.push(dependency);
            }
        }
        next += 1;
    }
    schema
}

fn definition(interface: &str) -> &'static str {
    let known = INTERFACES.iter().find(|(name, _)| *name == interface);
    known.expect("the table holds every interface that it names").1
}

/// The interfaces of an interface's fields. A name without a package is of the same package; primitives
/// start in lower case.
fn dependencies(interface: &str) -> Vec<String> {
    let package = interface.split('/').next().unwrap_or_default();
    let field_types = definition(interface).lines().filter_map(|line| line.split([' ', '[']).next());
    field_types
        .filter_map(|field_type| match field_type {
            qualified if qualified.contains('/') => Some(qualified.to_owned()),
            local if local.starts_with(char::is_uppercase) => Some(format!("{package}/{local}")),
            _ => None,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mcap::{cdr, topic::Topic};

    #[test]
    fn every_schema_is_complete_and_names_each_interface_once() {
        for topic in Topic::ALL {
            let schema = schema(topic.message_type());
            let parts: Vec<&str> = schema.split(&"=".repeat(80)).collect();
            let mut names: Vec<&str> =
                parts[1..].iter().map(|part| part.trim_start().lines().next().unwrap()).collect();
            names.sort_unstable();
            let count = names.len();
            names.dedup();
            assert_eq!(names.len(), count, "{}", topic.name());
        }
        assert!(schema("geometry_msgs/msg/PoseStamped").contains(
            "================================================================================\n\
             MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
        ));
        assert_eq!(schema("visualization_msgs/msg/MarkerArray").matches("MSG: ").count(), 12);
    }

    #[test]
    fn bytes_are_those_of_the_cdr_rules() {
        let message = JointState {
            header: Header { stamp: Time { sec: 1, nanosec: 2 }, frame_id: "world".into() },
            name: vec!["a".to_owned()].into(),
            position: vec![1.0].into(),
            velocity: vec![].into(),
            effort: vec![].into(),
        };
        let mut bytes = Vec::new();
        cdr::encode(&message, &mut bytes);
        let expected: [&[u8]; 12] = [
            &[0, 1, 0, 0],             // encapsulation
            &[1, 0, 0, 0, 2, 0, 0, 0], // stamp
            &[6, 0, 0, 0],             // length with the final NUL
            b"world\0",
            &[0, 0],       // to a multiple of 4
            &[1, 0, 0, 0], // one name
            b"\x02\0\0\0a\0",
            &[0, 0],       // to a multiple of 4
            &[1, 0, 0, 0], // one position
            &[0, 0, 0, 0], // to a multiple of 8, counted after the encapsulation
            &1.0_f64.to_le_bytes(),
            &[0, 0, 0, 0, 0, 0, 0, 0], // no velocity, no effort
        ];
        let expected = expected.concat();
        assert_eq!(bytes, expected);
    }

    #[test]
    fn a_length_that_lies_is_an_error_and_allocates_nothing_of_that_size() {
        let mut bytes = Vec::new();
        cdr::encode(&StringMessage { data: "robot".into() }, &mut bytes);
        bytes[4..8].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(cdr::decode::<StringMessage>(&bytes).is_err());
        // An array of four thousand million markers in four bytes.
        let array = [0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff];
        assert!(cdr::decode::<MarkerArray>(&array).is_err());
        assert!(cdr::decode::<StringMessage>(&[0, 1]).is_err());
    }

    #[test]
    fn stamps_are_exact_up_to_the_last_nanosecond() {
        for time_ns in [0, 1, 999_999_999, 1_000_000_000, crate::validate::LATEST_NS] {
            assert_eq!(Time::from_ns(time_ns).to_ns(), Some(time_ns));
        }
        assert_eq!(Time { sec: -1, nanosec: 0 }.to_ns(), None);
        assert_eq!(Time { sec: 0, nanosec: 1_000_000_000 }.to_ns(), None);
    }
}
