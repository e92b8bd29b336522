//! A small recording with something in every series: a two-joint arm that carries a cube past a wall.

use std::collections::BTreeMap;

use graspcheck_recording::{
    Attachment, ContactSample, Diagnostic, Event, FrameSeries, JointSeries, Level, Marker, MarkerShape,
    MonitorSample, PoseSeries, Recording, recording::PoseRow,
};

const IDENTITY: PoseRow = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// `steps` steps of 1 ms.
pub(crate) fn recording(steps: usize) -> Recording {
    let times: Vec<i64> = (0..steps as i64).map(|step| step * 1_000_000).collect();
    let seconds: Vec<f64> = times.iter().map(|&time_ns| time_ns as f64 * 1e-9).collect();
    let names = ["shoulder".to_owned(), "elbow".to_owned()].to_vec();
    let joints = |offset: f64| JointSeries {
        names: names.clone(),
        time_ns: times.clone(),
        position: seconds.iter().flat_map(|t| [(t + offset).sin(), 0.5 * t.cos()]).collect(),
        velocity: seconds.iter().flat_map(|t| [(t + offset).cos(), -0.5 * t.sin()]).collect(),
        effort: seconds.iter().flat_map(|t| [12.0 * t.sin(), -3.0 * t.cos()]).collect(),
    };
    let pose_at =
        |t: f64| [0.3 + 0.1 * t.cos(), 0.1 * t.sin(), 0.2, 0.0, 0.0, (t / 2.0).sin(), (t / 2.0).cos()];
    let poses = |child: &str| PoseSeries {
        frame: "world".to_owned(),
        child: child.to_owned(),
        time_ns: times.clone(),
        pose: seconds.iter().map(|&t| pose_at(t)).collect(),
        twist: seconds.iter().map(|t| [-0.1 * t.sin(), 0.1 * t.cos(), 0.0, 0.0, 0.0, 1.0]).collect(),
    };
    let frame = |child: &str, time_ns: Vec<i64>| FrameSeries {
        parent: "world".to_owned(),
        child: child.to_owned(),
        pose: time_ns.iter().map(|&time_ns| pose_at(time_ns as f64 * 1e-9)).collect(),
        time_ns,
    };
    Recording {
        metadata: BTreeMap::from([("scenario".to_owned(), "sample::wall".to_owned())]),
        attachments: vec![
            attachment("resolved.json", "application/json", br#"{"schema":1}"#),
            attachment("scenario.toml", "application/toml", b"name = \"wall\"\n"),
        ],
        robot_description: "<robot name=\"sample\"/>".to_owned(),
        measured: joints(1e-4),
        reference: joints(0.0),
        tool: poses("tool"),
        reference_tool: poses("tool"),
        object: poses("cube"),
        contacts: times
            .iter()
            .flat_map(|&time_ns| [contact(time_ns, "finger_a"), contact(time_ns, "finger_b")])
            .collect(),
        monitor: times.iter().map(|&time_ns| monitor(time_ns)).collect(),
        frames: vec![
            frame("link_1", times.iter().copied().step_by(10).collect()),
            frame("base", vec![0]),
            frame("cube", times.iter().copied().step_by(20).collect()),
        ],
        markers: markers(),
        events: vec![
            event(0, Level::Info, "phase", "approach"),
            event(times[steps / 2], Level::Info, "phase", "carry"),
            event(
                times[steps / 2],
                Level::Error,
                "planned.jerk",
                "joint shoulder: jerk 724 rad/s³ exceeds 698 rad/s³",
            ),
        ],
        diagnostics: vec![Diagnostic {
            name: "planned.jerk".to_owned(),
            level: Level::Error,
            message: "exceeds its limit".to_owned(),
            values: vec![("worst".to_owned(), "724 rad/s³".to_owned())],
        }],
        verdict: Some(r#"{"schema":1,"scenario":"sample::wall","outcome":"fail","checks":[]}"#.to_owned()),
    }
}

fn attachment(name: &str, media_type: &str, data: &[u8]) -> Attachment {
    Attachment { name: name.to_owned(), media_type: media_type.to_owned(), data: data.to_vec() }
}

fn contact(time_ns: i64, finger: &str) -> ContactSample {
    ContactSample {
        time_ns,
        body_a: "cube".to_owned(),
        body_b: finger.to_owned(),
        depth_m: 1e-5,
        normal_force_n: 14.7,
        point: [0.3, 0.0, 0.2],
        normal: [0.0, 1.0, 0.0],
    }
}

fn monitor(time_ns: i64) -> MonitorSample {
    MonitorSample {
        time_ns,
        phase: 1,
        tool_error_m: 1.7e-4,
        tool_error_rad: 1e-4,
        velocity_ratio: 0.9,
        acceleration_ratio: 0.8,
        jerk_ratio: 1.04,
        torque_ratio: 0.66,
        saturated_joints: 0,
        grip_force_n: 14.7,
        opening_m: 0.03,
        // Computed at every tenth step.
        clearance_margin_m: (time_ns % 10_000_000 == 0).then_some(0.0019),
        contacts: 2,
    }
}

fn markers() -> Vec<Marker> {
    let marker = |namespace: &str, name: &str, frame: &str, shape| Marker {
        namespace: namespace.to_owned(),
        name: name.to_owned(),
        frame: frame.to_owned(),
        pose: IDENTITY,
        shape,
        color: [0.5, 0.25, 0.125, 1.0],
    };
    vec![
        marker("cell", "wall", "world", MarkerShape::Box { size: [0.2, 0.02, 0.15] }),
        marker("robot", "link_1", "link_1", MarkerShape::Cylinder { radius: 0.03, length: 0.25 }),
        marker("robot", "ball", "base", MarkerShape::Sphere { radius: 0.1 }),
        marker(
            "cell",
            "ramp",
            "world",
            MarkerShape::Triangles { points: vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.05]] },
        ),
        marker(
            "plan",
            "tool path",
            "world",
            MarkerShape::Line { points: vec![[0.4, 0.0, 0.2], [0.3, 0.1, 0.2]], width: 0.002 },
        ),
    ]
}

fn event(time_ns: i64, level: Level, source: &str, message: &str) -> Event {
    Event { time_ns, level, source: source.to_owned(), message: message.to_owned() }
}
