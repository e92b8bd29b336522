//! Reads one table key by key: reports what is wrong with each, and at the end the keys nobody asked for.

use std::cell::RefCell;

use nalgebra::Vector3;

use crate::{
    fault::{Fault, Faults, Place},
    quantity::Quantity,
    suggest::nearest,
    tree::{Entry, Node, Table, Value},
};

/// What a number must satisfy besides being finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bound {
    /// Any finite number.
    Any,
    /// Greater than zero.
    Positive,
    /// Zero or more.
    NotNegative,
    /// Greater than zero, at most one (100 %).
    UpToOne,
}

/// A table that is being read.
#[must_use = "call `finish`, which reports the keys that nobody asked for"]
pub(crate) struct Section<'a> {
    table: &'a Table,
    /// As it stands in messages, e.g. `[object.cube]`.
    title: String,
    /// What it describes, with its article, e.g. `an object`.
    what: &'static str,
    asked: RefCell<Vec<String>>,
    /// Keys that must be there and are not; `finish` reports them, since an unknown key may be one of them.
    missing: RefCell<Vec<String>>,
    faults: &'a Faults,
}

/// A key with its unit, its entry, and the conversion to SI.
pub(crate) type Measured<'a> = (String, &'a Entry, fn(f64) -> f64);

impl<'a> Section<'a> {
    pub(crate) fn new(
        table: &'a Table,
        title: impl Into<String>,
        what: &'static str,
        faults: &'a Faults,
    ) -> Self {
        Self {
            table,
            title: title.into(),
            what,
            asked: RefCell::default(),
            missing: RefCell::default(),
            faults,
        }
    }

    /// Where the table stands.
    pub(crate) fn place(&self) -> &'a Place {
        &self.table.at
    }

    /// Where faults go.
    pub(crate) fn faults(&self) -> &'a Faults {
        self.faults
    }

    /// The entry of this key, if it is there.
    pub(crate) fn entry(&self, key: &str) -> Option<&'a Entry> {
        self.ask(key);
        self.table.entries.get(key)
    }

    /// Whether the key is there.
    pub(crate) fn has(&self, key: &str) -> bool {
        self.table.entries.contains_key(key)
    }

    /// Makes `key` known without reading it.
    pub(crate) fn ask(&self, key: &str) {
        self.asked.borrow_mut().push(key.to_owned());
    }

    /// Notes that `key` is missing, which `finish` reports.
    pub(crate) fn missing(&self, key: &str) {
        self.ask(key);
        self.missing.borrow_mut().push(key.to_owned());
    }

    /// The entry of this key; reports its absence.
    pub(crate) fn required(&self, key: &str) -> Option<&'a Entry> {
        let entry = self.entry(key);
        if entry.is_none() {
            self.missing(key);
        }
        entry
    }

    /// A text.
    pub(crate) fn text(&self, key: &str) -> Option<(&'a str, &'a Place)> {
        self.entry(key).and_then(|entry| text(key, &entry.node, self.faults))
    }

    /// A text that must be there.
    pub(crate) fn required_text(&self, key: &str) -> Option<(&'a str, &'a Place)> {
        self.required(key).and_then(|entry| text(key, &entry.node, self.faults))
    }

    /// One of a few words.
    pub(crate) fn word<T: Copy>(&self, key: &str, words: &[(&str, T)], default: Option<T>) -> Option<T> {
        let entry = match default {
            Some(_) => self.entry(key),
            None => self.required(key),
        };
        let Some(entry) = entry else { return default };
        let (word, at) = text(key, &entry.node, self.faults)?;
        let found = words.iter().find(|(known, _)| *known == word).map(|(_, value)| *value);
        if found.is_none() {
            let known: Vec<_> = words.iter().map(|(known, _)| *known).collect();
            let label = nearest(word, known.iter().copied())
                .map_or_else(|| "unknown".to_owned(), |near| format!("did you mean \"{near}\"?"));
            let title = format!("{key} is one of {}, not \"{word}\"", list(&known));
            self.faults.report(Fault::new("unknown-word", at, title, label));
        }
        found
    }

    /// True or false.
    pub(crate) fn flag(&self, key: &str, default: bool) -> Option<bool> {
        let Some(entry) = self.entry(key) else { return Some(default) };
        match entry.node.value {
            Value::Bool(value) => Some(value),
            _ => {
                wrong_type(key, &entry.node, "true or false", self.faults);
                None
            }
        }
    }

    /// A whole number within limits.
    pub(crate) fn whole(&self, key: &str, least: i64, most: i64) -> Option<i64> {
        let node = &self.entry(key)?.node;
        let Value::Integer(value) = node.value else {
            wrong_type(key, node, "a whole number", self.faults);
            return None;
        };
        if (least..=most).contains(&value) {
            return Some(value);
        }
        let title = if value < least {
            format!("{key} is {value}, below {least}")
        } else {
            format!("{key} is {value}, above {most}")
        };
        self.faults.report(Fault::new("range", &node.at, title, format!("between {least} and {most}")));
        None
    }

    /// A number without a unit that must be there.
    pub(crate) fn required_plain(&self, key: &str, bound: Bound) -> Option<f64> {
        number(key, &self.required(key)?.node, bound, self.faults)
    }

    /// A number whose unit is the end of its key, in SI units.
    pub(crate) fn measure(&self, stem: &str, quantity: Quantity, bound: Bound) -> Option<f64> {
        self.measure_at(stem, quantity, bound).map(|(value, _)| value)
    }

    /// The same, with the place of the value.
    pub(crate) fn measure_at(
        &self,
        stem: &str,
        quantity: Quantity,
        bound: Bound,
    ) -> Option<(f64, &'a Place)> {
        let (key, entry, to_si) = self.with_unit(stem, quantity)?;
        number(&key, &entry.node, bound, self.faults).map(|value| (to_si(value), &entry.node.at))
    }

    /// A number with its unit, in SI units; `default` when it is absent, none when it has a fault.
    pub(crate) fn measure_or(
        &self,
        stem: &str,
        quantity: Quantity,
        bound: Bound,
        default: f64,
    ) -> Option<f64> {
        let value = self.measure(stem, quantity, bound);
        if self.mentions(stem) { value } else { Some(default) }
    }

    /// A number without a unit; `default` when it is absent, none when it has a fault.
    pub(crate) fn plain_or(&self, key: &str, bound: Bound, default: f64) -> Option<f64> {
        match self.entry(key) {
            Some(entry) => number(key, &entry.node, bound, self.faults),
            None => Some(default),
        }
    }

    /// A number with its unit that must be there, in SI units.
    pub(crate) fn required_measure(&self, stem: &str, quantity: Quantity, bound: Bound) -> Option<f64> {
        self.require_unit(stem, quantity);
        self.measure(stem, quantity, bound)
    }

    /// A list of numbers of one unit, in SI units.
    pub(crate) fn measures<const N: usize>(&self, stem: &str, quantity: Quantity) -> Option<[f64; N]> {
        let (key, entry, to_si) = self.with_unit(stem, quantity)?;
        numbers(&key, &entry.node, self.faults).map(|values: [f64; N]| values.map(to_si))
    }

    /// A list of numbers of one unit that must be there, in SI units.
    pub(crate) fn required_measures<const N: usize>(
        &self,
        stem: &str,
        quantity: Quantity,
    ) -> Option<[f64; N]> {
        self.require_unit(stem, quantity);
        self.measures(stem, quantity)
    }

    /// A vector of three numbers of one unit that must be there, in SI units.
    pub(crate) fn required_vector(&self, stem: &str, quantity: Quantity) -> Option<Vector3<f64>> {
        self.required_measures(stem, quantity).map(Vector3::from)
    }

    /// The table of this key.
    pub(crate) fn section(&self, key: &str, what: &'static str) -> Option<Section<'a>> {
        let entry = self.entry(key)?;
        self.open(key, entry, what)
    }

    /// The table of this key, which must be there.
    pub(crate) fn required_section(&self, key: &str, what: &'static str) -> Option<Section<'a>> {
        let entry = self.required(key)?;
        self.open(key, entry, what)
    }

    fn open(&self, key: &str, entry: &'a Entry, what: &'static str) -> Option<Section<'a>> {
        match &entry.node.value {
            Value::Table(table) => Some(Section::new(table, self.child_title(key), what, self.faults)),
            _ => {
                wrong_type(key, &entry.node, "a table", self.faults);
                None
            }
        }
    }

    /// The tables of this list; none when the key is absent.
    pub(crate) fn sections(&self, key: &str, what: &'static str) -> Vec<Section<'a>> {
        let Some(entry) = self.entry(key) else { return Vec::new() };
        let Value::Array(nodes) = &entry.node.value else {
            wrong_type(key, &entry.node, "a list of tables", self.faults);
            return Vec::new();
        };
        let title = format!("[{}]", self.child_title(key));
        let open = |node: &'a Node| match &node.value {
            Value::Table(table) => Some(Section::new(table, title.clone(), what, self.faults)),
            _ => {
                wrong_type(key, node, "a table", self.faults);
                None
            }
        };
        nodes.iter().filter_map(open).collect()
    }

    /// All tables in this table, by name; every name is known.
    pub(crate) fn named_sections(&self, what: &'static str) -> Vec<(&'a str, &'a Place, Section<'a>)> {
        let named = |(key, entry): (&'a String, &'a Entry)| {
            self.ask(key);
            Some((key.as_str(), &entry.key_at, self.open(key, entry, what)?))
        };
        self.table.entries.iter().filter_map(named).collect()
    }

    /// The key that starts with `stem` and ends in the unit of another quantity.
    pub(crate) fn misfit(&self, stem: &str, quantity: Quantity) -> Option<(&'a str, &'a Place, Quantity)> {
        self.table.entries.iter().find_map(|(key, entry)| {
            let other = Quantity::of_key(stem, key)?;
            (other != quantity).then_some((key.as_str(), &entry.key_at, other))
        })
    }

    /// Whether the quantity stands there in any unit, right or wrong, or without one.
    pub(crate) fn mentions(&self, stem: &str) -> bool {
        let of_stem = |key: &String| key == stem || Quantity::of_key(stem, key).is_some();
        self.table.entries.keys().any(of_stem)
    }

    /// Where the value of a quantity stands, in whichever of its units.
    pub(crate) fn place_of(&self, stem: &str, quantity: Quantity) -> Option<&'a Place> {
        let entry = quantity.keys(stem).find_map(|(key, _)| self.table.entries.get(&key));
        entry.map(|entry| &entry.node.at)
    }

    fn require_unit(&self, stem: &str, quantity: Quantity) {
        if !self.mentions(stem) {
            self.missing(&quantity.key(stem));
        }
    }

    /// The entry of `stem` with one of the quantity's units, and its conversion. Reports two units at once,
    /// the unit of another quantity, and a key without its unit.
    pub(crate) fn with_unit(&self, stem: &str, quantity: Quantity) -> Option<Measured<'a>> {
        let mut found: Option<Measured<'a>> = None;
        for (key, unit) in quantity.keys(stem) {
            let Some(entry) = self.entry(&key) else { continue };
            if let Some((first, first_entry, _)) = &found {
                let title = format!("{} has both `{first}` and `{key}`", self.title);
                let fault = Fault::new("two-units", &entry.key_at, title, "keep one of them");
                self.faults.report(fault.second(&first_entry.key_at, "the other one"));
                return None;
            }
            found = Some((key, entry, unit.to_si));
        }
        if found.is_some() {
            return found;
        }
        let write = format!("write `{}`", quantity.key(stem));
        if let Some((key, at, other)) = self.misfit(stem, quantity) {
            self.ask(key);
            let title = format!("`{key}` has the unit of {}, it takes {}", other.word(), quantity.word());
            self.faults.report(Fault::new("unit", at, title, write).replace_key(quantity.key(stem)));
        } else if let Some(entry) = self.table.entries.get(stem) {
            self.ask(stem);
            let title = format!("`{stem}` lacks its unit: it takes {}", quantity.word());
            self.faults
                .report(Fault::new("unit", &entry.key_at, title, write).replace_key(quantity.key(stem)));
        }
        None
    }

    /// Reports the keys that nobody asked for, and those that are missing. An unknown key that is probably a
    /// missing one is reported once, with that key as the cure.
    pub(crate) fn finish(self) {
        let asked = self.asked.into_inner();
        let mut missing = self.missing.into_inner();
        for (key, entry) in &self.table.entries {
            if asked.contains(key) {
                continue;
            }
            let title = format!("unknown key `{key}` in {}", self.title);
            let fault =
                Fault::new("unknown-key", &entry.key_at, title, format!("not a key of {}", self.what));
            // A quantity that is there in one unit is not asked for again in another.
            let is_there = |known: &str| {
                let same = |present: &String| present != key && stem_of(present) == stem_of(known);
                self.table.entries.contains_key(known) || self.table.entries.keys().any(same)
            };
            let absent = asked.iter().map(String::as_str).filter(|known| !is_there(known));
            let meant = nearest(key, absent).map(str::to_owned).or_else(|| of_the_same_unit(key, &missing));
            self.faults.report(match meant {
                // Another unit means another number, which nobody can guess.
                Some(meant) if stem_of(&meant) == stem_of(key) => {
                    missing.retain(|key| *key != meant);
                    fault.saying(format!("this unit is not known here; `{meant}` is"))
                }
                Some(meant) => {
                    missing.retain(|key| *key != meant);
                    fault.replace(format!("did you mean `{meant}`?"), meant)
                }
                None => fault,
            });
        }
        for key in missing {
            let title = format!("missing key `{key}` in {}", self.title);
            self.faults.report(Fault::new("missing-key", &self.table.at, title, format!("add `{key}`")));
        }
    }

    fn child_title(&self, key: &str) -> String {
        match self.title.strip_prefix('[').and_then(|title| title.strip_suffix(']')) {
            Some(parent) => format!("[{}.{key}]", parent.trim_matches(['[', ']'])),
            None => format!("[{key}]"),
        }
    }
}

impl Fault {
    /// Proposes another key.
    fn replace_key(self, key: String) -> Self {
        self.replace("the unit stands in the key", key)
    }
}

/// A key without its last part, which is its unit if it has one.
fn stem_of(key: &str) -> &str {
    key.rsplit_once('_').map_or(key, |(stem, _)| stem)
}

/// The text of a node.
pub(crate) fn text<'a>(key: &str, node: &'a Node, faults: &Faults) -> Option<(&'a str, &'a Place)> {
    match &node.value {
        Value::Text(text) => Some((text, &node.at)),
        _ => {
            wrong_type(key, node, "text in quotes", faults);
            None
        }
    }
}

/// The number of a node, if it is finite and within its bound.
pub(crate) fn number(key: &str, node: &Node, bound: Bound, faults: &Faults) -> Option<f64> {
    let value = match node.value {
        Value::Integer(value) => value as f64,
        Value::Float(value) => value,
        _ => {
            wrong_type(key, node, "a number", faults);
            return None;
        }
    };
    // A share stands in per cent in the file, so its bound does, too.
    let most = if key.ends_with("percent") { 100.0 } else { 1.0 };
    let (fits, wanted) = match bound {
        Bound::Any => (true, "write a finite number".to_owned()),
        Bound::Positive => (value > 0.0, "must be greater than 0".to_owned()),
        Bound::NotNegative => (value >= 0.0, "must be 0 or more".to_owned()),
        Bound::UpToOne => {
            (value > 0.0 && value <= most, format!("must be greater than 0 and at most {most}"))
        }
    };
    if fits && value.is_finite() {
        return Some(value);
    }
    faults.report(Fault::new("range", &node.at, format!("{key} is {value}, out of its range"), wanted));
    None
}

/// The numbers of a list of a fixed length.
pub(crate) fn numbers<const N: usize>(key: &str, node: &Node, faults: &Faults) -> Option<[f64; N]> {
    let Value::Array(items) = &node.value else {
        wrong_type(key, node, &format!("a list of {N} numbers"), faults);
        return None;
    };
    if items.len() != N {
        let title = format!("{key} has {} numbers, it takes {N}", items.len());
        faults.report(Fault::new("type", &node.at, title, format!("write {N} numbers")));
        return None;
    }
    let read: Vec<_> = items.iter().map(|item| number(key, item, Bound::Any, faults)).collect();
    let values: Option<Vec<f64>> = read.into_iter().collect();
    values?.try_into().ok()
}

/// Reports a value of the wrong kind.
pub(crate) fn wrong_type(key: &str, node: &Node, wanted: &str, faults: &Faults) {
    let numeric = wanted == "a number" && Quantity::ALL.iter().any(|quantity| ends_in_unit(key, *quantity));
    let hint = if numeric { "; the unit is in the key" } else { "" };
    let fault = Fault::new(
        "type",
        &node.at,
        format!("{key} takes {wanted}{hint}"),
        format!("this is {}", node.value.kind()),
    );
    let leading = match &node.value {
        Value::Text(text) if wanted == "a number" => leading_number(text),
        _ => None,
    };
    faults.report(match leading {
        Some(number) => fault.replace(format!("write {number}"), number),
        None => fault,
    });
}

fn ends_in_unit(key: &str, quantity: Quantity) -> bool {
    quantity.units().iter().any(|unit| key.strip_suffix(unit.suffix).is_some_and(|stem| stem.ends_with('_')))
}

/// The only missing key that ends in the same unit as `key`, e.g. `mass_kg` for `weight_kg`.
fn of_the_same_unit(key: &str, missing: &[String]) -> Option<String> {
    let quantity = Quantity::ALL.into_iter().find(|quantity| ends_in_unit(key, *quantity))?;
    let mut same = missing.iter().filter(|missing| ends_in_unit(missing, quantity));
    let only = same.next()?;
    same.next().is_none().then(|| only.clone())
}

/// The number at the start of a text such as `-70 deg`.
fn leading_number(text: &str) -> Option<&str> {
    let text = text.trim();
    let end = text.find(|c: char| !matches!(c, '0'..='9' | '+' | '-' | '.')).unwrap_or(text.len());
    text[..end].parse::<f64>().is_ok().then_some(&text[..end])
}

/// `a, b or c`.
pub(crate) fn list(words: &[&str]) -> String {
    let quoted: Vec<_> = words.iter().map(|word| format!("\"{word}\"")).collect();
    match quoted.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, rest)) => format!("{} or {last}", rest.join(", ")),
        None => String::new(),
    }
}
