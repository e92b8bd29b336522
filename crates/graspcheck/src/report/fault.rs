//! Faults of files, shown in the source as a compiler shows them.

use annotate_snippets::{
    AnnotationKind, Group, Level, Patch, Renderer, Snippet,
    renderer::{DEFAULT_TERM_WIDTH, DecorStyle},
};
use graspcheck_scenario::{Fault, LoadError, Source};

/// All faults of a scenario and its assets, in order of place, and a last line that counts them.
#[must_use]
pub fn faults(error: &LoadError, styled: bool) -> String {
    let renderer = if styled { Renderer::styled() } else { Renderer::plain() };
    let renderer = renderer.decor_style(DecorStyle::Ascii).term_width(DEFAULT_TERM_WIDTH);
    let mut text = String::new();
    for fault in &error.faults {
        text.push_str(&renderer.render(&groups(fault, &error.sources)));
        text.push_str("\n\n");
    }
    let count = error.faults.len();
    let plural = if count == 1 { "" } else { "s" };
    let subject = error.sources.first().map_or("the scenario", |source| source.path.as_str());
    text.push_str(&format!("error: {subject} has {count} fault{plural}; nothing was run\n"));
    text
}

fn groups<'a>(fault: &'a Fault, sources: &'a [Source]) -> Vec<Group<'a>> {
    let title = Level::ERROR.primary_title(fault.title.as_str()).id(fault.code.as_str());
    // A file that could not be read has no line to show.
    let Some(source) = sources.get(fault.source).filter(|source| !source.text.is_empty()) else {
        return vec![Group::with_title(title)];
    };
    let annotation = AnnotationKind::Primary.span(fault.span.clone()).label(fault.label.as_str());
    let mut group = title
        .element(Snippet::source(source.text.as_str()).path(source.path.as_str()).annotation(annotation));
    if let Some(second) = &fault.second
        && let Some(source) = sources.get(second.source)
    {
        let annotation = AnnotationKind::Context.span(second.span.clone()).label(second.label.as_str());
        group = group
            .element(Snippet::source(source.text.as_str()).path(source.path.as_str()).annotation(annotation));
    }
    let mut groups = vec![group];
    if let Some(help) = &fault.help {
        let title = Level::HELP.secondary_title(help.text.as_str());
        groups.push(match &help.replacement {
            Some(replacement) => title.element(
                Snippet::source(source.text.as_str())
                    .path(source.path.as_str())
                    .patch(Patch::new(fault.span.clone(), replacement.as_str())),
            ),
            None => Group::with_title(title),
        });
    }
    groups
}
