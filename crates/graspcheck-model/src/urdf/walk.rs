//! The form of a URDF: elements, attributes and numbers against the schema.

use std::ops::Range;

use roxmltree::{Attribute as XmlAttribute, Node};

use super::{
    UrdfFault,
    schema::{Attribute, Count, Element, ROBOT, Sign, Value},
};

/// Nothing, when the document is a robot.
pub(super) fn check_root(text: &str, root: Node<'_, '_>) -> Result<(), UrdfFault> {
    let name = root.tag_name().name();
    if name == ROBOT.name {
        return Ok(());
    }
    Err(UrdfFault {
        span: name_span(text, root),
        title: format!("the document is <{name}>, not <robot>"),
        label: "must be `robot`".to_owned(),
        help: None,
    })
}

/// Adds the faults of form of the whole document.
pub(super) fn check_form(text: &str, root: Node<'_, '_>, faults: &mut Vec<UrdfFault>) {
    check_element(text, root, &ROBOT, faults);
}

fn check_element(text: &str, node: Node<'_, '_>, rule: &'static Element, faults: &mut Vec<UrdfFault>) {
    check_attributes(text, node, rule, faults);
    for child in node.children() {
        if child.is_element() {
            match rule.children.iter().find(|known| is_named(node, child, known.element.name)) {
                Some(known) => {
                    let first = named_children(node, known.element.name).next();
                    if known.count != Count::Any && first != Some(child) {
                        faults.push(UrdfFault {
                            span: tag_span(text, child),
                            title: format!("{}: second <{}>", place(child), known.element.name),
                            label: format!("only one may stand in <{}>", rule.name),
                            help: None,
                        });
                    }
                    check_element(text, child, known.element, faults);
                }
                None => faults.push(unknown_element(text, child, rule)),
            }
        } else if child.is_text() && child.text().is_some_and(|content| !content.trim().is_empty()) {
            faults.push(UrdfFault {
                span: child.range(),
                title: format!("{}: text in <{}>", place(node), rule.name),
                label: "a URDF says everything in attributes".to_owned(),
                help: None,
            });
        }
    }
    for known in rule.children.iter().filter(|known| known.count == Count::Once) {
        if named_children(node, known.element.name).next().is_none() {
            faults.push(UrdfFault {
                span: tag_span(text, node),
                title: format!("{}: <{}> has no <{}>", place(node), rule.name, known.element.name),
                label: format!("needs <{}>", known.element.name),
                help: None,
            });
        }
    }
}

fn unknown_element(text: &str, node: Node<'_, '_>, parent: &Element) -> UrdfFault {
    let (name, owner) = (&text[name_span(text, node)], node.parent_element().unwrap_or(node));
    let known: Vec<&str> = parent.children.iter().map(|child| child.element.name).collect();
    UrdfFault {
        span: name_span(text, node),
        title: format!("{}: unknown element <{name}> in <{}>", place(owner), parent.name),
        label: match nearest(name, &known) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => "not read by graspcheck".to_owned(),
        },
        help: Some(match known[..] {
            [] => format!("<{}> has no children", parent.name),
            _ => format!("<{}> may hold {}", parent.name, known.join(", ")),
        }),
    }
}

fn check_attributes(text: &str, node: Node<'_, '_>, rule: &Element, faults: &mut Vec<UrdfFault>) {
    for attribute in node.attributes() {
        match rule.attributes.iter().find(|known| known.name == attribute.name()) {
            Some(known) => faults.extend(value_fault(node, &attribute, known)),
            None => faults.push(unknown_attribute(node, &attribute, rule)),
        }
    }
    for known in rule.attributes.iter().filter(|known| known.required) {
        if node.attribute(known.name).is_none() {
            faults.push(UrdfFault {
                span: tag_span(text, node),
                title: format!("{}: <{}> has no `{}`", place(node), rule.name, known.name),
                label: format!("needs `{}`", known.name),
                help: None,
            });
        }
    }
}

fn unknown_attribute(node: Node<'_, '_>, attribute: &XmlAttribute<'_, '_>, rule: &Element) -> UrdfFault {
    let name = attribute.name();
    if rule.name == "limit" && ["acceleration", "deceleration", "jerk"].contains(&name) {
        return UrdfFault {
            span: attribute.range_qname(),
            title: format!("{}: limit of {name} in a URDF", place(node)),
            label: "belongs in robot.toml".to_owned(),
            help: Some("limits of acceleration and jerk stand in robot.toml only; remove it here".to_owned()),
        };
    }
    let known: Vec<&str> = rule.attributes.iter().map(|known| known.name).collect();
    UrdfFault {
        span: attribute.range_qname(),
        title: format!("{}: unknown attribute `{name}` of <{}>", place(node), rule.name),
        label: match nearest(name, &known) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => "not read by graspcheck".to_owned(),
        },
        help: Some(match known[..] {
            [] => format!("<{}> has no attributes", rule.name),
            _ => format!("<{}> may have {}", rule.name, known.join(", ")),
        }),
    }
}

/// What is wrong with the text of an attribute.
fn value_fault(node: Node<'_, '_>, attribute: &XmlAttribute<'_, '_>, rule: &Attribute) -> Option<UrdfFault> {
    let fault = |fact: String, label: String| UrdfFault {
        span: attribute.range_value(),
        title: format!("{}: {} {fact}", place(node), rule.name),
        label,
        help: None,
    };
    let value = attribute.value();
    let Value::Numbers(count, sign) = rule.value else {
        return value.trim().is_empty().then(|| fault("is empty".to_owned(), "needs a value".to_owned()));
    };
    let words: Vec<&str> = value.split_whitespace().collect();
    for word in &words {
        let number: f64 = match word.parse() {
            Ok(number) => number,
            Err(_) => {
                return Some(fault(format!("\"{value}\""), format!("`{word}` is not a number")));
            }
        };
        let allowed = match sign {
            Sign::Any => true,
            Sign::Positive => number > 0.0,
            Sign::NotNegative => number >= 0.0,
        };
        if !number.is_finite() {
            return Some(fault(format!("\"{value}\""), format!("`{word}` is not finite")));
        }
        if !allowed {
            let wanted = if sign == Sign::Positive { "must be positive" } else { "must not be negative" };
            return Some(fault(format!("\"{value}\" {wanted}"), wanted.to_owned()));
        }
    }
    let plural = if count == 1 { "number" } else { "numbers" };
    (words.len() != count)
        .then(|| fault(format!("\"{value}\""), format!("takes {count} {plural}, has {}", words.len())))
}

/// The numbers of an attribute, when it is there and has the right form.
pub(super) fn numbers<const N: usize>(node: Node<'_, '_>, name: &str) -> Option<[f64; N]> {
    let words = node.attribute(name)?.split_whitespace();
    let values: Option<Vec<f64>> =
        words.map(|word| word.parse().ok().filter(|value: &f64| value.is_finite())).collect();
    values?.try_into().ok()
}

/// The children of this name.
pub(super) fn named_children<'a, 'input: 'a>(
    node: Node<'a, 'input>,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'input>> {
    node.children().filter(move |child| is_named(node, *child, name))
}

/// Whether a child is an element of this name in the namespace of its parent: `<x:link>` is no link.
fn is_named(parent: Node<'_, '_>, child: Node<'_, '_>, name: &str) -> bool {
    let tag = child.tag_name();
    child.is_element() && tag.name() == name && tag.namespace() == parent.tag_name().namespace()
}

/// The link, joint or robot that an element belongs to, for the start of a message.
pub(super) fn place(node: Node<'_, '_>) -> String {
    let owner = node.ancestors().find(|a| ["link", "joint", "robot"].contains(&a.tag_name().name()));
    owner.map_or_else(
        || "document".to_owned(),
        |owner| format!("{} {}", owner.tag_name().name(), owner.attribute("name").unwrap_or("(no name)")),
    )
}

/// The bytes of an element's start tag.
pub(super) fn tag_span(text: &str, node: Node<'_, '_>) -> Range<usize> {
    let range = node.range();
    let mut quote = None;
    for (offset, byte) in text[range.clone()].bytes().enumerate() {
        match (quote, byte) {
            (None, b'>') => return range.start..range.start + offset + 1,
            (None, b'"' | b'\'') => quote = Some(byte),
            (Some(open), _) if open == byte => quote = None,
            _ => {}
        }
    }
    range
}

/// The bytes of an element's name in its start tag.
fn name_span(text: &str, node: Node<'_, '_>) -> Range<usize> {
    let start = node.range().start + 1;
    let length = text[start..].find(|c: char| c.is_whitespace() || c == '>' || c == '/').unwrap_or(0);
    start..start + length
}

/// The known word that was probably meant: at most a third of its letters differ.
pub(super) fn nearest<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    known
        .iter()
        .map(|candidate| (strsim::damerau_levenshtein(word, candidate), *candidate))
        .filter(|(distance, candidate)| *distance <= (candidate.len() / 3).max(1))
        .min()
        .map(|(_, candidate)| candidate)
}
