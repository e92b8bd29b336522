//! Dependencies point down: each crate uses only what this table allows, and only crates above it.
//!
//! A new dependency is a line here, where a reader sees what it opens; see ARCHITECTURE.md.

#![expect(clippy::unwrap_used, reason = "helpers of tests: a manifest that cannot be read fails the test")]

use std::{collections::BTreeSet, fs, path::Path};

use toml::Table;

/// A crate, those of ours that it may use, and what it may use of others.
type Allowed = (&'static str, &'static [&'static str], &'static [&'static str]);

const ALLOWED: &[Allowed] = &[
    ("graspcheck-motion", &[], &["serde", "thiserror"]),
    (
        "graspcheck-model",
        &["graspcheck-motion"],
        &["nalgebra", "rand_chacha", "roxmltree", "serde", "stl_io", "strsim", "thiserror", "urdf-rs"],
    ),
    (
        "graspcheck-proof",
        &["graspcheck-motion", "graspcheck-model"],
        &["nalgebra", "parry3d", "serde", "thiserror"],
    ),
    (
        "graspcheck-planner",
        &["graspcheck-motion", "graspcheck-model", "graspcheck-proof"],
        &["nalgebra", "serde", "thiserror"],
    ),
    ("graspcheck-recording", &[], &["byteorder", "cdr-encoding", "mcap", "serde", "thiserror"]),
    (
        "graspcheck-sim",
        &["graspcheck-motion", "graspcheck-model", "graspcheck-proof", "graspcheck-recording"],
        &["differential-equations", "glamx", "nalgebra", "rand_chacha", "rapier3d", "thiserror"],
    ),
    (
        "graspcheck-verify",
        &["graspcheck-motion", "graspcheck-model", "graspcheck-proof", "graspcheck-recording"],
        &["nalgebra", "serde", "serde_json", "thiserror"],
    ),
    (
        "graspcheck-scenario",
        &[
            "graspcheck-motion",
            "graspcheck-model",
            "graspcheck-proof",
            "graspcheck-planner",
            "graspcheck-verify",
        ],
        &["nalgebra", "serde", "strsim", "thiserror", "toml"],
    ),
    (
        "graspcheck-rerun",
        &["graspcheck-model", "graspcheck-recording"],
        &["rerun", "serde", "serde_json", "thiserror"],
    ),
    ("graspcheck-checker", &["graspcheck-recording"], &["serde", "serde_json", "thiserror"]),
    (
        "graspcheck",
        &[
            "graspcheck-motion",
            "graspcheck-model",
            "graspcheck-proof",
            "graspcheck-planner",
            "graspcheck-recording",
            "graspcheck-sim",
            "graspcheck-verify",
            "graspcheck-scenario",
            "graspcheck-rerun",
            "graspcheck-checker",
        ],
        &[
            "annotate-snippets",
            "anstream",
            "anstyle",
            "clap",
            "comfy-table",
            "getrandom",
            "indicatif",
            "libtest-mimic",
            "maud",
            "nalgebra",
            "rustix",
            "serde",
            "serde_json",
            "thiserror",
        ],
    ),
];

/// What one crate alone may know: another crate that names it has taken over a job that is not its own.
const ONLY: &[(&str, &str)] = &[
    ("roxmltree", "graspcheck-model"),
    ("urdf-rs", "graspcheck-model"),
    ("parry3d", "graspcheck-proof"),
    ("mcap", "graspcheck-recording"),
    ("cdr-encoding", "graspcheck-recording"),
    ("rapier3d", "graspcheck-sim"),
    ("toml", "graspcheck-scenario"),
    ("rerun", "graspcheck-rerun"),
    ("clap", "graspcheck"),
    ("anstream", "graspcheck"),
    ("libtest-mimic", "graspcheck"),
];

/// Tools of tests and benches, which any crate may use there.
const TEST_TOOLS: &[&str] =
    &["criterion", "insta", "num-bigint", "num-rational", "proptest", "rsruckig", "serde_json"];

/// The manifests of all crates, by the name of their folder, sorted.
fn manifests() -> Vec<(String, Table)> {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates");
    let mut found: Vec<(String, Table)> = fs::read_dir(crates)
        .unwrap()
        .map(|entry| {
            let folder = entry.unwrap();
            let manifest = fs::read_to_string(folder.path().join("Cargo.toml")).unwrap();
            (folder.file_name().into_string().unwrap(), manifest.parse().unwrap())
        })
        .collect();
    found.sort_by(|a, b| a.0.cmp(&b.0));
    found
}

/// The names in a table of dependencies, also where it is for some targets only.
fn names<'m>(manifest: &'m Table, table: &str) -> Vec<&'m str> {
    let of = |holder: &'m Table| {
        let dependencies = holder.get(table).and_then(toml::Value::as_table);
        dependencies.into_iter().flat_map(|table| table.keys().map(String::as_str))
    };
    let targets = manifest.get("target").and_then(toml::Value::as_table);
    let by_target =
        targets.into_iter().flat_map(|targets| targets.values()).filter_map(toml::Value::as_table);
    of(manifest).chain(by_target.flat_map(of)).collect()
}

/// What a set of manifests does that the tables do not allow, one sentence each.
fn faults(manifests: &[(String, Table)]) -> Vec<String> {
    let mut faults = Vec::new();
    let listed: BTreeSet<&str> = ALLOWED.iter().map(|(name, ..)| *name).collect();
    let there: BTreeSet<&str> = manifests.iter().map(|(name, _)| name.as_str()).collect();
    faults.extend(
        listed.difference(&there).map(|name| format!("{name}: is in the table, but there is no such crate")),
    );
    for (folder, manifest) in manifests {
        let Some((_, ours, others)) = ALLOWED.iter().find(|(name, ..)| name == folder) else {
            faults.push(format!("{folder}: the crate is not in the table"));
            continue;
        };
        let name =
            manifest.get("package").and_then(|package| package.get("name")).and_then(toml::Value::as_str);
        if name != Some(folder) {
            faults.push(format!("{folder}: the folder and the crate {name:?} have different names"));
        }
        let inherits =
            manifest.get("lints").and_then(|lints| lints.get("workspace")).and_then(toml::Value::as_bool);
        if inherits != Some(true) {
            faults.push(format!("{folder}: does not take the lints of the workspace"));
        }
        let allowed = |name: &&str| ours.contains(name) || others.contains(name);
        for name in names(manifest, "dependencies").iter().filter(|name| !allowed(name)) {
            faults.push(format!("{folder}: may not depend on {name}"));
        }
        for name in names(manifest, "dev-dependencies") {
            if !allowed(&name) && !TEST_TOOLS.contains(&name) {
                faults.push(format!("{folder}: may not depend on {name}, not even in tests"));
            }
        }
        for name in names(manifest, "build-dependencies") {
            faults.push(format!("{folder}: may not depend on {name} in a build script; there is none"));
        }
        for (known, by) in ONLY {
            let uses = |table| names(manifest, table).contains(known);
            if folder != by && (uses("dependencies") || uses("dev-dependencies")) {
                faults.push(format!("{folder}: only {by} may know {known}"));
            }
        }
    }
    faults
}

#[test]
fn every_crate_uses_only_what_it_may() {
    let manifests = manifests();
    let faults = faults(&manifests);
    assert!(faults.is_empty(), "\n  {}\n", faults.join("\n  "));
    for (folder, manifest) in &manifests {
        assert!(!names(manifest, "dependencies").is_empty(), "{folder}: no dependency was read");
    }
}

#[test]
fn the_table_itself_points_down() {
    for (index, (name, ours, _)) in ALLOWED.iter().enumerate() {
        for used in *ours {
            assert!(
                ALLOWED[..index].iter().any(|(above, ..)| above == used),
                "{name} may use {used}, which does not stand above it"
            );
        }
    }
    for (known, by) in ONLY {
        let allowing: Vec<&str> =
            ALLOWED.iter().filter(|(_, _, others)| others.contains(known)).map(|(name, ..)| *name).collect();
        assert_eq!(allowing, [*by], "the table lets more than {by} know {known}");
    }
}

#[test]
fn what_is_not_allowed_is_found() {
    let change = |folder: &str, text: &str| {
        let mut manifests = manifests();
        let manifest = &mut manifests.iter_mut().find(|(name, _)| name == folder).unwrap().1;
        for (table, added) in text.parse::<Table>().unwrap() {
            let into = manifest.entry(table).or_insert_with(|| Table::new().into()).as_table_mut().unwrap();
            into.extend(added.as_table().unwrap().clone());
        }
        faults(&manifests)
    };
    for (folder, text, fault) in [
        ("graspcheck-verify", "dependencies.rapier3d = '*'", "may not depend on rapier3d"),
        ("graspcheck-verify", "dev-dependencies.graspcheck-sim = '*'", "not even in tests"),
        (
            "graspcheck-scenario",
            "target.'cfg(unix)'.dependencies.mcap = '*'",
            "only graspcheck-recording may know mcap",
        ),
        ("graspcheck-planner", "build-dependencies.cc = '*'", "in a build script"),
        ("graspcheck-motion", "lints.workspace = false", "does not take the lints"),
        ("graspcheck-motion", "package.name = 'motion'", "different names"),
    ] {
        let faults = change(folder, text);
        assert!(faults.iter().any(|found| found.contains(fault)), "{text} gives {faults:?}");
    }
    let mut unknown = manifests();
    unknown.push(("graspcheck-extra".into(), Table::new()));
    unknown.remove(0);
    assert_eq!(faults(&unknown).len(), 2, "{:?}", faults(&unknown));
}
