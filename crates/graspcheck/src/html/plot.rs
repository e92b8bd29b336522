//! One plot as SVG: curves over time with limits, phases and the intervals in which a limit is violated.

use graspcheck_model::plan::Phase;
use maud::{Markup, html};

/// Room for the numbers of the axes, px.
const LEFT: f64 = 54.0;
const BOTTOM: f64 = 18.0;
const TOP: f64 = 16.0;
const RIGHT: f64 = 6.0;

/// A violation is at least this wide, px: one of 7 ms in a run of 3 s would not be seen.
const LEAST_BAND: f64 = 2.0;

/// A limit belongs to the view when the curves come within this factor of it; a limit far away would flatten
/// them, and is told in words.
const IN_VIEW: f64 = 3.0;

/// A line through points `[time, value]` in order of time; s and the unit of the plot.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Curve {
    /// Of the style: its colour, and whether it was planned or executed.
    pub(super) class: String,
    pub(super) points: Vec<[f64; 2]>,
}

/// What a plot shows, values in the unit that its title names.
#[derive(Clone, Debug)]
pub(super) struct Plot<'a> {
    pub(super) title: String,
    /// What it shows, as a sentence for those who do not see it.
    pub(super) description: String,
    /// From when to when, s.
    pub(super) time: [f64; 2],
    /// Width and height, px.
    pub(super) size: [f64; 2],
    pub(super) phases: &'a [Phase],
    /// Whether the phases are named above.
    pub(super) names_phases: bool,
    pub(super) curves: Vec<Curve>,
    pub(super) limits: Vec<f64>,
    /// When a limit is violated, s.
    pub(super) violated: Vec<[f64; 2]>,
}

/// From time and value to px.
struct Scale {
    time: [f64; 2],
    value: [f64; 2],
    size: [f64; 2],
}

impl Scale {
    fn x(&self, t: f64) -> f64 {
        let share = (t - self.time[0]) / (self.time[1] - self.time[0]);
        LEFT + share.clamp(0.0, 1.0) * (self.size[0] - LEFT - RIGHT)
    }

    fn y(&self, value: f64) -> f64 {
        let share = (value - self.value[0]) / (self.value[1] - self.value[0]);
        self.size[1] - BOTTOM - share * (self.size[1] - TOP - BOTTOM)
    }
}

impl Plot<'_> {
    /// The plot as an SVG element.
    pub(super) fn svg(&self) -> Markup {
        let [width, height] = self.size;
        let limits = self.limits_in_view();
        let scale = Scale { time: self.time, value: self.values_in_view(&limits), size: self.size };
        let floor = height - BOTTOM;
        let shown = |[from, to]: [f64; 2]| from < self.time[1] && to > self.time[0];
        html! {
            svg.plot viewBox=(format!("0 0 {width} {height}")) role="img" data-from=(self.time[0]) data-to=(self.time[1])
                data-low=(px(scale.value[0])) data-high=(px(scale.value[1])) {
                title { (self.title) }
                desc { (self.description) }
                @for (index, phase) in self.phases.iter().enumerate().filter(|(_, it)| shown([it.start, it.end])) {
                    @let (from, to) = (scale.x(phase.start), scale.x(phase.end));
                    @if index % 2 == 1 {
                        rect.phase x=(px(from)) y=(TOP) width=(px(to - from)) height=(floor - TOP) {}
                    }
                    // A name that has no room would run into the next.
                    @if self.names_phases && to - from > 5.5 * phase.name.len() as f64 {
                        text.name x=(px(0.5 * (from + to))) y="11" { (phase.name) }
                    }
                }
                @for [from, to] in self.violated.iter().copied().filter(|it| shown([it[0], it[1].max(it[0] + 1e-9)])) {
                    @let (from, to) = band(scale.x(from), scale.x(to));
                    rect.violated x=(px(from)) y=(TOP) width=(px(to - from)) height=(floor - TOP) {}
                    path.mark d=(format!("M{0} {TOP}l-4 -7h8z", px(0.5 * (from + to)))) {}
                }
                @if scale.value[0] <= 0.0 && scale.value[1] >= 0.0 {
                    line.zero x1=(LEFT) x2=(width - RIGHT) y1=(px(scale.y(0.0))) y2=(px(scale.y(0.0))) {}
                    text.value x=(LEFT - 4.0) y=(px(scale.y(0.0) + 4.0)) { "0" }
                }
                @for limit in &limits {
                    line.limit x1=(LEFT) x2=(width - RIGHT) y1=(px(scale.y(*limit))) y2=(px(scale.y(*limit))) {}
                    text.value.of-limit x=(LEFT - 4.0) y=(px(scale.y(*limit) + 4.0)) { (number(*limit)) }
                }
                @for value in self.ends().into_iter().filter(|it| has_room(&scale, *it, &limits)) {
                    text.value x=(LEFT - 4.0) y=(px(scale.y(value) + 4.0)) { (number(value)) }
                }
                @for t in ticks(self.time) {
                    text.time x=(px(scale.x(t))) y=(height - 5.0) { (number(t)) }
                }
                @for curve in &self.curves {
                    polyline.(curve.class) points=(polyline(curve, &scale)) {}
                }
                line.cursor y1=(TOP) y2=(floor) {}
                text.read y="11" {}
            }
        }
    }

    fn limits_in_view(&self) -> Vec<f64> {
        let [low, high] = self.ends();
        let reach = low.abs().max(high.abs());
        self.limits
            .iter()
            .copied()
            .filter(|limit| {
                let is_violated = *limit < high && *limit > low;
                is_violated
                    || (limit.abs() <= IN_VIEW * reach && (*limit > 0.0) == (high > 0.0 || *limit >= 0.0))
            })
            .filter(|limit| limit.is_finite())
            .collect()
    }

    /// The least and the greatest value of all curves.
    fn ends(&self) -> [f64; 2] {
        let values = self.curves.iter().flat_map(|curve| &curve.points).map(|point| point[1]);
        let [low, high] = values
            .filter(|value| value.is_finite())
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [f64::min(low, v), f64::max(high, v)]);
        if low <= high { [low, high] } else { [0.0, 0.0] }
    }

    fn values_in_view(&self, limits: &[f64]) -> [f64; 2] {
        let [mut low, mut high] = self.ends();
        for limit in limits {
            (low, high) = (low.min(*limit), high.max(*limit));
        }
        let room = 0.04 * (high - low);
        // A curve that does not move lies in the middle.
        let room = if room > 0.0 { room } else { 0.5 * high.abs().max(1.0) };
        [low - room, high + room]
    }
}

/// A number beside the axis needs room for itself: not where zero or a limit stands.
fn has_room(scale: &Scale, value: f64, limits: &[f64]) -> bool {
    let taken = limits.iter().copied().chain([0.0]);
    taken.into_iter().all(|other| (scale.y(other) - scale.y(value)).abs() > 11.0)
}

fn band(from: f64, to: f64) -> (f64, f64) {
    let missing = (LEAST_BAND - (to - from)).max(0.0);
    (from - 0.5 * missing, to + 0.5 * missing)
}

/// A length in px, to a tenth.
fn px(value: f64) -> String {
    let text = format!("{value:.1}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

/// The points of a curve in px, without those that lie on the way between their neighbours.
fn polyline(curve: &Curve, scale: &Scale) -> String {
    let mut kept: Vec<[f64; 2]> = Vec::new();
    let known = curve.points.iter().filter(|point| point[1].is_finite());
    for point in known.map(|[t, value]| [scale.x(*t), scale.y(*value)]) {
        if let [.., a, b] = kept[..]
            && (b[1] - a[1]).abs() < 0.05
            && (point[1] - b[1]).abs() < 0.05
        {
            kept.pop();
        }
        kept.push(point);
    }
    kept.iter().map(|[x, y]| format!("{},{}", px(*x), px(*y))).collect::<Vec<_>>().join(" ")
}

/// Three to seven round times of an interval.
fn ticks([from, to]: [f64; 2]) -> Vec<f64> {
    let step = round_step((to - from) / 5.0);
    let first = (from / step).ceil() as i64;
    (first..).map(|k| k as f64 * step).take_while(|t| *t <= to + 1e-9 * step).take(12).collect()
}

/// The least of 1, 2, 5 times a power of ten that is not below `least`.
pub(super) fn round_step(least: f64) -> f64 {
    if !(least.is_finite() && least > 0.0) {
        return 1.0;
    }
    let power = 10_f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0].into_iter().map(|m| m * power).find(|step| *step >= least).unwrap_or(10.0 * power)
}

/// A number with at most three digits that matter after the point, without trailing zeros.
pub(super) fn number(value: f64) -> String {
    let digits = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    let decimals = usize::try_from(2 - digits).unwrap_or(0).min(6);
    let text = format!("{value:.decimals$}");
    if !text.contains('.') {
        return text;
    }
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(points: Vec<[f64; 2]>, limits: Vec<f64>) -> Plot<'static> {
        Plot {
            title: "jerk <of> the shoulder".to_owned(),
            description: String::new(),
            time: [0.0, 2.0],
            size: [260.0, 134.0],
            phases: &[],
            names_phases: false,
            curves: vec![Curve { class: "planned".to_owned(), points }],
            limits,
            violated: vec![[1.0, 1.000_1]],
        }
    }

    #[test]
    fn time_runs_to_the_right_and_values_upwards() {
        let text = plot(vec![[0.0, -1.0], [2.0, 1.0]], Vec::new()).svg().into_string();
        // 54 px are left for numbers; the range has 4 % of room at each end of 100 px.
        assert!(text.contains(r#"points="54,112.3 254,19.7""#), "{text}");
        assert!(text.contains("jerk &lt;of&gt; the shoulder"), "names are escaped");
    }

    #[test]
    fn a_short_violation_is_wide_enough_to_be_seen() {
        let text = plot(vec![[0.0, -1.0], [2.0, 1.0]], Vec::new()).svg().into_string();
        assert!(text.contains(r#"<rect class="violated" x="153" y="16" width="2""#), "{text}");
    }

    #[test]
    fn a_limit_is_in_view_when_the_curve_comes_near_it() {
        let points = vec![[0.0, 0.0], [2.0, 10.0]];
        assert_eq!(plot(points.clone(), vec![-20.0, 20.0]).limits_in_view(), [20.0]);
        assert_eq!(plot(points.clone(), vec![5.0]).limits_in_view(), [5.0]);
        assert!(plot(points, vec![-100.0, 100.0]).limits_in_view().is_empty());
    }

    #[test]
    fn what_lies_on_a_level_line_is_left_out() {
        let level = (0..=100).map(|k| [0.02 * f64::from(k), 1.0]).collect();
        let text = plot(level, Vec::new()).svg().into_string();
        assert_eq!(text.matches(",").count(), 2, "{text}");
    }

    #[test]
    fn numbers_are_short() {
        let shown = [0.0, 0.5, 1.2345, 41_505.3, -330.0, 0.000_123_4].map(number);
        assert_eq!(shown, ["0", "0.5", "1.23", "41505", "-330", "0.000123"]);
        assert_eq!(ticks([1.45, 2.0]), [1.6, 1.8, 2.0]);
    }
}
