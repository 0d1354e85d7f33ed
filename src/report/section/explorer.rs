//! Where the script puts its charts, and the still pictures that stand there without a script.

use crate::report::escape::escape;
use crate::report::section::Source;

/// The explorer, which opens at `joint` where that is given; `still` is HTML for readers without a script.
pub(super) fn explorer(source: &Source, joint: Option<&str>, still: &str) -> String {
    if !source.exploration.has_takes() {
        return still.to_string();
    }
    let opens_at = joint.map_or(String::new(), |joint| {
        format!(" data-joint=\"{}\"", escape(joint))
    });
    format!(
        "<p class=\"hint\">Drag over a stretch to zoom, double-click for all of it; with Shift, drag to move along and turn the wheel to \
         zoom. All charts show the same times.</p>\n<div id=\"explorer\" class=\"explorer\"{opens_at}></div>\n\
         <noscript>\n{still}</noscript>\n"
    )
}
