//! The judge: every claim of a certificate and of the least margin, held against distances of its own.

use std::collections::BTreeSet;

use graspcheck_model::robot::RobotModel;
use graspcheck_proof::{
    Certificate, Leaf, MarginBounds, PairCertificate, PairVerdict, Scene, Sweep, Violation,
    contact::{APPROACH_MARGIN, DEPTH_LIMIT, SUPPORT_OVERLAP},
};
use nalgebra::Vector3;

use super::{
    distance::{Distance, distance_above, slab},
    motion::{Bodies, Carrier, Moment, Part},
    random::Case,
    solid::Placed,
};

/// Samples a second.
pub const RATE: f64 = 1e4;
/// Rounding of places and distances on an arm of 8 m, m: far less than the nanometre that every proof leaves.
const ROUNDING: f64 = 1e-10;
/// How exactly a witness point must lie in its solid, and the two as far apart as is said, m.
const WITNESS: f64 = 1e-8;
/// To how much the least margin is brought, m.
const TOLERANCE: f64 = 1e-4;
/// The bounds of the judge's own distance are this near, m, or the sample is counted as vague.
const VAGUE: f64 = 1e-7;
/// A slab that shows more than this share of what the distance was above the claim a little earlier shows enough.
const ENOUGH: f64 = 0.5;
/// Samples that share one bound on the speeds.
const WINDOW: usize = 32;

/// What came out of one or many scenes.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    pub scenes: u64,
    pub held: u64,
    pub free: u64,
    pub violated: u64,
    pub unknown: u64,
    pub not_checked: u64,
    /// Scenes with an unknown pair.
    pub unknown_scenes: u64,
    pub free_scenes: u64,
    pub violated_scenes: u64,
    pub leaves: u64,
    pub sweeps: u64,
    /// Samples of a pair that the speed bound left to be looked at, and those that it excluded.
    pub looked_at: u64,
    pub excluded: u64,
    /// Distances that the judge knows no better than [`VAGUE`].
    pub vague: u64,
    /// Least margins that were bracketed to [`TOLERANCE`], and that were not.
    pub bracketed: u64,
    pub loose: u64,
    /// Claims that are not true, in words.
    pub contradictions: Vec<String>,
}

impl Tally {
    pub fn add(&mut self, other: Self) {
        self.scenes += other.scenes;
        self.held += other.held;
        self.free += other.free;
        self.violated += other.violated;
        self.unknown += other.unknown;
        self.not_checked += other.not_checked;
        self.unknown_scenes += other.unknown_scenes;
        self.free_scenes += other.free_scenes;
        self.violated_scenes += other.violated_scenes;
        self.leaves += other.leaves;
        self.sweeps += other.sweeps;
        self.looked_at += other.looked_at;
        self.excluded += other.excluded;
        self.vague += other.vague;
        self.bracketed += other.bracketed;
        self.loose += other.loose;
        self.contradictions.extend(other.contradictions);
    }
}

/// Proves a case and judges the proofs. `label` stands in front of every contradiction. With `of_hits` the least margin
/// is judged of scenes with a hit, too, which takes most of the time: the depths of overlaps are searched for.
pub fn judge(label: &str, case: &Case, of_hits: bool) -> Tally {
    let scene = Scene::new(&case.robot, &case.cell, case.object.as_ref()).unwrap();
    let certificate = scene.certify(&case.plan);
    let wanted = of_hits || certificate.is_free();
    let least = wanted.then(|| scene.minimum_margin(&case.plan, TOLERANCE)).flatten();
    let bodies = case.bodies();
    let mut judge = Judge::new(label, case, &bodies);
    judge.pairs(&certificate, least.as_ref());
    if wanted {
        judge.least(&certificate, least.as_ref());
    }
    let mut tally = judge.tally;
    tally.scenes = 1;
    tally.held = u64::from(case.object.is_some());
    tally.unknown_scenes = u64::from(tally.unknown > 0);
    tally.free_scenes = u64::from(certificate.is_free());
    tally.violated_scenes = u64::from(tally.violated > 0);
    tally
}

struct Judge<'c> {
    label: &'c str,
    case: &'c Case,
    bodies: &'c Bodies<'c>,
    /// The places at every sample that was looked at.
    moments: Vec<Option<Moment>>,
    /// For every window of samples the bounds on the speeds.
    speeds: Vec<Vec<f64>>,
    duration: f64,
    tally: Tally,
}

impl<'c> Judge<'c> {
    fn new(label: &'c str, case: &'c Case, bodies: &'c Bodies<'c>) -> Self {
        let duration = case.plan.duration();
        let samples = (duration * RATE) as usize + 1;
        let time = |sample: usize| sample as f64 / RATE;
        let speeds = (0..samples.div_ceil(WINDOW))
            .map(|window| bodies.speeds(time(window * WINDOW), time((window + 1) * WINDOW).min(duration)));
        Self {
            label,
            case,
            bodies,
            speeds: speeds.collect(),
            moments: (0..samples).map(|_| None).collect(),
            duration,
            tally: Tally::default(),
        }
    }

    fn contradict(&mut self, what: &str) {
        self.tally.contradictions.push(format!("{}: {what}", self.label));
    }

    /// Every two solids that must keep apart: links against the cell, links that may not touch against each other, the
    /// object against all.
    fn expected(&self) -> BTreeSet<[usize; 2]> {
        let parts = &self.bodies.parts;
        let is_cell = |body: &str| self.case.cell.bodies.iter().any(|obstacle| obstacle.name == body);
        let judged = |a: &Part, b: &Part| {
            a.body != b.body
                && !(is_cell(&a.body) && is_cell(&b.body))
                && !may_touch(&self.case.robot, &a.body, &b.body)
        };
        let all = (0..parts.len()).flat_map(|b| (0..b).map(move |a| [a, b]));
        all.filter(|[a, b]| judged(&parts[*a], &parts[*b])).collect()
    }

    /// No pair is missing: those that are not listed are proved by sweeps alone.
    fn pairs(&mut self, certificate: &Certificate, least: Option<&MarginBounds>) {
        let mut open = self.expected();
        if certificate.pair_count != open.len() {
            self.contradict(&format!("{} pairs, not {}", certificate.pair_count, open.len()));
        }
        self.sweeps(&certificate.sweeps);
        for pair in &certificate.pairs {
            let name = format!("{} {} - {} {}", pair.a, pair.part_a, pair.b, pair.part_b);
            let ends = [(&pair.a, pair.part_a), (&pair.b, pair.part_b)];
            let [Some(a), Some(b)] = ends.map(|(body, index)| self.bodies.part(body, index)) else {
                self.contradict(&format!("{name}: there is no such pair"));
                continue;
            };
            if !open.remove(&[a.min(b), a.max(b)]) {
                self.contradict(&format!("{name}: not to be judged, or listed twice"));
            }
            self.pair(&name, [a, b], pair, certificate, least);
        }
        for [a, b] in open {
            let [part_a, part_b] = [a, b].map(|part| &self.bodies.parts[part]);
            let name = format!("{} {} - {} {}", part_a.body, part_a.index, part_b.body, part_b.index);
            self.tally.free += 1;
            self.covers(&name, [a, b], &[], &certificate.sweeps);
            self.free_samples(&name, [a, b], true, least);
        }
    }

    /// At its middle, at its ends and between, all of a solid is in its sweep.
    fn sweeps(&mut self, sweeps: &[Sweep]) {
        self.tally.sweeps += sweeps.len() as u64;
        for sweep in sweeps {
            let Some(part) = self.bodies.part(&sweep.body, sweep.part) else {
                self.contradict(&format!("there is no {} {}", sweep.body, sweep.part));
                continue;
            };
            for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
                let moment = self.bodies.at(sweep.start + share * (sweep.end - sweep.start));
                let [min, max] = self.bodies.placed(part, &moment).bounds();
                let outside = |axis: usize| {
                    min[axis] < sweep.min[axis] - ROUNDING || max[axis] > sweep.max[axis] + ROUNDING
                };
                if (0..3).any(outside) {
                    self.contradict(&format!("{min:?} to {max:?} is not in {sweep:?}"));
                }
            }
        }
    }

    /// The distance that must be kept, m.
    fn required(&self, a: &str, b: &str) -> f64 {
        let is = |x: &str, y: &str| (a == x && b == y) || (a == y && b == x);
        let robot = &self.case.robot;
        let is_cell = |body: &str| self.case.cell.bodies.iter().any(|obstacle| obstacle.name == body);
        let object = self.case.object.as_ref().map_or("", |object| &object.name);
        let hand = &robot.links[robot.dof() - 1].name;
        let rules = &self.case.cell.clearance;
        let fingers = &robot.gripper.fingers;
        if is_cell(b) && a == robot.base.name || is_cell(a) && b == robot.base.name {
            -SUPPORT_OVERLAP
        } else if fingers.iter().any(|finger| is(object, &finger.link.name)) {
            -DEPTH_LIMIT
        } else if let Some(rule) = rules.pairs.iter().find(|rule| is(&rule.a, &rule.b)) {
            rule.required
        } else if is(object, hand) {
            APPROACH_MARGIN
        } else {
            rules.required
        }
    }

    /// The distance at an instant, to [`VAGUE`] or better.
    fn distance_at(&mut self, a: usize, b: usize, moment: &Moment) -> Distance {
        self.distance_above(a, b, moment, f64::INFINITY)
    }

    /// The distance at an instant, less exactly the farther it is above `claimed`.
    fn distance_above(&mut self, a: usize, b: usize, moment: &Moment, claimed: f64) -> Distance {
        let (a, b) = (self.bodies.placed(a, moment), self.bodies.placed(b, moment));
        let known = distance_above(&a, &b, claimed);
        if known.upper > 0.0 && known.lower < claimed && known.upper - known.lower > VAGUE {
            self.tally.vague += 1;
        }
        known
    }

    fn pair(
        &mut self,
        name: &str,
        [a, b]: [usize; 2],
        pair: &PairCertificate,
        certificate: &Certificate,
        least: Option<&MarginBounds>,
    ) {
        let required = self.required(&pair.a, &pair.b);
        for leaf in &pair.leaves {
            self.leaf(name, [a, b], leaf, required);
        }
        self.tally.leaves += pair.leaves.len() as u64;
        match &pair.verdict {
            PairVerdict::Free { margin } => {
                self.tally.free += 1;
                self.covers(name, [a, b], &pair.leaves, &certificate.sweeps);
                let leaf = pair
                    .leaves
                    .iter()
                    .map(|leaf| leaf.gap - leaf.loss - required)
                    .fold(f64::INFINITY, f64::min);
                if leaf < *margin {
                    self.contradict(&format!(
                        "{name}: a leaf shows a margin of {leaf} m, but {margin} m is claimed"
                    ));
                }
            }
            PairVerdict::Violated(violation) => {
                self.tally.violated += 1;
                self.violation(name, [a, b], violation, required);
            }
            PairVerdict::Unknown(doubt) => {
                self.tally.unknown += 1;
                let [from, to] = doubt.interval;
                let moment = self.bodies.at(0.5 * (from + to));
                let known = self.distance_at(a, b, &moment);
                let [low, high] = doubt.distance;
                if known.upper < low - ROUNDING || known.lower > high + ROUNDING {
                    self.contradict(&format!("{name}: {known:?} is said to be in {:?}", doubt.distance));
                }
            }
            PairVerdict::NotChecked { .. } => self.tally.not_checked += 1,
        }
        self.free_samples(name, [a, b], matches!(pair.verdict, PairVerdict::Free { .. }), least);
    }

    /// No sample is nearer than a pair that is free may be, or than the least margin allows. Margins of single pairs are
    /// held against the leaves' instants.
    fn free_samples(&mut self, name: &str, [a, b]: [usize; 2], is_free: bool, least: Option<&MarginBounds>) {
        let required = self.required(&self.bodies.parts[a].body, &self.bodies.parts[b].body);
        let free = is_free.then_some(required);
        let least = least.filter(|_| self.counts(a, b)).map(|least| required + least.lower);
        if let Some(claimed) = free.into_iter().chain(least).reduce(f64::max) {
            let what = if free == Some(claimed) { "it is free" } else { "the least margin is known" };
            self.samples(name, [a, b], claimed, what);
        }
    }

    /// The leaves of a free pair, and the sweeps of one that are far enough from the other, leave no instant out.
    fn covers(&mut self, name: &str, [a, b]: [usize; 2], leaves: &[Leaf], sweeps: &[Sweep]) {
        let mut proved: Vec<[f64; 2]> = leaves.iter().map(|leaf| [leaf.start, leaf.end]).collect();
        let required = self.required(&self.bodies.parts[a].body, &self.bodies.parts[b].body);
        for [swept, standing] in [[a, b], [b, a]] {
            let Part { body, index, .. } = &self.bodies.parts[swept];
            let of_the_cell =
                self.case.cell.bodies.iter().any(|body| body.name == self.bodies.parts[standing].body);
            if !of_the_cell {
                continue;
            }
            let [min, max] = self.bodies.placed(standing, &self.bodies.at(0.0)).bounds();
            for sweep in sweeps.iter().filter(|sweep| sweep.body == *body && sweep.part == *index) {
                let apart = Vector3::from_fn(|axis, _| {
                    (min[axis] - sweep.max[axis]).max(sweep.min[axis] - max[axis]).max(0.0)
                });
                if apart.norm() >= required.max(0.0) + ROUNDING {
                    proved.push([sweep.start, sweep.end]);
                }
            }
        }
        proved.sort_by(|x, y| x[0].total_cmp(&y[0]));
        let mut reached = 0.0_f64;
        let mut without_gap = true;
        for [start, end] in proved {
            without_gap &= start <= reached && end > start;
            reached = reached.max(end);
        }
        if !without_gap || reached < self.duration {
            self.contradict(&format!("{name}: free, but leaves and sweeps do not cover the motion"));
        }
    }

    /// At its middle, at its ends and at every sample within, the pair is as far apart as a leaf says.
    fn leaf(&mut self, name: &str, [a, b]: [usize; 2], leaf: &Leaf, required: f64) {
        if leaf.required.to_bits() != required.to_bits() || leaf.gap - leaf.loss < required {
            self.contradict(&format!("{name}: {leaf:?} does not show {required} m"));
        }
        let middle = 0.5 * (leaf.start + leaf.end);
        let quarter = 0.25 * (leaf.end - leaf.start);
        let kept = leaf.gap - leaf.loss;
        let instants = [
            (middle, leaf.gap),
            (leaf.start, kept),
            (leaf.end, kept),
            (middle - quarter, kept),
            (middle + quarter, kept),
        ];
        for (t, claimed) in instants {
            let moment = self.bodies.at(t);
            let known = self.distance_above(a, b, &moment, claimed);
            if known.upper < claimed - ROUNDING {
                self.contradict(&format!("{name}: {} m at {t} s, but {leaf:?}", known.upper));
            }
        }
    }

    /// No sample of a pair is nearer than claimed. Samples that the speed bound shows to be farther are passed over.
    fn samples(&mut self, name: &str, [a, b]: [usize; 2], claimed: f64, what: &str) {
        let bodies = self.bodies;
        let rates: Vec<f64> = self.speeds.iter().map(|speeds| bodies.approach(a, b, speeds)).collect();
        let last = self.moments.len() - 1;
        let mut sample = 0;
        let (mut normal, mut room) = (Vector3::z(), f64::INFINITY);
        loop {
            let moment = self.moments[sample].take().unwrap_or_else(|| bodies.at(sample as f64 / RATE));
            self.tally.looked_at += 1;
            // The slab of the sample before often shows enough.
            let by_slab = slab(&bodies.placed(a, &moment), &bodies.placed(b, &moment), &normal) - claimed;
            let mut left = by_slab;
            if by_slab <= ENOUGH * room {
                let known = self.distance_above(a, b, &moment, claimed);
                if known.upper < claimed - ROUNDING {
                    let t = sample as f64 / RATE;
                    self.contradict(&format!(
                        "{name}: {} m at sample {t} s, but {what}: {claimed} m",
                        known.upper
                    ));
                    return;
                }
                left = known.lower - claimed;
                room = left.max(0.0);
                let [on_a, on_b] = known.core_points;
                normal = (on_b - on_a).try_normalize(0.0).unwrap_or(normal);
            }
            self.moments[sample] = Some(moment);
            // As far as what is left of the distance lasts at the largest speed of every window on the way.
            let mut farther = sample;
            while left > 0.0 && farther < last {
                let window = farther / WINDOW;
                let steps = ((window + 1) * WINDOW - farther).min(last - farther);
                let way = rates[window] / RATE;
                if left > way * steps as f64 {
                    left -= way * steps as f64;
                    farther += steps;
                } else {
                    farther += (left / way) as usize;
                    break;
                }
            }
            if farther == last {
                self.tally.excluded += (last - sample) as u64;
                return;
            }
            self.tally.excluded += (farther - sample) as u64;
            sample = farther.max(sample) + 1;
            if sample > last {
                return;
            }
        }
    }

    /// A violation is one: its points lie in the solids, as near as it says, and that is nearer than required.
    fn violation(&mut self, name: &str, [a, b]: [usize; 2], violation: &Violation, required: f64) {
        let moment = self.bodies.at(violation.time);
        let known = self.distance_at(a, b, &moment);
        let said = violation.distance;
        let [on_a, on_b] = violation.points.map(Vector3::from);
        let (a, b) = (self.bodies.placed(a, &moment), self.bodies.placed(b, &moment));
        let (depth_a, depth_b) = (a.depth(&on_a), b.depth(&on_b));
        // A depth is shown with the slack on top, so that one exactly as large as may be is a violation, too.
        let nearer = said < required || (said < 0.0 && depth_a + depth_b > -required);
        let shown = if said >= 0.0 {
            depth_a >= -WITNESS && depth_b >= -WITNESS && ((on_b - on_a).norm() - said).abs() <= WITNESS
        } else {
            depth_a + depth_b >= -said - WITNESS || self.overlaps_by(&a, &b, [on_a, on_b], said)
        };
        let is_one =
            nearer && known.lower <= said + ROUNDING && violation.required.to_bits() == required.to_bits();
        if !(shown && is_one && (0.0..=self.duration).contains(&violation.time)) {
            self.contradict(&format!("{name}: {known:?}, depths {depth_a} and {depth_b}, but {violation:?}"));
        }
    }

    /// The cores are so near, or meet, that with their radii the solids overlap by this much.
    fn overlaps_by(&self, a: &Placed, b: &Placed, [on_a, on_b]: [Vector3<f64>; 2], said: f64) -> bool {
        let Some(back) = (on_a - on_b).try_normalize(0.0) else { return false };
        let (core_a, core_b) = (on_a - back * a.solid.radius, on_b + back * b.solid.radius);
        a.depth(&core_a) >= a.solid.radius - WITNESS
            && b.depth(&core_b) >= b.solid.radius - WITNESS
            && (core_b - core_a).norm() - a.solid.radius - b.solid.radius <= said + WITNESS
    }

    /// The bracket is one, and agrees with the certificate.
    fn least(&mut self, certificate: &Certificate, least: Option<&MarginBounds>) {
        let Some(least) = least else {
            if self.tally.not_checked == 0 {
                self.contradict("all pairs were checked, but there is no least margin");
            }
            return;
        };
        let moment = self.bodies.at(least.time);
        let required = self.required(&least.a, &least.b);
        let parts = |body: &str| -> Vec<usize> {
            let parts = self.bodies.parts.iter().enumerate();
            parts.filter(|(_, part)| part.body == body).map(|(index, _)| index).collect()
        };
        let mut there = f64::INFINITY;
        for a in parts(&least.a) {
            for b in parts(&least.b) {
                there = there.min(self.distance_at(a, b, &moment).lower - required);
            }
        }
        if there > least.upper + ROUNDING
            || least.lower > least.upper
            || least.required.to_bits() != required.to_bits()
        {
            self.contradict(&format!("the least margin is {there} m there, but {least:?}"));
        }
        if least.upper - least.lower <= TOLERANCE + ROUNDING {
            self.tally.bracketed += 1;
        } else {
            self.tally.loose += 1;
            // Where nothing is violated nothing overlaps, and only the depth of an overlap may stay open.
            if certificate.is_free() {
                self.contradict(&format!("the least margin was not found: {least:?}"));
            }
        }
        // Sweeps show no more than what is required.
        let mut free = if certificate.sweeps.is_empty() { f64::INFINITY } else { 0.0 };
        for pair in &certificate.pairs {
            let [a, b] = [(&pair.a, pair.part_a), (&pair.b, pair.part_b)]
                .map(|(body, index)| self.bodies.part(body, index));
            let (Some(a), Some(b)) = (a, b) else { continue };
            if !self.counts(a, b) {
                continue;
            }
            match &pair.verdict {
                PairVerdict::Free { margin } => free = free.min(*margin),
                PairVerdict::Violated(violation) => {
                    free = f64::NEG_INFINITY;
                    if least.lower > violation.distance - violation.required {
                        self.contradict(&format!("{least:?} is above {violation:?}"));
                    }
                }
                _ => free = f64::NEG_INFINITY,
            }
        }
        if least.upper < free - ROUNDING {
            self.contradict(&format!("every pair keeps a margin of {free} m, but {least:?}"));
        }
    }

    /// Whether the least margin counts the pair: it may not touch, and one of the two moves.
    fn counts(&self, a: usize, b: usize) -> bool {
        let [part_a, part_b] = [a, b].map(|part| &self.bodies.parts[part]);
        let stands = part_a.carrier == Carrier::World && part_b.carrier == Carrier::World;
        self.required(&part_a.body, &part_b.body) >= 0.0 && !stands
    }
}

/// Whether two bodies of the robot may touch at any time.
fn may_touch(robot: &RobotModel, a: &str, b: &str) -> bool {
    let allowed = &robot.allowed_contacts;
    allowed.iter().any(|contact| (contact.a == a && contact.b == b) || (contact.a == b && contact.b == a))
}
