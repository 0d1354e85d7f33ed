//! The script of the page: modules in the order in which they use each other, in a scope of their own, and its digest for the policy.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest, Sha256};

/// The library that draws charts, and its licence, which goes with every copy.
const CHARTS: &str = include_str!("vendor/uplot/uPlot.iife.min.js");
const CHARTS_LICENCE: &str = include_str!("vendor/uplot/LICENSE");

const MODULES: [&str; 9] = [
    include_str!("page/data.js"),
    include_str!("page/theme.js"),
    include_str!("page/chart.js"),
    include_str!("page/robot.js"),
    include_str!("page/dependence.js"),
    include_str!("page/explorer.js"),
    include_str!("page/correlations.js"),
    include_str!("page/tables.js"),
    include_str!("page/main.js"),
];

/// The text of the script.
pub(super) fn text() -> String {
    format!(
        "/* uPlot\n{CHARTS_LICENCE}\n*/\n{CHARTS}\n(() => {{\n\"use strict\";\n{}}})();\n",
        MODULES.join("\n")
    )
}

/// What a content policy names a script by.
pub(super) fn digest(script: &str) -> String {
    format!(
        "sha256-{}",
        STANDARD.encode(Sha256::digest(script.as_bytes()))
    )
}
