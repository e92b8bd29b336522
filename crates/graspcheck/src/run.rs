//! The pipeline: one scenario in, one judged recording out.

use graspcheck_model::plan::Plan;
use graspcheck_planner::{Candidate, PlanError, Planned};
use graspcheck_proof::{ProofOutcome, Scene, SceneError};
use graspcheck_recording::{Attachment, Diagnostic, Event, Level, Recording};
use graspcheck_scenario::Scenario;
use graspcheck_sim::SimError;
use graspcheck_verify::{Evidence, EvidenceError, NOT_EXECUTED, Outcome, Verdict, attach, judge};

use crate::{candidates, limit_proofs, markers, report};

/// A run that was carried out and judged. A verdict that fails is a result, not an error.
#[derive(Clone, Debug)]
pub struct Run {
    /// Everything that was recorded, with the verdict inside.
    pub recording: Recording,
    /// The judgement, made from the recording alone.
    pub verdict: Verdict,
    /// The plan that was executed.
    pub plan: Plan,
    /// The ways to do the task that planning looked at, the chosen one first; empty when there was one only.
    pub candidates: Vec<Candidate>,
}

/// Why a scenario could not be run. None of these is a verdict.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// There is no plan for the task.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The bodies of the scenario do not make a scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The simulation cannot be trusted, or could not be set up.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// The recording lacks what the checks read, which is a bug.
    #[error(transparent)]
    Evidence(#[from] EvidenceError),
}

/// A part of the pipeline that is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stage {
    /// The motion is planned.
    Planned {
        /// Phases of the plan.
        phases: usize,
        /// Polynomial pieces of the arm's motion.
        pieces: usize,
        /// Duration of the motion, s.
        duration: f64,
    },
    /// Its clearance is proved or refuted.
    Proved {
        /// How the proof came out.
        outcome: ProofOutcome,
        /// Pairs of bodies that were judged.
        pairs: usize,
        /// Leaves of the proof.
        leaves: usize,
        /// Whether the planner made the proof, as it does where it compares ways to grasp.
        with_the_plan: bool,
    },
    /// It has been executed.
    Simulated {
        /// Simulation steps.
        steps: usize,
        /// Length of a step, s.
        dt: f64,
    },
    /// The recording has been judged.
    Judged {
        /// Checks that were made.
        checks: usize,
    },
}

/// Is told how a run goes on. Wall time is the observer's business: none is measured here.
pub trait Observer {
    /// A stage is done.
    fn done(&mut self, stage: Stage);
    /// The simulation has made `step` of `steps` steps.
    fn simulating(&mut self, step: usize, steps: usize);
}

/// An observer that does nothing.
#[derive(Clone, Copy, Debug)]
pub struct Silent;

impl Observer for Silent {
    fn done(&mut self, _stage: Stage) {}
    fn simulating(&mut self, _step: usize, _steps: usize) {}
}

/// Plans, proves, simulates, records and judges one scenario.
///
/// The verdict is made by [`graspcheck_verify::judge`] from the recording alone, so that the same file
/// gives the same verdict later. A plan that fails its proofs is executed all the same; both verdicts then
/// stand side by side. Where the physics gives up a plan that is refuted, because the object overlaps something
/// at the start or bodies go through each other in one step, every check of the execution says so and is
/// inconclusive.
///
/// # Errors
/// When there is no plan, the scene is not valid, or the simulation cannot be trusted.
pub fn run_scenario(scenario: &Scenario, observer: &mut dyn Observer) -> Result<Run, RunError> {
    let resolved = &scenario.resolved;
    let object = resolved.object.as_ref();
    let Planned { plan, certificate, candidates } =
        graspcheck_planner::find(&resolved.robot, &resolved.cell, object, &resolved.task, &resolved.pace)?;
    observer.done(Stage::Planned {
        phases: plan.phases.len(),
        pieces: plan.trajectory.piece_count(),
        duration: plan.duration(),
    });

    let with_the_plan = certificate.is_some();
    let certificate = match certificate {
        Some(certificate) => certificate,
        None => Scene::new(&resolved.robot, &resolved.cell, object)?.certify(&plan),
    };
    observer.done(Stage::Proved {
        outcome: certificate.outcome(),
        pairs: certificate.pair_count,
        leaves: certificate.leaf_count(),
        with_the_plan,
    });

    let mut recording = match &resolved.execution {
        Some(execution) => {
            let mut steps = 0;
            let executed = graspcheck_sim::simulate(
                &resolved.robot,
                &resolved.cell,
                object,
                &plan,
                execution,
                &mut |step, of| {
                    steps = of;
                    observer.simulating(step, of);
                },
            );
            match executed {
                Ok(recording) => {
                    observer.done(Stage::Simulated { steps, dt: execution.dt });
                    recording
                }
                // What is refuted may be beyond what physics can execute; the verdict says both.
                Err(reason)
                    if certificate.outcome() == ProofOutcome::Violated && is_of_the_motion(&reason) =>
                {
                    not_executed(&plan, &reason)
                }
                Err(error) => return Err(error.into()),
            }
        }
        None => Recording { events: graspcheck_sim::phase_events(&plan), ..Recording::default() },
    };

    attach(&mut recording, resolved, &plan, &certificate);
    recording.attachments.push(limit_proofs::document(resolved, &plan));
    recording.attachments.extend(candidates::document(&candidates));
    recording.attachments.extend(scenario.provenance.iter().map(|document| Attachment {
        name: document.name.clone(),
        media_type: document.media_type.clone(),
        data: document.data.clone(),
    }));
    recording.robot_description = scenario.urdf().to_owned();
    recording.markers = markers::of_run(resolved, &plan);
    describe(&mut recording, scenario);

    let verdict = judge(&Evidence::from_recording(&recording)?);
    observer.done(Stage::Judged {
        checks: verdict.checks.iter().filter(|result| result.outcome != Outcome::NotRequested).count(),
    });
    enter_verdict(&mut recording, &verdict);
    Ok(Run { recording, verdict, plan, candidates })
}

/// Whether a simulation was given up for what the plan does, and not for what the simulation is.
fn is_of_the_motion(error: &SimError) -> bool {
    matches!(error, SimError::StartsInPenetration { .. } | SimError::StepTooLong { .. })
}

/// The recording of a plan that was to be executed and was not.
fn not_executed(plan: &Plan, reason: &SimError) -> Recording {
    let mut recording = Recording { events: graspcheck_sim::phase_events(plan), ..Recording::default() };
    recording.metadata.insert(NOT_EXECUTED.to_owned(), reason.to_string());
    recording
}

/// The record `run`: what ran, in words.
fn describe(recording: &mut Recording, scenario: &Scenario) {
    let resolved = &scenario.resolved;
    let mut enter = |key: &str, value: String| {
        recording.metadata.insert(key.to_owned(), value);
    };
    enter("scenario", resolved.name.clone());
    enter("title", resolved.title.clone());
    enter("robot", resolved.robot.name.clone());
    enter("graspcheck", env!("CARGO_PKG_VERSION").to_owned());
    enter("physics", graspcheck_sim::PHYSICS.to_owned());
    if let Some(execution) = &resolved.execution {
        enter("seed", execution.seed.to_string());
        enter("dt_s", execution.dt.to_string());
        enter("substeps", execution.substeps.to_string());
    }
}

/// Puts the verdict into the recording: as JSON, as one status a check, and as an event at each violation.
fn enter_verdict(recording: &mut Recording, verdict: &Verdict) {
    recording.verdict = Some(verdict.to_json());
    for result in &verdict.checks {
        let level = match result.outcome {
            Outcome::Pass | Outcome::NotRequested => Level::Info,
            Outcome::Inconclusive => Level::Warn,
            Outcome::Fail => Level::Error,
        };
        let message = report::sentence(result);
        let words = report::words(result);
        let values = [
            ("value", words.value),
            ("limit", words.limit),
            ("margin", words.margin),
            ("at", words.at),
            ("where", words.place),
            ("by", words.by.to_owned()),
        ]
        .map(|(name, word)| (name.to_owned(), word));
        if level != Level::Info {
            let t = result.violated.map(|[first, _]| first).or(result.time).unwrap_or(0.0);
            recording.add_event(Event {
                // Rounded to the nanosecond; a run lasts far less than the 292 years that fit.
                time_ns: (t * 1e9).round() as i64,
                level,
                source: result.check.clone(),
                message: message.clone(),
            });
        }
        recording.diagnostics.push(Diagnostic {
            name: result.check.clone(),
            level,
            message,
            values: values.into(),
        });
    }
}
