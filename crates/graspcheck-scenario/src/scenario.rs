//! A scenario file and everything it names, as one typed value.

use std::path::Path;

use graspcheck_model::{cell::Cell, robot::RobotModel};
use graspcheck_verify::{Resolved, resolved::RESOLVED_SCHEMA};

use crate::{
    cell::{bodies, gravity},
    checks::{checks, expectation},
    execution::execution,
    extends,
    fault::{Fault, Faults, LoadError, Source},
    files::Files,
    find::name_of,
    motion::{Phases, motion, pace, phases},
    object::object,
    robot::{self, LoadedRobot},
    robot_file::schema,
    scene::Scene,
    section::Section,
    task::{JOINT_MOVES, Kind, ReadTask, task, unknown_phase},
};

/// Version of the form of a scenario file.
pub const SCENARIO_SCHEMA: i64 = 1;

/// A scenario without faults.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// What is planned, executed and judged, in SI units, with every default written out.
    pub resolved: Resolved,
    /// The files it was read from, as they were: the scenario, what it extends, `robot.toml`, the URDF. They
    /// travel in the recording for people, and are never parsed again.
    pub provenance: Vec<Provenance>,
    urdf: String,
}

/// A file that a scenario was read from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Provenance {
    /// Its file name, e.g. `pick_cube.toml`; unique in a scenario.
    pub name: String,
    /// Its media type: `application/toml` or `application/xml`.
    pub media_type: String,
    /// Its bytes.
    pub data: Vec<u8>,
}

impl Scenario {
    /// The text of the robot's URDF.
    #[must_use]
    pub fn urdf(&self) -> &str {
        &self.urdf
    }
}

/// Reads the scenario at `path`, what it extends and the robot it names.
///
/// # Errors
/// Every fault of all these files at once.
pub fn load(path: &Path) -> Result<Scenario, LoadError> {
    let faults = Faults::default();
    let mut files = Files::default();
    let loaded = read(path, &mut files, &faults);
    match loaded {
        Some(scenario) if faults.is_empty() => Ok(scenario),
        _ => Err(LoadError { faults: faults.into_sorted(), sources: files.sources }),
    }
}

fn read(path: &Path, files: &mut Files, faults: &Faults) -> Option<Scenario> {
    let merged = extends::read(path, files, faults)?;
    let file = Section::new(&merged.table, "the scenario", "a scenario", faults);
    schema(&file, SCENARIO_SCHEMA);
    let title = file.required_text("title").map(|(title, _)| title.to_owned());
    let seed = match file.has("seed") {
        true => file.whole("seed", 0, i64::MAX).and_then(|seed| u64::try_from(seed).ok()),
        false => Some(0),
    };
    let expect = expectation(&file);
    let robot = file.required_text("robot").and_then(|(name, at)| robot::load(name, at, path, files, faults));
    let model = robot.as_ref().map(|robot| &robot.model);
    let gravity = gravity(&file);
    let bodies = bodies(&file);
    let object = object(&file);
    let phases = phases(&file);
    let task_read = read_task(&file, model, object.name, &phases);
    let motion = motion(&file);
    let execution = execution(&file, model, seed.unwrap_or(0));
    let checks = checks(&file, task_read.kind);
    file.finish();
    let scene = Scene {
        robot: model,
        bodies: bodies.as_deref().unwrap_or(&[]),
        object: object.placed.as_ref(),
        faults,
    };
    scene.check_names();
    if let Some((_, rule)) = &checks {
        scene.check_pairs(&rule.names);
    }
    if let (Some(_), Some(gravity)) = (&bodies, &gravity)
        && !faults.lack_a_part()
    {
        scene.check_support(gravity);
    }
    scene.check_grasp(phases.grip.as_ref());

    let LoadedRobot { model, settings_source, urdf_source } = robot?;
    let (limits, rule) = checks?;
    let object = object.placed.map(|placed| placed.object);
    let resolved = Resolved {
        schema: RESOLVED_SCHEMA,
        name: name_of(path),
        title: title?,
        robot: model,
        cell: Cell {
            gravity: gravity?,
            bodies: bodies?.into_iter().map(|placed| placed.body).collect(),
            clearance: rule.rule,
        },
        object,
        task: task_read.task?,
        pace: pace(&motion, &phases)?,
        execution: execution?,
        checks: limits,
        expect: expect?,
    };
    seed?;
    let mut sources = merged.sources;
    sources.extend([settings_source, urdf_source]);
    let urdf = files.sources[urdf_source].text.clone();
    Some(Scenario { resolved, provenance: provenance(&sources, files), urdf })
}

/// Reads `[task]`, and holds the names of `[phase.NAME]` against the phases that it has.
fn read_task(
    file: &Section<'_>,
    robot: Option<&RobotModel>,
    object: Option<&str>,
    phases: &Phases<'_>,
) -> ReadTask {
    let nothing = ReadTask { kind: None, phases: Vec::new(), task: None };
    let Some(section) = file.required_section("task", "a task") else { return nothing };
    let place = section.place();
    let read = task(section, robot, object, phases.grip.as_ref());
    let Some(kind) = read.kind else { return read };
    for phase in &phases.arm {
        if !read.phases.contains(&phase.pace.phase) {
            unknown_phase(&phase.pace.phase, phase.at, &read.phases, file);
            continue;
        }
        if phase.pace.share.is_some() && matches!(kind, Kind::Via | Kind::JointVia) {
            let title = "via points have times of their own: no share of the limits is used";
            let label = "write `duration_s` to stretch them";
            file.faults().report(Fault::new("timed-phase", phase.at, title, label));
        }
        let is_joint_move = match kind {
            Kind::PickAndPlace => JOINT_MOVES.contains(&phase.pace.phase.as_str()),
            Kind::Segments => true,
            Kind::Via | Kind::JointVia | Kind::Path => false,
        };
        if (phase.pace.law.is_some() || phase.pace.sync.is_some()) && !is_joint_move {
            let title =
                format!("phase `{}` is no joint move: it has no law of time to choose", phase.pace.phase);
            let label = "remove `law` and `sync`".to_owned();
            file.faults().report(Fault::new("no-joint-move", phase.at, title, label));
        }
    }
    if kind != Kind::PickAndPlace {
        for (name, at) in &phases.grip_at {
            unknown_phase(name, at, &read.phases, file);
        }
    } else if !phases.mentions_force {
        let title = "missing key `force_n` in [phase.close]";
        file.faults().report(Fault::new(
            "missing-key",
            place,
            title,
            "this task grasps: add the force of each finger",
        ));
    }
    read
}

/// The files as they were, each under a name of its own.
fn provenance(sources: &[usize], files: &Files) -> Vec<Provenance> {
    let mut list: Vec<Provenance> = Vec::new();
    for &index in sources {
        let Source { path, text } = &files.sources[index];
        let mut name = path.rsplit('/').next().unwrap_or(path).to_owned();
        // Files of the same name from other folders take the folder's name along.
        let mut folders = path.rsplit('/').skip(1);
        while list.iter().any(|other| other.name == name) {
            name = format!("{}-{name}", folders.next().unwrap_or("again"));
        }
        let kind = if name.ends_with(".toml") { "toml" } else { "xml" };
        let media_type = format!("application/{kind}");
        list.push(Provenance { name, media_type, data: text.clone().into_bytes() });
    }
    list
}
