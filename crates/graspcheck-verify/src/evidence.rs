//! The evidence that checks read: the documents of a recording, decoded and found to fit together, beside
//! its streams.

use std::sync::OnceLock;

use graspcheck_model::{plan::Plan, robot::Joint};
use graspcheck_proof::{Certificate, LoggedMotion, Scene, SceneError, certificate::CERTIFICATE_SCHEMA};
use graspcheck_recording::{Attachment, Recording};
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use crate::{
    finding::Gap,
    logged,
    resolved::{RESOLVED_SCHEMA, Resolved},
};

/// Name of the attachment that holds [`Resolved`].
pub const RESOLVED_JSON: &str = "resolved.json";
/// Name of the attachment that holds the [`Plan`].
pub const PLAN_JSON: &str = "plan.json";
/// Version of the form of `plan.json`.
pub const PLAN_SCHEMA: u32 = 1;
/// Name of the attachment that holds the [`Certificate`].
pub const CERTIFICATE_JSON: &str = "certificate.json";
/// Name in the record of a run under which stands why a plan was not executed though it should have been.
pub const NOT_EXECUTED: &str = "not_executed";
/// Name under which a verdict travels.
pub const VERDICT_JSON: &str = "verdict.json";

/// Why a recording, or a verdict, cannot be read as evidence.
#[derive(Debug, thiserror::Error)]
pub enum EvidenceError {
    /// A document is not in the recording.
    #[error("{name}: the recording has no such attachment; it was not made by a run of graspcheck")]
    Missing {
        /// Its name.
        name: &'static str,
    },
    /// A document cannot be decoded.
    #[error("{name}: the document cannot be read: {source}")]
    Undecodable {
        /// Its name.
        name: &'static str,
        /// What is wrong, with line and column.
        source: serde_json::Error,
    },
    /// A document has a form that this library does not know.
    #[error("{name}: schema {found} is unknown, this version reads 1 to {known}; {}", advice(*.found))]
    UnknownSchema {
        /// Its name.
        name: &'static str,
        /// Its schema number.
        found: u32,
        /// The newest that is known.
        known: u32,
    },
    /// Two documents, or two parts of one, do not fit together.
    #[error("{name}: {what} is {found}, but must be {expected}")]
    Inconsistent {
        /// The document with the fault.
        name: &'static str,
        /// What does not fit.
        what: String,
        /// What stands there.
        found: String,
        /// What would fit.
        expected: String,
    },
    /// A stream has columns of different lengths.
    #[error("stream {stream}: {column} has {found} values, but {rows} rows need {expected}")]
    Ragged {
        /// The stream.
        stream: &'static str,
        /// Its column.
        column: &'static str,
        /// How many values there are.
        found: usize,
        /// How many rows there are.
        rows: usize,
        /// How many values there must be.
        expected: usize,
    },
}

/// What checks read: a recording, with its documents decoded.
///
/// It is sound to index with: the plan has the robot's joints, phases follow each other over the whole
/// plan, limits are positive, and every stream has full rows. That streams are *there*, finite and
/// complete is for the checks that read them to judge.
#[derive(Clone, Debug)]
pub struct Evidence<'a> {
    /// What the run was asked to be.
    pub resolved: Resolved,
    /// What was executed.
    pub plan: Plan,
    /// The proof that travelled with the plan.
    pub certificate: Certificate,
    /// The streams.
    pub recording: &'a Recording,
    /// The proof as it is found here, made when it is first asked for.
    proof: OnceLock<Result<Proof, SceneError>>,
    /// The executed motion, put together when it is first asked for.
    motion: OnceLock<Result<LoggedMotion, Gap>>,
}

/// The proof of clearance that robot, cell, object and plan give.
#[derive(Clone, Debug)]
pub(crate) struct Proof {
    pub(crate) scene: Scene,
    pub(crate) certificate: Certificate,
}

impl<'a> Evidence<'a> {
    /// The evidence in a recording.
    ///
    /// # Errors
    /// When a document is missing, cannot be decoded, is of a newer form, or does not fit the others, or
    /// when a stream has columns of different lengths.
    pub fn from_recording(recording: &'a Recording) -> Result<Self, EvidenceError> {
        let resolved: Resolved = decode(RESOLVED_JSON, document(recording, RESOLVED_JSON)?, RESOLVED_SCHEMA)?;
        let plan: Plan = decode(PLAN_JSON, document(recording, PLAN_JSON)?, PLAN_SCHEMA)?;
        let certificate: Certificate =
            decode(CERTIFICATE_JSON, document(recording, CERTIFICATE_JSON)?, CERTIFICATE_SCHEMA)?;
        robot_is_sound(&resolved)?;
        plan.check(resolved.robot.dof())
            .map_err(|fault| inconsistent(PLAN_JSON, fault.what, &fault.found, fault.expected))?;
        streams_are_full(recording)?;
        Ok(Self { resolved, plan, certificate, recording, proof: OnceLock::new(), motion: OnceLock::new() })
    }

    /// The proof that is found here; several checks read it, and it is made once.
    pub(crate) fn proof(&self) -> Result<&Proof, Gap> {
        let make = || {
            let Resolved { robot, cell, object, .. } = &self.resolved;
            let scene = Scene::new(robot, cell, object.as_ref())?;
            let certificate = scene.certify(&self.plan);
            Ok(Proof { scene, certificate })
        };
        let made: &Result<Proof, SceneError> = self.proof.get_or_init(make);
        made.as_ref().map_err(|error| Gap::inconclusive(None, error.to_string()))
    }

    /// The executed motion as it was measured.
    pub(crate) fn motion(&self) -> Result<&LoggedMotion, Gap> {
        self.motion.get_or_init(|| logged::motion(self)).as_ref().map_err(Gap::clone)
    }

    /// The joints of the arm, from base to tool.
    #[must_use]
    pub fn joints(&self) -> &[Joint] {
        &self.resolved.robot.joints
    }

    /// The name of the phase at `t`, s; after the plan's end the last.
    #[must_use]
    pub fn phase_name(&self, t: f64) -> &str {
        &self.plan.phase_at(t).name
    }
}

/// Puts the documents that [`Evidence::from_recording`] reads into a recording; older ones are replaced.
pub fn attach(recording: &mut Recording, resolved: &Resolved, plan: &Plan, certificate: &Certificate) {
    recording.attachments.retain(|attachment| {
        ![RESOLVED_JSON, PLAN_JSON, CERTIFICATE_JSON].contains(&attachment.name.as_str())
    });
    for (name, encoded) in [
        (RESOLVED_JSON, serde_json::to_vec_pretty(resolved)),
        (PLAN_JSON, serde_json::to_vec(&Document { schema: PLAN_SCHEMA, content: plan })),
        (CERTIFICATE_JSON, serde_json::to_vec(certificate)),
    ] {
        recording.attachments.push(Attachment {
            name: name.to_owned(),
            media_type: "application/json".to_owned(),
            data: encoded.expect("a tree of structs, strings and numbers has a JSON form"),
        });
    }
}

/// A document with its schema number before its fields.
#[derive(Serialize)]
struct Document<'a, T> {
    schema: u32,
    #[serde(flatten)]
    content: &'a T,
}

/// What to do about an unknown schema.
fn advice(schema: u32) -> &'static str {
    if schema == 0 { "was the document edited?" } else { "use a newer graspcheck" }
}

fn document<'a>(recording: &'a Recording, name: &'static str) -> Result<&'a [u8], EvidenceError> {
    recording
        .attachment(name)
        .map(|attachment| attachment.data.as_slice())
        .ok_or(EvidenceError::Missing { name })
}

fn parse<T: DeserializeOwned>(name: &'static str, data: &[u8]) -> Result<T, EvidenceError> {
    serde_json::from_slice(data).map_err(|source| EvidenceError::Undecodable { name, source })
}

/// The document in `data`, of one of the forms 1 to `known`. The number is read first: a newer form need
/// not decode at all, and the reason must not drown in a message about some field.
pub(crate) fn decode<T: DeserializeOwned>(
    name: &'static str,
    data: &[u8],
    known: u32,
) -> Result<T, EvidenceError> {
    #[derive(Deserialize)]
    struct Head {
        schema: u32,
    }
    let found = parse::<Head>(name, data)?.schema;
    if !(1..=known).contains(&found) {
        return Err(EvidenceError::UnknownSchema { name, found, known });
    }
    parse(name, data)
}

fn inconsistent(
    name: &'static str,
    what: impl Into<String>,
    found: &impl ToString,
    expected: impl Into<String>,
) -> EvidenceError {
    EvidenceError::Inconsistent {
        name,
        what: what.into(),
        found: found.to_string(),
        expected: expected.into(),
    }
}

fn robot_is_sound(resolved: &Resolved) -> Result<(), EvidenceError> {
    if resolved.robot.joints.is_empty() {
        return Err(inconsistent(RESOLVED_JSON, "the number of joints", &0, "at least 1"));
    }
    for joint in &resolved.robot.joints {
        let limits = &joint.limits;
        for (quantity, limit) in [
            ("velocity", limits.velocity),
            ("acceleration", limits.acceleration),
            ("jerk", limits.jerk),
            ("effort", limits.effort),
        ] {
            if !(limit.is_finite() && limit > 0.0) {
                let what = format!("joint {}: the limit of {quantity}", joint.name);
                return Err(inconsistent(RESOLVED_JSON, what, &limit, "positive and finite"));
            }
        }
    }
    if let Some(execution) = &resolved.execution
        && !(execution.dt.is_finite() && execution.dt >= 1e-9)
    {
        return Err(inconsistent(RESOLVED_JSON, "the step dt", &execution.dt, "at least 1e-9 s"));
    }
    Ok(())
}

fn streams_are_full(recording: &Recording) -> Result<(), EvidenceError> {
    let full = |stream, column, found, rows, width| {
        let expected = rows * width;
        if found == expected {
            Ok(())
        } else {
            Err(EvidenceError::Ragged { stream, column, found, rows, expected })
        }
    };
    for (stream, series) in [("measured", &recording.measured), ("reference", &recording.reference)] {
        let (rows, width) = (series.len(), series.names.len());
        full(stream, "position", series.position.len(), rows, width)?;
        full(stream, "velocity", series.velocity.len(), rows, width)?;
        full(stream, "effort", series.effort.len(), rows, width)?;
    }
    for (stream, series) in [
        ("tool", &recording.tool),
        ("reference_tool", &recording.reference_tool),
        ("object", &recording.object),
    ] {
        full(stream, "pose", series.pose.len(), series.time_ns.len(), 1)?;
        full(stream, "twist", series.twist.len(), series.time_ns.len(), 1)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use graspcheck_motion::Trajectory;
    use graspcheck_recording::Recording;

    use super::*;
    use crate::fixture;

    #[test]
    fn what_was_attached_comes_back_to_the_last_bit() {
        let run = fixture::pick();
        let recording = run.written();
        let evidence = Evidence::from_recording(&recording).unwrap();
        assert_eq!(evidence.resolved, run.resolved);
        assert_eq!(evidence.plan, run.plan);
        assert_eq!(evidence.certificate, run.proved());
        assert_eq!(evidence.recording.measured, run.recording.measured);
    }

    #[test]
    fn attaching_again_replaces() {
        let run = fixture::pick();
        let mut recording = run.written();
        attach(&mut recording, &run.resolved, &run.plan, &run.proved());
        assert_eq!(recording, run.written());
        assert_eq!(recording.attachments.len(), 3);
    }

    #[test]
    fn a_missing_document_is_named() {
        assert!(matches!(
            Evidence::from_recording(&Recording::default()),
            Err(EvidenceError::Missing { name: RESOLVED_JSON })
        ));
        for name in [RESOLVED_JSON, PLAN_JSON, CERTIFICATE_JSON] {
            let mut recording = fixture::pick().written();
            recording.attachments.retain(|attachment| attachment.name != name);
            let error = Evidence::from_recording(&recording).unwrap_err();
            assert!(matches!(error, EvidenceError::Missing { name: missing } if missing == name), "{error}");
        }
    }

    /// The pick's recording with a text in one of its documents replaced.
    fn edited(name: &str, from: &str, to: &str) -> Recording {
        let mut recording = fixture::pick().written();
        let document = recording.attachments.iter_mut().find(|attachment| attachment.name == name).unwrap();
        let text = String::from_utf8(document.data.clone()).unwrap();
        assert!(text.contains(from), "{name} has no {from}");
        document.data = text.replacen(from, to, 1).into_bytes();
        recording
    }

    #[test]
    fn a_document_that_cannot_be_read_is_named() {
        for (name, from, to) in [
            (RESOLVED_JSON, "\"lift\"", "lift"),
            (RESOLVED_JSON, "\"schema\": 1", "\"schema\": \"one\""),
            (PLAN_JSON, "\"knots\":[0.0", "\"knots\":[0.5"),
            (CERTIFICATE_JSON, "{", "["),
        ] {
            let recording = edited(name, from, to);
            let error = Evidence::from_recording(&recording).unwrap_err();
            assert!(matches!(error, EvidenceError::Undecodable { name: bad, .. } if bad == name), "{error}");
        }
    }

    #[test]
    fn a_newer_form_is_refused_before_its_fields_are_read() {
        let recording = edited(RESOLVED_JSON, "\"schema\": 1,\n  \"name\"", "\"schema\": 2,\n  \"label\"");
        let error = Evidence::from_recording(&recording).unwrap_err();
        assert_eq!(
            error.to_string(),
            "resolved.json: schema 2 is unknown, this version reads 1 to 1; use a newer graspcheck"
        );
        for (from, to, found) in
            [("\"schema\":1,", "\"schema\":2,", 2), ("\"schema\":1,", "\"schema\":0,", 0)]
        {
            let recording = edited(PLAN_JSON, from, to);
            let error = Evidence::from_recording(&recording).unwrap_err();
            assert!(
                matches!(error, EvidenceError::UnknownSchema { name: PLAN_JSON, found: number, known: 1 } if number == found),
                "{error}"
            );
        }
        let error = Evidence::from_recording(&edited(PLAN_JSON, "\"schema\":1,", "")).unwrap_err();
        assert!(error.to_string().contains("missing field `schema`"), "{error}");
        let recording = edited(CERTIFICATE_JSON, "\"schema\":2", "\"schema\":7");
        assert!(matches!(
            Evidence::from_recording(&recording),
            Err(EvidenceError::UnknownSchema { name: CERTIFICATE_JSON, found: 7, known: 2 })
        ));
    }

    #[test]
    fn documents_that_do_not_fit_each_other_are_refused() {
        let changes: [fn(&mut fixture::Run); 8] = [
            |run| run.plan.trajectory = Trajectory::hold(&[0.0; 3], run.plan.duration()).unwrap(),
            |run| run.plan.opening = Trajectory::hold(&[0.06], 1.0).unwrap(),
            |run| run.plan.opening = Trajectory::hold(&[0.06; 2], run.plan.duration()).unwrap(),
            |run| run.plan.phases.clear(),
            |run| drop(run.plan.phases.remove(3)),
            |run| run.plan.phases[7].end = 100.0,
            |run| run.resolved.robot.joints[1].limits.jerk = 0.0,
            |run| run.resolved.execution.as_mut().unwrap().dt = 0.0,
        ];
        for (index, change) in changes.into_iter().enumerate() {
            let mut run = fixture::pick();
            run.certificate = Some(run.proved());
            change(&mut run);
            let error = run.refused();
            assert!(matches!(error, EvidenceError::Inconsistent { .. }), "change {index}: {error}");
        }
    }

    #[test]
    fn a_stream_with_a_short_column_is_refused() {
        let changes: [fn(&mut Recording); 4] = [
            |recording| recording.measured.effort.truncate(7),
            |recording| recording.reference.names.push("third".into()),
            |recording| recording.tool.twist.truncate(7),
            |recording| recording.object.time_ns.clear(),
        ];
        for change in changes {
            let mut run = fixture::pick();
            change(&mut run.recording);
            assert!(matches!(run.refused(), EvidenceError::Ragged { .. }));
        }
    }
}
