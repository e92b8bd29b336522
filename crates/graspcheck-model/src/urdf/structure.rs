//! How links and joints hang together: a serial arm whose last link carries two tied fingers.

use std::{
    collections::{BTreeMap, BTreeSet},
    ops::Range,
};

use roxmltree::{Attribute as XmlAttribute, Node};

use super::{
    UrdfFault,
    walk::{named_children, nearest, place, tag_span},
};

/// How the links of an arm hang together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chain {
    /// The link that does not move.
    pub root: String,
    /// The joints of the arm from base to tool; fixed joints are not among them.
    pub arm: Vec<String>,
    /// The joints of the fingers: the driving one, and the one that mimics it.
    pub fingers: [String; 2],
}

/// A joint whose parts of the text are all there.
struct Joint<'a, 'input> {
    node: Node<'a, 'input>,
    name: &'a str,
    fixed: bool,
    prismatic: bool,
    parent: XmlAttribute<'a, 'input>,
    child: XmlAttribute<'a, 'input>,
    mimic: Option<XmlAttribute<'a, 'input>>,
}

impl<'a, 'input> Joint<'a, 'input> {
    fn of(node: Node<'a, 'input>) -> Option<Self> {
        let within = |element, name| named_children(node, element).next()?.attribute_node(name);
        let kind = node.attribute("type")?;
        Some(Self {
            node,
            name: node.attribute("name")?,
            fixed: kind == "fixed",
            prismatic: kind == "prismatic",
            parent: within("parent", "link")?,
            child: within("child", "link")?,
            mimic: within("mimic", "joint"),
        })
    }
}

/// Adds the faults of the structure; gives the chain when there are none.
pub(super) fn check_structure(text: &str, root: Node<'_, '_>, faults: &mut Vec<UrdfFault>) -> Option<Chain> {
    let before = faults.len();
    let links: Vec<Node<'_, '_>> = named_children(root, "link").collect();
    let names: Vec<&str> = links.iter().filter_map(|link| link.attribute("name")).collect();
    check_unique(root, "link", faults);
    check_unique(root, "joint", faults);
    let joints: Vec<Joint<'_, '_>> = named_children(root, "joint").filter_map(Joint::of).collect();
    check_references(&joints, &names, faults);
    if joints.len() < named_children(root, "joint").count() || faults.len() > before {
        return None; // Without all names the tree would only produce faults that follow from these.
    }
    let base = check_tree(text, root, &links, &joints, faults)?;
    check_masses(text, &links, &joints, base, faults);
    let fingers = check_fingers(text, root, &joints, faults);
    let chain = check_chain(text, root, base, &joints, fingers?, faults);
    if faults.len() > before { None } else { chain }
}

/// Every name stands once.
fn check_unique(root: Node<'_, '_>, kind: &'static str, faults: &mut Vec<UrdfFault>) {
    let mut seen = BTreeSet::new();
    for node in named_children(root, kind) {
        let Some(name) = node.attribute_node("name") else { continue };
        if !seen.insert(name.value()) {
            faults.push(UrdfFault {
                span: name.range_value(),
                title: format!("two {kind}s are called {}", name.value()),
                label: "already taken".to_owned(),
                help: None,
            });
        }
    }
}

/// Every link and joint that is named is there, and no link has two parents.
fn check_references(joints: &[Joint<'_, '_>], links: &[&str], faults: &mut Vec<UrdfFault>) {
    let joint_names: Vec<&str> = joints.iter().map(|joint| joint.name).collect();
    let mut parents: BTreeMap<&str, &str> = BTreeMap::new();
    for joint in joints {
        let mut missing = |what: &str, attribute: &XmlAttribute<'_, '_>, known: &[&str]| {
            if !known.contains(&attribute.value()) {
                faults.push(UrdfFault {
                    span: attribute.range_value(),
                    title: format!("joint {}: no {what} {}", joint.name, attribute.value()),
                    label: match nearest(attribute.value(), known) {
                        Some(meant) => format!("did you mean `{meant}`?"),
                        None => format!("no {what} has this name"),
                    },
                    help: None,
                });
            }
        };
        missing("link", &joint.parent, links);
        missing("link", &joint.child, links);
        if let Some(mimic) = &joint.mimic {
            missing("joint", mimic, &joint_names);
        }
        if let Some(other) = parents.insert(joint.child.value(), joint.name) {
            faults.push(UrdfFault {
                span: joint.child.range_value(),
                title: format!(
                    "link {}: moved by joint {other} and by joint {}",
                    joint.child.value(),
                    joint.name
                ),
                label: "already the child of another joint".to_owned(),
                help: None,
            });
        }
    }
}

/// One root, and everything hangs on it. Gives the root's name.
fn check_tree<'a>(
    text: &str,
    robot: Node<'_, '_>,
    links: &[Node<'a, '_>],
    joints: &[Joint<'a, '_>],
    faults: &mut Vec<UrdfFault>,
) -> Option<&'a str> {
    let named = || links.iter().filter_map(|link| Some((*link, link.attribute("name")?)));
    let is_child = |name: &str| joints.iter().any(|joint| joint.child.value() == name);
    let Some((_, base)) = named().find(|(_, name)| !is_child(name)) else {
        faults.push(UrdfFault {
            span: tag_span(text, robot),
            title: format!("{}: no link that does not move", place(robot)),
            label: if links.is_empty() { "has no links" } else { "its links form a loop" }.to_owned(),
            help: None,
        });
        return None;
    };
    let mut reached = BTreeSet::from([base]);
    while let Some(joint) =
        joints.iter().find(|j| reached.contains(j.parent.value()) && !reached.contains(j.child.value()))
    {
        reached.insert(named().map(|(_, name)| name).find(|name| *name == joint.child.value())?);
    }
    let loose: Vec<(Node<'_, '_>, &str)> = named().filter(|(_, name)| !reached.contains(name)).collect();
    for (node, name) in &loose {
        faults.push(UrdfFault {
            span: tag_span(text, *node),
            title: format!("link {name}: does not hang on {base}"),
            label: if is_child(name) { "hangs on a link that is loose itself" } else { "no joint moves it" }
                .to_owned(),
            help: None,
        });
    }
    loose.is_empty().then_some(base)
}

/// Every link that moves has mass, and so has every solid but the base.
fn check_masses(
    text: &str,
    links: &[Node<'_, '_>],
    joints: &[Joint<'_, '_>],
    base: &str,
    faults: &mut Vec<UrdfFault>,
) {
    for link in links {
        let name = link.attribute("name").unwrap_or_default();
        let moved = joints.iter().any(|joint| !joint.fixed && joint.child.value() == name);
        let solid = name != base && named_children(*link, "collision").next().is_some();
        if (moved || solid) && named_children(*link, "inertial").next().is_none() {
            faults.push(UrdfFault {
                span: tag_span(text, *link),
                title: format!("link {name}: no <inertial>"),
                label: if moved {
                    "moves, so it needs mass and inertia"
                } else {
                    "is solid, so it needs mass"
                }
                .to_owned(),
                help: None,
            });
        }
    }
}

/// Two prismatic joints, one mimicking the other. Gives the driving one and the mimic as indices.
fn check_fingers(
    text: &str,
    robot: Node<'_, '_>,
    joints: &[Joint<'_, '_>],
    faults: &mut Vec<UrdfFault>,
) -> Option<[usize; 2]> {
    let mimics: Vec<usize> = (0..joints.len()).filter(|&index| joints[index].mimic.is_some()).collect();
    let mut fault = |span: Range<usize>, title: String, label: &str| {
        faults.push(UrdfFault {
            span,
            title,
            label: label.to_owned(),
            help: Some(
                "the gripper is two prismatic joints on the last link, one mimicking the other".to_owned(),
            ),
        });
        None
    };
    let [follower] = mimics[..] else {
        return match mimics.get(1) {
            None => fault(
                tag_span(text, robot),
                format!("{}: no joint mimics another", place(robot)),
                "has no gripper",
            ),
            Some(&second) => fault(
                tag_span(text, joints[second].node),
                format!("joint {}: a second joint that mimics", joints[second].name),
                "only one finger follows",
            ),
        };
    };
    let target = joints[follower].mimic.as_ref()?.value();
    let driver = joints.iter().position(|joint| joint.name == target)?;
    if driver == follower {
        let title = format!("joint {target}: mimics itself");
        return fault(tag_span(text, joints[follower].node), title, "must name the other finger");
    }
    if let Some(&turning) = [driver, follower].iter().find(|&&finger| !joints[finger].prismatic) {
        let title = format!("joint {}: a finger that is not prismatic", joints[turning].name);
        return fault(tag_span(text, joints[turning].node), title, "must be prismatic");
    }
    Some([driver, follower])
}

/// The other joints form one chain, and the fingers stand on its last link.
fn check_chain(
    text: &str,
    robot: Node<'_, '_>,
    base: &str,
    joints: &[Joint<'_, '_>],
    fingers: [usize; 2],
    faults: &mut Vec<UrdfFault>,
) -> Option<Chain> {
    // The link that carries a link rigidly: itself when a joint moves it, else up its fixed joints.
    let carrier = |link: &str| -> String {
        let mut link = link;
        while let Some(joint) = joints.iter().find(|joint| joint.fixed && joint.child.value() == link) {
            link = joint.parent.value();
        }
        link.to_owned()
    };
    let mut arm: Vec<&Joint<'_, '_>> = Vec::new();
    let mut last = base.to_owned();
    let of_arm = |index: &usize| !joints[*index].fixed && !fingers.contains(index);
    loop {
        let mut next = (0..joints.len()).filter(of_arm).map(|index| &joints[index]);
        let mut next = next.by_ref().filter(|joint| carrier(joint.parent.value()) == last);
        let Some(joint) = next.next() else { break };
        for branch in next {
            faults.push(UrdfFault {
                span: tag_span(text, branch.node),
                title: format!("joint {}: the arm branches at link {last}", branch.name),
                label: format!("joint {} moves on from there already", joint.name),
                help: Some("an arm is a serial chain; extra axes must be fixed joints".to_owned()),
            });
        }
        last = joint.child.value().to_owned();
        arm.push(joint);
    }
    if arm.is_empty() {
        faults.push(UrdfFault {
            span: tag_span(text, robot),
            title: format!("{}: no joint but the fingers moves", place(robot)),
            label: "has no arm".to_owned(),
            help: None,
        });
    }
    for finger in fingers.map(|index| &joints[index]) {
        let on = carrier(finger.parent.value());
        if on != last {
            faults.push(UrdfFault {
                span: finger.parent.range_value(),
                title: format!("joint {}: finger on link {on}, not on {last}", finger.name),
                label: format!("must stand on the last link of the arm, {last}"),
                help: None,
            });
        }
    }
    let moved = |joint: &&Joint<'_, '_>| arm.iter().any(|other| other.name == joint.name);
    for joint in (0..joints.len()).filter(of_arm).map(|index| &joints[index]) {
        let on = carrier(joint.parent.value());
        if !moved(&joint) && fingers.iter().any(|&finger| joints[finger].child.value() == on) {
            faults.push(UrdfFault {
                span: tag_span(text, joint.node),
                title: format!("joint {}: moves on finger {on}", joint.name),
                label: "a finger is the end of the chain".to_owned(),
                help: None,
            });
        }
    }
    Some(Chain {
        root: base.to_owned(),
        arm: arm.iter().map(|joint| joint.name.to_owned()).collect(),
        fingers: fingers.map(|index| joints[index].name.to_owned()),
    })
}
