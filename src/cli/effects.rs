//! `exid effects`: the vocabulary of physics.

use crate::chain::effect::{Catalogue, Effect};
use crate::cli::args::Query;
use crate::cli::error::CliError;
use crate::cli::output::print;
use crate::fault::nearest;
use crate::report::catalogue;
use crate::robot::tree::JointKind;
use crate::setup::laws;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// Folder of the pictures beside the page of the catalogue.
const PICTURES: &str = "effects";

pub fn run(query: &Query) -> Result<u8, CliError> {
    let catalogue = match &query.laws {
        None => Catalogue::known(),
        Some(path) => laws::of_files(path)?,
    };
    let effects: Vec<&'static Effect> = match &query.id {
        None => catalogue.effects().to_vec(),
        Some(id) => vec![catalogue.find(id).ok_or_else(|| unknown(&catalogue, id))?],
    };
    if query.markdown {
        print(&catalogue::markdown(PICTURES))?;
    } else if let Some(folder) = &query.plots {
        print(&draw(&effects, folder)?)?;
    } else if query.json {
        let all: Vec<Value> = effects.iter().map(|e| as_json(e)).collect();
        print(&format!("{:#}", Value::Array(all)))?;
    } else {
        let long = query.id.is_some();
        let texts: Vec<String> = effects
            .iter()
            .map(|e| if long { in_full(e) } else { in_short(e) })
            .collect();
        print(&texts.join("\n"))?;
    }
    Ok(0)
}

/// Draws the laws into files of a folder; gives their names, one a line.
fn draw(effects: &[&'static Effect], folder: &Path) -> Result<String, CliError> {
    let not_written = |e: std::io::Error| {
        let folder = folder.display();
        CliError::WrongUse(format!(
            "{folder}: pictures cannot be written: {e}; give another folder with --plots"
        ))
    };
    fs::create_dir_all(folder).map_err(not_written)?;
    let mut names = Vec::new();
    for effect in effects {
        let picture = catalogue::picture(effect).map_err(|e| CliError::WrongUse(e.to_string()))?;
        let file = folder.join(format!("{}.svg", effect.id));
        fs::write(&file, picture).map_err(not_written)?;
        names.push(file.display().to_string());
    }
    Ok(names.join("\n"))
}

fn unknown(catalogue: &Catalogue, id: &str) -> CliError {
    let ids = catalogue.ids();
    let hint = match nearest(id, ids.iter().copied()) {
        Some(near) => format!("; did you mean `{near}`?"),
        None => ".".to_string(),
    };
    CliError::WrongUse(format!(
        "there is no effect `{id}`{hint} The effects are {}",
        ids.join(", ")
    ))
}

fn in_short(effect: &Effect) -> String {
    let names: Vec<&str> = effect.parameters.iter().map(|p| p.name).collect();
    format!(
        "{:<22} {}\n{:<22} {}   [{}]",
        effect.id,
        effect.sentence,
        "",
        effect.equation,
        names.join(", ")
    )
}

fn in_full(effect: &Effect) -> String {
    let mut text = format!(
        "{}\n\n  {}\n\n  law          {}\n  source       {}\n",
        effect.id, effect.sentence, effect.equation, effect.source
    );
    let depends: Vec<&str> = effect.depends_on.iter().map(|d| d.word()).collect();
    text.push_str(&format!(
        "  depends on   {}\n\n  parameters\n",
        depends.join(", ")
    ));
    for info in effect.parameters {
        let turning = info.unit.of(JointKind::Revolute);
        let sliding = info.unit.of(JointKind::Prismatic);
        let unit = if turning == sliding {
            turning.to_string()
        } else {
            format!("{turning} ({sliding})")
        };
        text.push_str(&format!(
            "    {:<14} {unit:<20} {}\n",
            info.name, info.meaning
        ));
    }
    if !effect.confounded_with.is_empty() {
        text.push_str("\n  can be mistaken for\n");
    }
    for confounder in effect.confounded_with {
        text.push_str(&format!(
            "    {}\n      told apart by {}\n",
            confounder.with, confounder.separated_by
        ));
    }
    text
}

fn as_json(effect: &Effect) -> Value {
    let finite = |x: f64| if x.is_finite() { json!(x) } else { Value::Null };
    let parameters: Vec<Value> = effect
        .parameters
        .iter()
        .map(|p| {
            json!({
                "name": p.name,
                "unit": p.unit.of(JointKind::Revolute),
                "unit_sliding": p.unit.of(JointKind::Prismatic),
                "meaning": p.meaning,
                "lower": finite(p.lower),
                "upper": finite(p.upper),
                "typical": p.typical,
            })
        })
        .collect();
    let confounded: Vec<Value> = effect
        .confounded_with
        .iter()
        .map(|c| json!({ "with": c.with, "separated_by": c.separated_by }))
        .collect();
    let depends: Vec<&str> = effect.depends_on.iter().map(|d| d.word()).collect();
    json!({
        "id": effect.id,
        "sentence": effect.sentence,
        "law": effect.equation,
        "source": effect.source,
        "parameters": parameters,
        "depends_on": depends,
        "confounded_with": confounded,
    })
}
