//! The vocabulary of physics as a page in Markdown, and a picture of each law.

use plotters::style::RGBColor;

use crate::chain::effect::{EFFECTS, Effect};
use crate::chain::error::ModelError;
use crate::chain::illustration::{Curve, Illustration, illustrate};
use crate::report::number::significant;
use crate::report::plots::curves::{Curve as Line, curves};
use crate::report::plots::{KIND, PREDICTED, RECORDED, RESIDUAL};
use crate::robot::tree::JointKind;

/// Points of a curve in a picture: every so many samples are enough for half a page's width.
const POINTS: usize = 800;

/// Colours of the effect at the multiples of its first parameter.
const COLOURS: [RGBColor; 3] = [KIND, PREDICTED, RESIDUAL];

const HEAD: &str = "# Catalogue of effects

`exid effects --markdown` prints this page and `exid effects --plots FOLDER` draws its pictures, both from the table that every
command uses. A law gives the torque that the motor has to exert in addition; v is the motor's speed at joint scale, τ_M the
torque that the gear transmits, and sign(v) stands for v/(|v| + w) with the transition speed w of the joint's Coulomb friction.

Pictures show what an effect adds to the torque of one joint of a two-link arm along a motion of two harmonics, over the
variable that it varies with first: at three quarters (violet), once (blue) and five quarters (orange) of the typical value of its
first parameter, within its bounds. Grey is what the effects that it refines or borrows from add by themselves. Units in brackets are
those of sliding joints.

";

/// Every effect: law, source, parameters, what it is confounded with; pictures are expected in `folder`, relative to the page.
pub fn markdown(folder: &str) -> String {
    let mut text = HEAD.to_owned();
    text.push_str("| effect | |\n|---|---|\n");
    for effect in EFFECTS {
        text.push_str(&format!(
            "| [`{0}`](#{0}) | {1} |\n",
            effect.id, effect.sentence
        ));
    }
    for effect in EFFECTS {
        text.push_str(&section(effect, folder));
    }
    text
}

fn section(effect: &Effect, folder: &str) -> String {
    let id = effect.id;
    let depends: Vec<&str> = effect.depends_on.iter().map(|d| d.word()).collect();
    let mut text = format!(
        "\n## {id}\n\n{}\n\n```text\n{}\n```\n\n![{}]({folder}/{id}.svg)\n\nVaries with: {}. Source: {}.\n\n\
         | parameter | unit | meaning | typical | bounds |\n|---|---|---|---|---|\n",
        effect.sentence,
        effect.equation,
        caption(effect),
        depends.join(", "),
        effect.source
    );
    for info in effect.parameters {
        let turning = info.unit.of(JointKind::Revolute);
        let sliding = info.unit.of(JointKind::Prismatic);
        let unit = match turning == sliding {
            true => turning.to_owned(),
            false => format!("{turning} ({sliding})"),
        };
        text.push_str(&format!(
            "| `{}` | {unit} | {} | {} | {} to {} |\n",
            info.name,
            as_cell(info.meaning),
            info.typical,
            bound(info.lower),
            bound(info.upper)
        ));
    }
    text.push_str("\n| can be mistaken for | told apart by |\n|---|---|\n");
    for confounder in effect.confounded_with {
        text.push_str(&format!(
            "| {} | {} |\n",
            as_cell(confounder.with),
            as_cell(confounder.separated_by)
        ));
    }
    text
}

/// Text as a cell of a table: bars are no borders there.
fn as_cell(text: &str) -> String {
    text.replace('|', "\\|")
}

/// A bound as people write it.
fn bound(x: f64) -> String {
    match x {
        f64::NEG_INFINITY => "−∞".to_owned(),
        f64::INFINITY => "∞".to_owned(),
        x => significant(x),
    }
}

/// What the picture of an effect shows, for those who do not see it.
fn caption(effect: &Effect) -> String {
    format!(
        "Torque that {} adds along the reference motion",
        effect.id.replace('_', " ")
    )
}

/// The picture of a law, a file of its own.
///
/// # Errors
/// Where the effect makes no model.
pub fn picture(effect: &'static Effect) -> Result<String, ModelError> {
    let Illustration {
        variable,
        over,
        curves: found,
    } = illustrate(effect)?;
    let stride = over.len().div_ceil(POINTS);
    let points = |curve: &Curve| {
        let all = over.iter().copied().zip(curve.added.iter().copied());
        all.step_by(stride).collect()
    };
    let colours = COLOURS.iter().copied();
    let mut colours = colours.chain(std::iter::repeat(PREDICTED));
    let colour = |curve: &Curve, next: &mut dyn Iterator<Item = RGBColor>| match curve.first {
        None => RECORDED,
        Some(_) => next.next().unwrap_or(PREDICTED),
    };
    let lines: Vec<Line> = found
        .iter()
        .map(|curve| Line::new(points(curve), colour(curve, &mut colours)))
        .collect();
    let title = format!("added torque [N·m] over {variable}");
    let svg = curves(&lines, &[], &title, &caption(effect));
    Ok(svg.replacen("<svg ", "<svg xmlns=\"http://www.w3.org/2000/svg\" ", 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_has_a_section_and_a_picture() {
        let page = markdown("effects");
        for effect in EFFECTS {
            assert!(page.contains(&format!("\n## {}\n", effect.id)));
            let picture = picture(effect).unwrap();
            assert!(picture.starts_with("<svg xmlns") && picture.ends_with("</svg>\n"));
            let read = roxmltree::Document::parse(&picture).unwrap();
            let lines = read.descendants().filter(|n| n.has_tag_name("polyline"));
            assert!(lines.count() >= 3, "{}", effect.id);
        }
    }
}
