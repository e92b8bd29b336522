//! How the viewer shows it.

use rerun::{
    blueprint::{
        Blueprint, BlueprintPanel, ContainerLike, Horizontal, SelectionPanel, Spatial3DView,
        StateTimelineView, Tabs, TextDocumentView, TextLogView, TimePanel, TimeSeriesView, Vertical,
        components::{LoopMode, PanelState, PlayState},
    },
    time::TimeInt,
};

use crate::{Run, TIMELINE, nanoseconds, plots, verdict::Verdict};

/// Shown before and after the first violation when it is selected, s.
const AROUND_VIOLATION: f64 = 0.15;

/// ```text
/// Horizontal [5 : 4]
/// ├ Vertical [3 : 1.3]   Scene; Phases and checks
/// └ Vertical             Verdict; Clearance; Share of limit; Tabs of Events and curves
/// ```
pub(crate) fn blueprint(run: &Run) -> Blueprint {
    let scene = Spatial3DView::new("Scene").with_origin("world");
    let lanes = StateTimelineView::new("Phases and checks").with_origin("state");
    let left = Vertical::new([scene.into(), lanes.into()]).with_row_shares([3.0, 1.3]);

    let mut right: Vec<(ContainerLike, f32)> = Vec::new();
    if run.verdict.is_some() {
        right.push((TextDocumentView::new("Verdict").with_origin("verdict").into(), 1.95));
    }
    if plots::has_clearance(run) {
        right.push((curves("Clearance beyond what is required [mm]", "plot/clearance"), 0.85));
    }
    if !run.recording.monitor.is_empty() {
        right.push((curves("Share of limit, worst joint [%]", "plot/share"), 1.15));
    }
    let mut tabs: Vec<ContainerLike> = vec![TextLogView::new("Events").with_origin("events").into()];
    if !run.recording.measured.is_empty() {
        tabs.push(curves("Position", "joints/position"));
        tabs.push(curves("Velocity", "joints/velocity"));
        tabs.push(curves("Effort", "joints/effort"));
    }
    if !run.recording.monitor.is_empty() {
        tabs.push(curves("Tracking [mm]", "plot/tracking"));
        tabs.push(curves("Gripper", "plot/gripper"));
    }
    right.push((Tabs::new(tabs).into(), 1.1));
    let (views, shares): (Vec<_>, Vec<_>) = right.into_iter().unzip();

    let mut time = TimePanel::new()
        .with_state(PanelState::Collapsed)
        .with_timeline(TIMELINE)
        .with_play_state(PlayState::Paused);
    if let Some([first, last]) = run.verdict.and_then(Verdict::first_violation) {
        let at = |seconds: f64| TimeInt::new_temporal(nanoseconds(seconds).clamp(0, run.end_ns));
        time = time
            .with_loop_mode(LoopMode::Selection)
            .with_time_selection(at(first - AROUND_VIOLATION)..=at(last + AROUND_VIOLATION));
    }
    Blueprint::new(
        Horizontal::new([left.into(), Vertical::new(views).with_row_shares(shares).into()])
            .with_column_shares([5.0, 4.0]),
    )
    .with_blueprint_panel(BlueprintPanel::from_state(PanelState::Hidden))
    .with_selection_panel(SelectionPanel::from_state(PanelState::Hidden))
    .with_time_panel(time)
    .with_auto_views(false)
    .with_auto_layout(false)
}

fn curves(name: &str, origin: &str) -> ContainerLike {
    TimeSeriesView::new(name).with_origin(origin).into()
}
