//! The streams and attachments of one run, in memory.

use std::collections::BTreeMap;

/// A pose as position and unit quaternion: `[x, y, z, qx, qy, qz, qw]`, m.
pub type PoseRow = [f64; 7];

/// Everything that was recorded of one run.
///
/// Rows of a series are in order of time. What a run did not have (an object, contacts) is empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// The record `run`: scenario, robot, seed, versions and hashes, by name.
    pub metadata: BTreeMap<String, String>,
    /// Documents that travel with the run: `resolved.json`, `plan.json`, `certificate.json`, and as
    /// provenance the scenario and the URDF.
    pub attachments: Vec<Attachment>,
    /// The robot as URDF text, for viewers; empty when there is none.
    pub robot_description: String,
    /// Measured joint states, arm and fingers, with the efforts that were applied.
    pub measured: JointSeries,
    /// Commanded joint states, with the efforts that the controller asked for before they were limited.
    pub reference: JointSeries,
    /// Measured pose and twist of the tool frame in the world.
    pub tool: PoseSeries,
    /// Commanded pose and twist of the tool frame in the world.
    pub reference_tool: PoseSeries,
    /// Pose and twist of the object in the world.
    pub object: PoseSeries,
    /// Contacts that carried a force or penetrated, one row for each pair and step.
    pub contacts: Vec<ContactSample>,
    /// Scalars for plots, one row a step.
    pub monitor: Vec<MonitorSample>,
    /// Moving frames, at a lower rate, for viewers.
    pub frames: Vec<FrameSeries>,
    /// Solids and lines for viewers, each in a frame.
    pub markers: Vec<Marker>,
    /// Phases, findings and other things that happen at an instant.
    pub events: Vec<Event>,
    /// One status for each check, written at the end.
    pub diagnostics: Vec<Diagnostic>,
    /// The verdict as JSON, when the run has been judged.
    pub verdict: Option<String>,
}

/// A document inside the recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attachment {
    /// Its file name, e.g. `plan.json`.
    pub name: String,
    /// Its media type, e.g. `application/json`.
    pub media_type: String,
    /// Its bytes.
    pub data: Vec<u8>,
}

/// States of several joints over time. The value of joint `j` in row `i` is at `i * names.len() + j`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointSeries {
    /// Names of the joints; the order never changes.
    pub names: Vec<String>,
    /// Times, ns.
    pub time_ns: Vec<i64>,
    /// Positions, rad or m.
    pub position: Vec<f64>,
    /// Velocities, rad/s or m/s.
    pub velocity: Vec<f64>,
    /// Efforts, N·m or N.
    pub effort: Vec<f64>,
}

/// A pose and its twist over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseSeries {
    /// The frame in which the pose is given; empty when the series is.
    pub frame: String,
    /// What has this pose, e.g. `cube`.
    pub child: String,
    /// Times, ns.
    pub time_ns: Vec<i64>,
    /// Poses, one a row.
    pub pose: Vec<PoseRow>,
    /// Linear then angular velocity in `frame`, m/s and rad/s, one a row.
    pub twist: Vec<[f64; 6]>,
}

/// One contact between two bodies in one step.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactSample {
    /// Time, ns.
    pub time_ns: i64,
    /// Name of one body; the pair is in alphabetical order.
    pub body_a: String,
    /// Name of the other.
    pub body_b: String,
    /// How deep they overlap, m; negative while they are apart.
    pub depth_m: f64,
    /// Sum of the normal forces of all contact points, N.
    pub normal_force_n: f64,
    /// The deepest contact point in the world, m.
    pub point: [f64; 3],
    /// Unit normal from a to b in the world.
    pub normal: [f64; 3],
}

/// Scalars of one step, for plots, and the number of contacts that belong to it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MonitorSample {
    /// Time, ns.
    pub time_ns: i64,
    /// Index of the phase in `plan.json`.
    pub phase: u32,
    /// Distance between the measured and the commanded tool origin, m.
    pub tool_error_m: f64,
    /// Angle between the measured and the commanded tool orientation, rad.
    pub tool_error_rad: f64,
    /// Largest |planned velocity| / limit over the joints.
    pub velocity_ratio: f64,
    /// Largest |planned acceleration| / limit over the joints.
    pub acceleration_ratio: f64,
    /// Largest |planned jerk| / limit over the joints.
    pub jerk_ratio: f64,
    /// Largest |commanded effort| / limit over the joints, before the command is limited.
    pub torque_ratio: f64,
    /// Joints whose command was limited in this step.
    pub saturated_joints: u32,
    /// Smaller of the two normal forces between finger and object, N; 0 without contact.
    pub grip_force_n: f64,
    /// Measured opening of the gripper, m.
    pub opening_m: f64,
    /// Distance of the pair that is nearest to its required clearance, minus that requirement, at the
    /// measured positions, m; none at a step at which it was not computed. For plots only, checks compute
    /// their own.
    pub clearance_margin_m: Option<f64>,
    /// How many rows of [`Recording::contacts`] this step has: a log that has lost some is found out.
    pub contacts: u32,
}

/// A moving frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameSeries {
    /// Name of the frame it moves in.
    pub parent: String,
    /// Name of the frame.
    pub child: String,
    /// Times, ns; a single row for a frame that does not move.
    pub time_ns: Vec<i64>,
    /// Poses of the child in the parent.
    pub pose: Vec<PoseRow>,
}

/// A solid or line for viewers.
#[derive(Clone, Debug, PartialEq)]
pub struct Marker {
    /// Group: `cell`, `robot`, `object`, `plan`.
    pub namespace: String,
    /// Name of the body or of the line.
    pub name: String,
    /// Frame it is fixed to.
    pub frame: String,
    /// Pose in that frame.
    pub pose: PoseRow,
    /// What it looks like.
    pub shape: MarkerShape,
    /// Red, green, blue, opacity, each 0 to 1.
    pub color: [f32; 4],
}

/// What a marker looks like, lengths in m.
#[derive(Clone, Debug, PartialEq)]
pub enum MarkerShape {
    /// Full lengths along x, y, z.
    Box {
        /// Full lengths, m.
        size: [f64; 3],
    },
    /// A ball.
    Sphere {
        /// Radius, m.
        radius: f64,
    },
    /// A cylinder along z.
    Cylinder {
        /// Radius, m.
        radius: f64,
        /// Full length, m.
        length: f64,
    },
    /// Triangles, three points each.
    Triangles {
        /// Corners, m.
        points: Vec<[f64; 3]>,
    },
    /// A polyline; at least two points.
    Line {
        /// Points, m.
        points: Vec<[f64; 3]>,
        /// Width, m.
        width: f64,
    },
}

/// How grave an event is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// As planned.
    Info,
    /// Worth a look.
    Warn,
    /// Violates something.
    Error,
}

/// Something that happened at an instant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Event {
    /// When, ns.
    pub time_ns: i64,
    /// How grave.
    pub level: Level,
    /// What it is about: `phase` or the code of a check.
    pub source: String,
    /// A sentence.
    pub message: String,
}

/// The status of one check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Code of the check.
    pub name: String,
    /// Pass is `Info`, inconclusive `Warn`, fail `Error`.
    pub level: Level,
    /// A sentence.
    pub message: String,
    /// Worst value, limit, time and place, as text by name.
    pub values: Vec<(String, String)>,
}

impl JointSeries {
    /// An empty series of these joints.
    #[must_use]
    pub fn new(names: Vec<String>) -> Self {
        Self { names, ..Self::default() }
    }

    /// The number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time_ns.len()
    }

    /// Whether there is no row.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time_ns.is_empty()
    }

    /// The positions of all joints in one row.
    ///
    /// # Panics
    /// When `row` is out of range.
    #[must_use]
    pub fn position_row(&self, row: usize) -> &[f64] {
        &self.position[row * self.names.len()..(row + 1) * self.names.len()]
    }

    /// The velocities of all joints in one row.
    ///
    /// # Panics
    /// When `row` is out of range.
    #[must_use]
    pub fn velocity_row(&self, row: usize) -> &[f64] {
        &self.velocity[row * self.names.len()..(row + 1) * self.names.len()]
    }

    /// The efforts of all joints in one row.
    ///
    /// # Panics
    /// When `row` is out of range.
    #[must_use]
    pub fn effort_row(&self, row: usize) -> &[f64] {
        &self.effort[row * self.names.len()..(row + 1) * self.names.len()]
    }
}

impl Recording {
    /// The attachment with this name.
    #[must_use]
    pub fn attachment(&self, name: &str) -> Option<&Attachment> {
        self.attachments.iter().find(|attachment| attachment.name == name)
    }

    /// Adds an event at its place in time, after those of the same instant.
    pub fn add_event(&mut self, event: Event) {
        let place = self.events.partition_point(|earlier| earlier.time_ns <= event.time_ns);
        self.events.insert(place, event);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_are_added_in_order_of_time() {
        let mut recording = Recording::default();
        for (time_ns, message) in [(5, "c"), (0, "a"), (5, "d"), (2, "b")] {
            let source = "phase".to_owned();
            recording.add_event(Event { time_ns, level: Level::Info, source, message: message.to_owned() });
        }
        let messages: Vec<&str> = recording.events.iter().map(|event| &*event.message).collect();
        assert_eq!(messages, ["a", "b", "c", "d"]);
    }
}
