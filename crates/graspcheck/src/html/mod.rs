//! The report of a run as one self-contained page of HTML, and an index of a suite.
//!
//! A page holds the answer first, then one card for each failure (for a run that passes: for its three tightest
//! checks), pictures of the motion, all checks, plots over time, and folded away whatever a reviewer may still ask
//! for. It is made from the evidence of a recording and a verdict alone, reads nothing, and cannot send a request:
//! its content security policy forbids that. The same log gives the same bytes. Its size does not depend on the
//! length of the run, for a plot holds two points for each column of pixels: the least and the greatest value.

mod columns;
mod index;
mod page;
mod picture;
mod plot;
mod plots;

pub use index::{Entry, index};
pub use page::page;

use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = include_str!("style.css");
const CURSOR: &str = include_str!("cursor.js");

/// A page with this title and content, style and script inside it.
fn document(title: &str, content: &Markup) -> String {
    let policy = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(policy);
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                (content)
                script { (PreEscaped(CURSOR)) }
            }
        }
    }
    .into_string()
}
