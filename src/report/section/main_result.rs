//! What a fit was made for, in a few figures: the load where there is one, else what the recordings determine best.

use crate::outcome::fit::{BaseParameter, Fit};
use crate::outcome::parameter::{Parameter, Source};
use crate::report::escape::{breakable, escape};
use crate::report::number::{ABSENT, interval, significant, with_deviation};
use crate::report::terminal::cut;
use crate::report::terminal_parameters::LOAD;

/// Figures that are shown of what is determined best: two rows of them.
const BEST: usize = 8;

/// Quantities of a load that come first, and what a reader calls them.
const LOAD_FIRST: [(&str, &str); 4] = [
    ("mass", "Mass of the load"),
    ("com_x", "Its centre of mass, x"),
    ("com_y", "Its centre of mass, y"),
    ("com_z", "Its centre of mass, z"),
];

/// A quantity with its uncertainty.
struct Figure {
    /// HTML.
    title: String,
    unit: String,
    value: Option<f64>,
    std_dev: Option<f64>,
    ci95: Option<[f64; 2]>,
}

impl Figure {
    fn of_parameter(title: String, parameter: &Parameter) -> Self {
        Self {
            title,
            unit: parameter.unit.clone(),
            value: parameter.value,
            std_dev: parameter.std_dev,
            ci95: parameter.ci95,
        }
    }

    fn of_combination(combination: &BaseParameter) -> Self {
        Self {
            title: breakable(&cut(&combination.expression)),
            unit: combination.unit.clone(),
            value: combination.value,
            std_dev: combination.std_dev,
            ci95: combination.ci95,
        }
    }

    /// Standard deviation as a share of the value; absent where it says nothing.
    fn relative(&self) -> Option<f64> {
        let relative = self.std_dev? / self.value?.abs();
        relative.is_finite().then_some(relative)
    }

    fn html(&self) -> String {
        let unit = match self.unit.as_str() {
            "" | "1" => String::new(),
            unit => format!(" {}", escape(unit)),
        };
        let value = match (self.value, self.std_dev) {
            (Some(value), Some(std_dev)) => with_deviation(value, std_dev) + &unit,
            (Some(value), None) => significant(value) + &unit,
            (None, _) => ABSENT.to_string(),
        };
        let ends = match (self.value, self.ci95, self.std_dev) {
            (None, ..) => "not determined".to_string(),
            (_, Some(ends), Some(std_dev)) => format!("95 %: {}", interval(ends, std_dev)),
            _ => String::new(),
        };
        format!(
            "<div><dt>{}</dt><dd>{value}<small>{ends}</small></dd></div>\n",
            self.title
        )
    }
}

/// The figures; empty of a fit that determines nothing.
pub(super) fn html(parameters: &[Parameter], fit: &Fit) -> String {
    let (title, figures) = match fit.payload {
        Some(_) => ("The load", of_load(parameters)),
        None => ("Determined best", best(parameters, &fit.base_parameters)),
    };
    if figures.is_empty() {
        return String::new();
    }
    let items: String = figures.iter().map(Figure::html).collect();
    format!("<h3>{title}</h3>\n<dl class=\"figures result\">\n{items}</dl>\n")
}

fn of_load(parameters: &[Parameter]) -> Vec<Figure> {
    let of = |(quantity, title): (&str, &str)| {
        let is_own = |p: &&Parameter| p.name.strip_prefix(LOAD) == Some(quantity);
        let own = parameters.iter().find(is_own)?;
        Some(Figure::of_parameter(title.to_string(), own))
    };
    LOAD_FIRST.into_iter().filter_map(of).collect()
}

/// By their relative deviation; combinations where no parameter is determined by itself.
fn best(parameters: &[Parameter], combinations: &[BaseParameter]) -> Vec<Figure> {
    let of_data = parameters.iter().filter(|p| p.source == Source::Data);
    let own = first(of_data.map(|p| {
        let remark = match p.description.as_str() {
            "" => String::new(),
            words => format!("<small>{}</small>", escape(words)),
        };
        Figure::of_parameter(format!("{}{remark}", breakable(&p.name)), p)
    }));
    match own.is_empty() {
        true => first(combinations.iter().map(Figure::of_combination)),
        false => own,
    }
}

fn first(figures: impl Iterator<Item = Figure>) -> Vec<Figure> {
    let mut all: Vec<Figure> = figures.filter(|f| f.relative().is_some()).collect();
    all.sort_by(|a, b| {
        let relative = |figure: &Figure| figure.relative().unwrap_or(f64::INFINITY);
        relative(a).total_cmp(&relative(b))
    });
    all.truncate(BEST);
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::load::Load;

    fn parameter(name: &str, value: f64, std_dev: f64) -> Parameter {
        Parameter {
            value: Some(value),
            std_dev: Some(std_dev),
            ci95: Some([value - 1.96 * std_dev, value + 1.96 * std_dev]),
            source: Source::Data,
            ..Parameter::undetermined(name, "kg")
        }
    }

    #[test]
    fn a_load_is_told_with_its_intervals() {
        let parameters = [
            parameter("a1.coulomb_friction.Fc", 5.0, 1e-6),
            parameter("payload.mass", 125.45, 0.021),
            Parameter::undetermined("payload.com_x", "m"),
        ];
        let fit = Fit {
            payload: Some(Load {
                possible: None,
                principal: Vec::new(),
                undetermined: Vec::new(),
            }),
            ..Fit::default()
        };
        let html = html(&parameters, &fit);
        assert!(html.contains("125.450 ± 0.021 kg<small>95 %: 125.409 to 125.491</small>"));
        assert!(html.contains("–<small>not determined</small>"));
        assert!(!html.contains("coulomb"));
    }

    #[test]
    fn the_smallest_relative_deviations_come_first() {
        let parameters = [
            parameter("a1.x.rough", 1.0, 0.5),
            parameter("a1.x.fine", 100.0, 0.1),
            Parameter::known("a1.x.given", "kg", 1.0),
        ];
        let html = html(&parameters, &Fit::default()).replace("<wbr>", "");
        assert!(html.find("a1.x.fine").unwrap() < html.find("a1.x.rough").unwrap());
        assert!(!html.contains("given"));
    }

    #[test]
    fn combinations_stand_for_parameters_that_are_not_determined() {
        let parameters = [Parameter::undetermined("link1.mass", "kg")];
        let fit = Fit {
            base_parameters: vec![BaseParameter {
                expression: "link1.mass + link2.mass".to_string(),
                unit: "kg".to_string(),
                value: Some(12.0),
                std_dev: Some(0.1),
                ci95: None,
            }],
            ..Fit::default()
        };
        assert!(html(&parameters, &fit).contains("12.00 ± 0.10 kg"));
    }
}
