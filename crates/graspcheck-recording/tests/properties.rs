//! Laws of the file format on random recordings and random damage.

use std::collections::BTreeMap;

use graspcheck_recording::{
    Attachment, ContactSample, Diagnostic, Event, FrameSeries, JointSeries, Level, Marker, MarkerShape,
    MonitorSample, PoseSeries, Recording, from_bytes, to_bytes,
};
use proptest::{array, collection::vec, prelude::*};

/// Any finite number, also huge, tiny and negative zero; diameters are formed of some.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![any::<f64>(), -10.0..10.0].prop_filter("finite", |value| (2.0 * value).is_finite())
}

/// Text with quotes, line ends, NUL and letters beyond ASCII.
fn text() -> impl Strategy<Value = String> {
    prop_oneof![Just(String::new()), "[a-z_]{1,8}", ".{0,6}", Just("a\0\"\n∅".to_owned())]
}

/// Times that increase strictly, up to the last one that a stamp can say.
fn times() -> impl Strategy<Value = Vec<i64>> {
    vec(prop_oneof![0..5_000_000_i64, 0..2_147_483_648_000_000_000_i64], 0..6).prop_map(|mut times| {
        times.sort_unstable();
        times.dedup();
        times
    })
}

fn joints() -> impl Strategy<Value = JointSeries> {
    (vec(text(), 0..4), times()).prop_flat_map(|(names, time_ns)| {
        let count = names.len() * time_ns.len();
        let values = || vec(number(), count);
        (values(), values(), values()).prop_map(move |(position, velocity, effort)| JointSeries {
            names: names.clone(),
            time_ns: time_ns.clone(),
            position,
            velocity,
            effort,
        })
    })
}

fn pose() -> impl Strategy<Value = [f64; 7]> {
    array::uniform7(number())
}

fn point() -> impl Strategy<Value = [f64; 3]> {
    array::uniform3(number())
}

fn poses() -> impl Strategy<Value = PoseSeries> {
    (text(), text(), times()).prop_flat_map(|(frame, child, time_ns)| {
        let rows = time_ns.len();
        (vec(pose(), rows), vec(array::uniform6(number()), rows)).prop_map(move |(pose, twist)| PoseSeries {
            frame: frame.clone(),
            child: child.clone(),
            time_ns: time_ns.clone(),
            pose,
            twist,
        })
    })
}

fn frames() -> impl Strategy<Value = Vec<FrameSeries>> {
    vec((text(), times(), pose()), 0..4).prop_map(|frames| {
        frames
            .into_iter()
            .enumerate()
            .map(|(index, (parent, time_ns, pose))| FrameSeries {
                parent,
                child: format!("frame {index}"),
                pose: vec![pose; time_ns.len()],
                time_ns,
            })
            .collect()
    })
}

fn shape() -> impl Strategy<Value = MarkerShape> {
    prop_oneof![
        point().prop_map(|size| MarkerShape::Box { size }),
        number().prop_map(|radius| MarkerShape::Sphere { radius }),
        (number(), number()).prop_map(|(radius, length)| MarkerShape::Cylinder { radius, length }),
        vec(array::uniform3(point()), 0..3)
            .prop_map(|triangles| MarkerShape::Triangles { points: triangles.concat() }),
        (vec(point(), 2..5), number()).prop_map(|(points, width)| MarkerShape::Line { points, width }),
    ]
}

fn markers() -> impl Strategy<Value = Vec<Marker>> {
    let marker = (text(), text(), text(), pose(), shape(), array::uniform4(0.0..=1.0_f32));
    vec(
        marker.prop_map(|(namespace, name, frame, pose, shape, color)| Marker {
            namespace,
            name,
            frame,
            pose,
            shape,
            color,
        }),
        0..4,
    )
}

fn level() -> impl Strategy<Value = Level> {
    prop_oneof![Just(Level::Info), Just(Level::Warn), Just(Level::Error)]
}

fn events() -> impl Strategy<Value = Vec<Event>> {
    let event = (0..20_i64, level(), text(), text());
    vec(event.prop_map(|(time_ns, level, source, message)| Event { time_ns, level, source, message }), 0..6)
        .prop_map(|mut events| {
            events.sort_by_key(|event| event.time_ns);
            events
        })
}

fn contacts() -> impl Strategy<Value = Vec<ContactSample>> {
    let contact = (0..20_i64, text(), text(), [number(), number()], [point(), point()]);
    vec(
        contact.prop_map(|(time_ns, body_a, body_b, [depth_m, normal_force_n], [point, normal])| {
            ContactSample { time_ns, body_a, body_b, depth_m, normal_force_n, point, normal }
        }),
        0..6,
    )
    .prop_map(|mut contacts| {
        contacts.sort_by_key(|contact| contact.time_ns);
        contacts
    })
}

fn monitor() -> impl Strategy<Value = Vec<MonitorSample>> {
    (times(), array::uniform9(number()), any::<[u32; 2]>()).prop_map(|(times, values, counts)| {
        let sample = |time_ns| MonitorSample {
            time_ns,
            phase: counts[0],
            tool_error_m: values[0],
            tool_error_rad: values[1],
            velocity_ratio: values[2],
            acceleration_ratio: values[3],
            jerk_ratio: values[4],
            torque_ratio: values[5],
            saturated_joints: counts[1],
            grip_force_n: values[6],
            opening_m: values[7],
            clearance_margin_m: (counts[0] % 2 == 0).then_some(values[8]),
            contacts: counts[0],
        };
        times.into_iter().map(sample).collect()
    })
}

fn attachments() -> impl Strategy<Value = Vec<Attachment>> {
    vec((text(), vec(any::<u8>(), 0..40)), 0..3).prop_map(|documents| {
        let named =
            |(index, (media_type, data))| Attachment { name: format!("{index}.json"), media_type, data };
        documents.into_iter().enumerate().map(named).collect()
    })
}

fn diagnostics() -> impl Strategy<Value = Vec<Diagnostic>> {
    let diagnostic = (text(), level(), text(), vec((text(), text()), 0..3));
    vec(
        diagnostic.prop_map(|(name, level, message, values)| Diagnostic { name, level, message, values }),
        0..3,
    )
}

fn metadata() -> impl Strategy<Value = BTreeMap<String, String>> {
    proptest::collection::btree_map(text(), text(), 0..4)
}

fn recording() -> impl Strategy<Value = Recording> {
    let series = (joints(), joints(), poses(), poses(), poses());
    let samples = (contacts(), monitor(), frames(), markers(), events());
    let texts = (metadata(), attachments(), text(), diagnostics(), proptest::option::of(text()));
    (series, samples, texts).prop_map(|(series, samples, texts)| {
        let (measured, reference, tool, reference_tool, object) = series;
        let (contacts, monitor, frames, markers, events) = samples;
        let (metadata, attachments, robot_description, diagnostics, verdict) = texts;
        Recording {
            metadata,
            attachments,
            robot_description,
            measured,
            reference,
            tool,
            reference_tool,
            object,
            contacts,
            monitor,
            frames,
            markers,
            events,
            diagnostics,
            verdict,
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn what_was_written_is_read(recording in recording()) {
        let bytes = to_bytes(&recording).unwrap();
        prop_assert_eq!(&from_bytes(&bytes).unwrap(), &recording);
        // Also where equality does not look: the sign of zero.
        prop_assert_eq!(to_bytes(&from_bytes(&bytes).unwrap()).unwrap(), bytes);
    }

    #[test]
    fn damage_is_an_error_and_never_a_panic(
        recording in recording(),
        damage in vec((any::<prop::sample::Index>(), any::<u8>()), 1..20),
        cut in proptest::option::of(any::<prop::sample::Index>()),
    ) {
        let intact = to_bytes(&recording).unwrap();
        let mut bytes = intact.clone();
        for (place, value) in damage {
            let place = place.index(bytes.len());
            bytes[place] = value;
        }
        if let Some(length) = cut {
            bytes.truncate(length.index(bytes.len()));
        }
        prop_assert_eq!(from_bytes(&bytes).is_ok(), bytes == intact);
    }

    #[test]
    fn noise_after_the_magic_bytes_is_an_error(noise in vec(any::<u8>(), 0..300)) {
        prop_assert!(from_bytes(&[b"\x89MCAP0\r\n", &noise[..]].concat()).is_err());
    }
}
