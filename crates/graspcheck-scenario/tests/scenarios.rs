//! Every scenario of the repository loads without a fault, and what it says is what comes out.

#![expect(clippy::panic, reason = "a helper of a test fails like the test")]

use std::path::{Path, PathBuf};

use graspcheck_model::{Pose, task::Task};
use graspcheck_scenario::{Scenario, find, load};
use graspcheck_verify::{Expectation, Resolved};
use nalgebra::Vector3;

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn scenario(name: &str) -> Scenario {
    load(&repository().join("scenarios").join(name)).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn every_scenario_loads() {
    let listed = find(&repository().join("scenarios")).unwrap();
    assert!(listed.len() >= 10, "only {} scenarios were found", listed.len());
    let mut sorted = listed.clone();
    sorted.sort_by(|a, b| a.name.cmp(&b.name));
    assert_eq!(listed, sorted);
    for one in listed {
        assert!(!one.name.contains("_cells"), "{} is a cell", one.name);
        let scenario = load(&one.path).unwrap_or_else(|error| panic!("{}:\n{error}", one.name));
        assert_eq!(scenario.resolved.name, one.name);
        assert_eq!(scenario.resolved.title, one.title);
        assert!(!one.title.is_empty(), "{} has no title", one.name);
    }
}

#[test]
fn every_negative_scenario_names_what_must_fail() {
    for one in find(&repository().join("scenarios/negative")).unwrap() {
        let expect = load(&one.path).unwrap().resolved.expect;
        let Expectation::Fail(names) = expect else { panic!("{} is expected to pass", one.name) };
        // A full name: `velocity` would be content with the plan's or the execution's alone.
        assert!(names.iter().all(|name| name.contains('.')), "{}: {names:?}", one.name);
    }
}

#[test]
fn resolved_survives_json() {
    for one in find(&repository().join("scenarios")).unwrap() {
        let resolved = load(&one.path).unwrap().resolved;
        let json = serde_json::to_string(&resolved).unwrap();
        let back: Resolved = serde_json::from_str(&json).unwrap();
        assert_eq!(back, resolved, "{}", one.name);
    }
}

#[test]
fn millimetres_and_degrees_end_here() {
    let resolved = scenario("scara/pick_cube.toml").resolved;
    let object = resolved.object.unwrap();
    assert_eq!(object.world_from_object.translation.vector, Vector3::new(0.28, -0.18, 0.015));
    let expected = 20_f64.to_radians();
    let turned = object.world_from_object.rotation.scaled_axis();
    assert!((turned - Vector3::new(0.0, 0.0, expected)).norm() < 1e-15);
    let Task::PickAndPlace(task) = resolved.task else { panic!("not a pick") };
    assert!((task.start[2] + 0.02).abs() < 1e-18, "the quill starts at {} m", task.start[2]);
    assert!((task.start[3] - 314_f64.to_radians()).abs() < 1e-15);
    assert_eq!(task.departure, Vector3::new(0.0, 0.0, 0.06));
    assert!((resolved.checks.place_angle.unwrap() - 1_f64.to_radians()).abs() < 1e-18);
}

#[test]
fn handles_point_at_the_object_and_close_across_it() {
    let object = scenario("scara/pick_cube.toml").resolved.object.unwrap();
    let axes = |pose: &Pose| [pose.rotation * Vector3::x(), pose.rotation * Vector3::y()];
    let close = |a: Vector3<f64>, b: Vector3<f64>| (a - b).norm() < 1e-15;
    let [approach, closing] = axes(&object.handles[0].object_from_handle);
    assert!(close(approach, -Vector3::z()) && close(closing, Vector3::x()));
    let [approach, closing] = axes(&object.handles[1].object_from_handle);
    assert!(close(approach, -Vector3::z()) && close(closing, Vector3::y()));
    assert!((object.handles[0].width - 0.03).abs() < 1e-15);

    let block = scenario("rrr/shelf_top_down.toml").resolved.object.unwrap();
    let [approach, closing] = axes(&block.handles[0].object_from_handle);
    assert!(close(approach, -Vector3::y()) && close(closing, Vector3::x()));
}

#[test]
fn a_child_changes_only_what_it_says() {
    let parent = scenario("scara/pick_over_wall.toml").resolved;
    let child = scenario("negative/planned_collision.toml").resolved;
    assert_eq!(child.robot, parent.robot);
    assert_eq!(child.object, parent.object);
    assert_eq!(child.pace, parent.pace);
    assert_eq!(child.cell.clearance, parent.cell.clearance);
    let changed: Vec<_> = child
        .cell
        .bodies
        .iter()
        .zip(&parent.cell.bodies)
        .filter(|(child, parent)| child != parent)
        .map(|(child, _)| child.name.as_str())
        .collect();
    assert_eq!(changed, ["wall"]);
    assert_eq!(child.cell.bodies.len(), parent.cell.bodies.len());
}

#[test]
fn gravity_follows_the_scenario() {
    let gravity = |name| scenario(name).resolved.cell.gravity;
    assert_eq!(gravity("scara/pick_cube.toml"), Vector3::new(0.0, 0.0, -9.80665));
    assert_eq!(gravity("rrr/pedestal_to_pedestal.toml"), Vector3::new(0.0, 0.0, -9.80665));
    assert_eq!(gravity("rrr/shelf_top_down.toml"), Vector3::new(0.0, -9.80665, 0.0));
}

#[test]
fn provenance_holds_the_files_as_they_are() {
    let scenario = scenario("negative/planned_collision.toml");
    let names: Vec<_> = scenario.provenance.iter().map(|file| file.name.as_str()).collect();
    let expected = [
        "planned_collision.toml",
        "pick_over_wall.toml",
        "bench_with_wall.toml",
        "bench.toml",
        "robot.toml",
        "scara.urdf",
    ];
    assert_eq!(names, expected);
    let urdf = std::fs::read(repository().join("assets/robots/scara/scara.urdf")).unwrap();
    assert_eq!(scenario.provenance[5].data, urdf);
    assert_eq!(scenario.urdf().as_bytes(), urdf);
}

/// Every key that the sources ask a table for stands in the documentation of scenarios or of assets.
#[test]
fn every_key_is_documented() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |path: &str| std::fs::read_to_string(folder.join(path)).unwrap();
    let documented = read("../../scenarios/README.md") + &read("../../assets/README.md");
    let words: Vec<&str> = documented.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').collect();
    // A measure stands there with its unit: `at` as `at_mm`.
    let stands = |key: &str| {
        words
            .iter()
            .any(|word| word.strip_prefix(key).is_some_and(|rest| rest.is_empty() || rest.starts_with('_')))
    };
    let mut missing = Vec::new();
    let mut keys = 0;
    for file in [
        "cell",
        "checks",
        "execution",
        "motion",
        "object",
        "robot_file",
        "scenario",
        "shape",
        "task",
        "via_task",
    ] {
        let source = read(&format!("src/{file}.rs"));
        let source = source.split("#[cfg(test)]").next().unwrap_or_default();
        // Readers are methods of a section whose first argument is the key: `.required_measure("mass", …)`.
        for call in source.split(['.', ' ']).filter(|call| call.contains("(\"")) {
            let (method, rest) = call.split_once("(\"").unwrap();
            let reads = [
                "required", "measure", "text", "flag", "whole", "word", "plain", "section", "vector", "entry",
            ];
            if !reads.iter().any(|read| method.contains(read)) {
                continue;
            }
            let key = rest.split('"').next().unwrap_or_default();
            keys += 1;
            if !stands(key) {
                missing.push(format!("{file}.rs: {key}"));
            }
        }
    }
    assert!(keys > 50, "only {keys} keys were found: the way of reading them has changed");
    assert!(missing.is_empty(), "not in scenarios/README.md or assets/README.md: {missing:?}");
}

#[test]
fn the_example_of_the_documentation_is_the_scenario_itself() {
    let scenarios = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios");
    let documented = std::fs::read_to_string(scenarios.join("README.md")).unwrap();
    let example = std::fs::read_to_string(scenarios.join("scara/pick_cube.toml")).unwrap();
    assert!(documented.contains(example.trim_end()), "paste scara/pick_cube.toml into scenarios/README.md");
}
