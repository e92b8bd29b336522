//! Cell files: `extends` puts the tables of another file under those of this one.
//!
//! Tables merge key by key; values and lists replace; lists of tables that all have a `name` merge by it,
//! and `remove = true` drops one. A file has one parent, and at most [`DEEPEST`] stand above a scenario.

use std::path::{Path, PathBuf};

use crate::{
    fault::{Fault, Faults},
    files::{Files, beside, shown},
    tree::{self, Entry, Node, Table, Value},
};

/// How many files may stand above a scenario.
pub(crate) const DEEPEST: usize = 3;

/// A scenario's table merged with those of its parents, and the sources that went into it.
pub(crate) struct Merged {
    pub(crate) table: Table,
    pub(crate) sources: Vec<usize>,
}

/// Reads a scenario and what it extends; none when the scenario itself cannot be read.
pub(crate) fn read(path: &Path, files: &mut Files, faults: &Faults) -> Option<Merged> {
    let mut chain: Vec<PathBuf> = vec![beside(path, &file_name(path))];
    let source = files.read(path, None, faults)?;
    let mut table = tree::parse(&files.sources[source].text, source, faults);
    let mut sources = vec![source];
    let mut link = take_extends(&mut table, faults);
    while let Some((parent, at)) = link {
        let parent_path = beside(&chain[chain.len() - 1], &parent);
        let names = || chain.iter().chain([&parent_path]).map(|p| shown(p)).collect::<Vec<_>>().join(" → ");
        if chain.contains(&parent_path) {
            let title = format!("extends goes in a circle: {}", names());
            faults.report(Fault::new("extends", &at, title, "this file is already part of the chain"));
            break;
        }
        if sources.len() > DEEPEST {
            let title = format!("extends is more than {DEEPEST} deep: {}", names());
            faults.report(Fault::new("extends", &at, title, "merge some of these files"));
            break;
        }
        let Some(source) = files.read(&parent_path, Some(&at), faults) else { break };
        let mut parent_table = tree::parse(&files.sources[source].text, source, faults);
        sources.push(source);
        chain.push(parent_path);
        link = take_extends(&mut parent_table, faults);
        table = merge(parent_table, table, faults);
    }
    drop_removed(&mut table);
    Some(Merged { table, sources })
}

fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

/// Takes the key `extends` out of a table.
fn take_extends(table: &mut Table, faults: &Faults) -> Option<(String, crate::fault::Place)> {
    let entry = table.entries.remove("extends")?;
    let (path, at) = crate::section::text("extends", &entry.node, faults)?;
    Some((path.to_owned(), at.clone()))
}

/// `over` laid upon `under`.
fn merge(mut under: Table, over: Table, faults: &Faults) -> Table {
    under.at = over.at;
    for (key, entry) in over.entries {
        let merged = match under.entries.remove(&key) {
            Some(below) => Entry { key_at: entry.key_at, node: merge_node(below.node, entry.node, faults) },
            None => entry,
        };
        under.entries.insert(key, merged);
    }
    under
}

fn merge_node(under: Node, over: Node, faults: &Faults) -> Node {
    let value = match (under.value, over.value) {
        (Value::Table(below), Value::Table(above)) => Value::Table(merge(below, above, faults)),
        (Value::Array(below), Value::Array(above)) if is_named(&below) && is_named(&above) => {
            Value::Array(merge_named(below, above, faults))
        }
        (_, above) => above,
    };
    Node { at: over.at, value }
}

fn is_named(nodes: &[Node]) -> bool {
    nodes.iter().all(|node| node.name().is_some())
}

/// Elements of the same name merge; others are appended.
fn merge_named(mut below: Vec<Node>, above: Vec<Node>, faults: &Faults) -> Vec<Node> {
    for node in above {
        match below.iter().position(|other| other.name() == node.name()) {
            Some(index) => below[index] = merge_node(below[index].clone(), node, faults),
            None if is_removed(&node) => {
                let name = node.name().unwrap_or_default();
                let title = format!("nothing named `{name}` stands in the file that this one extends");
                faults.report(Fault::new("extends", &node.at, title, "there is nothing to remove"));
            }
            None => below.push(node),
        }
    }
    below
}

/// Drops every element of a named list that says `remove = true`.
fn drop_removed(table: &mut Table) {
    for entry in table.entries.values_mut() {
        match &mut entry.node.value {
            Value::Table(inner) => drop_removed(inner),
            Value::Array(nodes) if is_named(nodes) => nodes.retain(|node| !is_removed(node)),
            _ => {}
        }
    }
}

fn is_removed(node: &Node) -> bool {
    let Value::Table(table) = &node.value else { return false };
    table.entries.get("remove").is_some_and(|entry| entry.node.value == Value::Bool(true))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Table {
        let faults = Faults::default();
        let table = tree::parse(text, 0, &faults);
        assert!(faults.is_empty());
        table
    }

    /// The tree without places, for comparison.
    fn plain(table: &Table) -> String {
        fn write(node: &Node, out: &mut String) {
            match &node.value {
                Value::Table(table) => {
                    out.push('{');
                    for (key, entry) in &table.entries {
                        out.push_str(key);
                        out.push('=');
                        write(&entry.node, out);
                        out.push(' ');
                    }
                    out.push('}');
                }
                Value::Array(nodes) => {
                    out.push('[');
                    for node in nodes {
                        write(node, out);
                        out.push(' ');
                    }
                    out.push(']');
                }
                Value::Text(text) => out.push_str(text),
                Value::Integer(value) => out.push_str(&value.to_string()),
                other => out.push_str(other.kind()),
            }
        }
        let mut out = String::new();
        write(&Node { at: table.at.clone(), value: Value::Table(table.clone()) }, &mut out);
        out
    }

    #[test]
    fn tables_merge_and_values_replace() {
        let faults = Faults::default();
        let over = table("b = 3\n[a]\ny = [4]\nz = 5");
        let merged = merge(table("[a]\nx = 1\ny = [1, 2]"), over, &faults);
        assert_eq!(plain(&merged), "{a={x=1 y=[4 ] z=5 } b=3 }");
    }

    #[test]
    fn named_lists_merge_by_name_and_drop_what_is_removed() {
        let under = table("[[body]]\nname = 'bench'\nx = 1\n[[body]]\nname = 'wall'\nx = 2");
        let over = table(
            "[[body]]\nname = 'wall'\nremove = true\n[[body]]\nname = 'post'\nx = 3\n[[body]]\nname = 'bench'\nx = 4",
        );
        let mut merged = merge(under, over, &Faults::default());
        drop_removed(&mut merged);
        assert_eq!(plain(&merged), "{body=[{name=bench x=4 } {name=post x=3 } ] }");
    }
}
