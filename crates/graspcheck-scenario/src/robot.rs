//! Finds and loads the robot that a scenario names.

use std::{
    fs,
    path::{Path, PathBuf, absolute},
};

use graspcheck_model::{
    assemble::{AssetFault, FaultPlace},
    robot::RobotModel,
    settings::RobotSettings,
    urdf::{UrdfDocument, UrdfFault, parse},
};

use crate::{
    fault::{Fault, Faults, Place},
    files::{Files, beside, reason, shown},
    robot_file,
    suggest::nearest,
    tree::{self, Table, Value},
};

/// A robot with the sources it came from.
pub(crate) struct LoadedRobot {
    pub(crate) model: RobotModel,
    pub(crate) settings_source: usize,
    pub(crate) urdf_source: usize,
}

/// Loads `assets/robots/<name>` below the nearest folder above `scenario` that has it.
pub(crate) fn load(
    name: &str,
    at: &Place,
    scenario: &Path,
    files: &mut Files,
    faults: &Faults,
) -> Option<LoadedRobot> {
    let Some(folder) = folder_of(name, scenario) else {
        unknown_robot(name, at, scenario, faults);
        return None;
    };
    let settings_path = folder.join("robot.toml");
    let settings_source = files.read(&settings_path, Some(at), faults)?;
    let table = tree::parse(&files.sources[settings_source].text, settings_source, faults);
    let urdf_name = urdf_name(&table);
    let urdf = urdf_name.and_then(|(name, at)| {
        let path = beside(&settings_path, &name);
        Some((path.clone(), files.read(&path, Some(&at), faults)?))
    });
    let document = urdf.as_ref().and_then(|(_, source)| {
        parse(&files.sources[*source].text)
            .map_err(|list| list.into_iter().for_each(|fault| faults.report(urdf_fault(fault, *source))))
            .ok()
    });
    let kind_of = |joint: &str| document.as_ref()?.joint_kind(joint);
    let settings = robot_file::read(&table, &kind_of, faults);
    let (urdf_path, urdf_source) = urdf?;
    let model = assemble(name, &document?, &settings?, &urdf_path).map_err(|list| {
        for fault in list {
            faults.report(asset_fault(fault, &table, settings_source, urdf_source));
        }
    });
    Some(LoadedRobot { model: model.ok()?, settings_source, urdf_source })
}

/// The name of the URDF; faults of this key are reported with those of the others.
fn urdf_name(table: &Table) -> Option<(String, Place)> {
    let node = &table.entries.get("urdf")?.node;
    match &node.value {
        Value::Text(name) => Some((name.clone(), node.at.clone())),
        _ => None,
    }
}

fn assemble(
    name: &str,
    document: &UrdfDocument,
    settings: &RobotSettings,
    urdf: &Path,
) -> Result<RobotModel, Vec<AssetFault>> {
    let mut meshes = |mesh: &str| {
        let path = beside(urdf, mesh);
        fs::read(&path).map_err(|error| format!("cannot read {}: {}", shown(&path), reason(&error)))
    };
    RobotModel::assemble(name, document, settings, &mut meshes)
}

/// The folders above a scenario, nearest first.
fn ancestors(scenario: &Path) -> Vec<PathBuf> {
    // Relative paths stay relative as long as they can, since they are shown to people.
    let mut folders: Vec<PathBuf> = scenario.ancestors().skip(1).map(Path::to_path_buf).collect();
    if scenario.is_relative()
        && let Ok(here) = absolute(".")
    {
        folders.extend(here.ancestors().skip(1).map(Path::to_path_buf));
    }
    folders
}

fn folder_of(name: &str, scenario: &Path) -> Option<PathBuf> {
    // A name is a folder's name, not a path out of the assets.
    if name.is_empty() || !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-') {
        return None;
    }
    ancestors(scenario)
        .into_iter()
        .map(|folder| folder.join("assets/robots").join(name))
        .find(|folder| folder.is_dir())
}

fn unknown_robot(name: &str, at: &Place, scenario: &Path, faults: &Faults) {
    let mut known: Vec<String> = ancestors(scenario)
        .iter()
        .filter_map(|folder| fs::read_dir(folder.join("assets/robots")).ok())
        .flat_map(|entries| entries.filter_map(Result::ok))
        .filter(|entry| entry.path().is_dir())
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    known.sort();
    known.dedup();
    let fault =
        Fault::new("unknown-robot", at, format!("unknown robot `{name}`"), "no such folder in assets/robots");
    faults.report(match nearest(name, known.iter().map(String::as_str)) {
        Some(near) => fault.replace(format!("did you mean \"{near}\"?"), format!("\"{near}\"")),
        None if known.is_empty() => fault.help("no folder above the scenario has assets/robots"),
        None => fault.help(format!("the robots are {}", known.join(", "))),
    });
}

fn urdf_fault(fault: UrdfFault, source: usize) -> Fault {
    let UrdfFault { span, title, label, help } = fault;
    let fault = Fault::new("urdf", &Place { source, span }, title, label);
    match help {
        Some(help) => fault.help(help),
        None => fault,
    }
}

fn asset_fault(fault: AssetFault, settings: &Table, settings_source: usize, urdf_source: usize) -> Fault {
    let AssetFault { title, detail, place, help } = fault;
    let at = match place {
        FaultPlace::Urdf(span) => Place { source: urdf_source, span },
        FaultPlace::Settings(key) => {
            place_of(if key == "world_from_base" { "base" } else { &key }, settings, settings_source)
        }
    };
    let fault = Fault::new("robot", &at, title, detail);
    match help {
        Some(help) => fault.help(help),
        None => fault,
    }
}

/// Where a dotted key such as `joint.elbow.jerk` stands, or as much of it as there is.
fn place_of(key: &str, settings: &Table, source: usize) -> Place {
    let mut at = Place { source, span: 0..0 };
    let mut table = settings;
    for part in key.split('.') {
        // Our keys carry units that the model's do not know.
        let entry =
            table.entries.iter().find(|(key, _)| *key == part || key.starts_with(&format!("{part}_")));
        let Some((_, entry)) = entry else { break };
        at = entry.key_at.clone();
        match &entry.node.value {
            Value::Table(inner) => table = inner,
            _ => break,
        }
    }
    at
}
