//! Intervals of a fit whose transition speeds are held where the motion shows them, of joints that move too slowly for that.
//!
//! ```text
//! E (x − x₀)(x − x₀)ᵀ = C_w + (x − x_w)(x − x_w)ᵀ
//! ```
//!
//! with the fit x, the truth x₀, and a fit x_w of wider transitions with its covariance C_w, which knows no more than the recordings
//! say. The narrower fit forecasts other motions better, and its own covariance would take its limit for knowledge.

use crate::estimate::derived::physical::COVERAGE;
use crate::estimate::fit::Fitted;
use crate::outcome::estimate::Covariance;
use crate::outcome::fit::BaseParameter;
use crate::outcome::parameter::{Parameter, Source};
use crate::stats::distribution::Distribution;

/// Gives a fit the intervals that a fit with wider transitions of the friction of joints allows; says so. `None` where no joint of
/// these has a parameter from the recordings.
pub fn admit(fitted: &mut Fitted, wider: &Fitted, joints: &[usize]) -> Option<String> {
    let names = joints
        .iter()
        .map(|&j| fitted.model.joints()[j].name.clone());
    let estimated = |name: &String| {
        let of_joint = |p: &Parameter| p.name.split_once('.').is_some_and(|(own, _)| own == name);
        let parameters = fitted.estimate.parameters.iter();
        parameters
            .filter(|p| p.source == Source::Data)
            .any(of_joint)
    };
    let names: Vec<String> = names.filter(estimated).collect();
    if names.is_empty() {
        return None;
    }
    fitted.estimate.covariance = covariance(fitted, wider);
    for parameter in &mut fitted.estimate.parameters {
        let other = wider.estimate.find(&parameter.name);
        if let (Source::Data, Some(other)) = (parameter.source, other) {
            admit_parameter(parameter, other);
        }
    }
    for combination in &mut fitted.fit.base_parameters {
        let same = |other: &&BaseParameter| other.expression == combination.expression;
        if let Some(other) = wider.fit.base_parameters.iter().find(same) {
            let estimate = Estimated::of(combination.value, combination.std_dev);
            let std_dev = estimate.beside(Estimated::of(other.value, other.std_dev));
            combination.std_dev = std_dev;
            combination.ci95 = interval(combination.value, std_dev);
        }
    }
    Some(format!(
        "The motion of {} is too slow to tell dry from viscous friction. How fast dry friction turns with speed was kept to what the \
         motion shows, and intervals hold what slower turns would give.",
        names.join(", ")
    ))
}

/// An estimate with its standard deviation, where it has them.
#[derive(Clone, Copy)]
struct Estimated(Option<[f64; 2]>);

impl Estimated {
    fn of(value: Option<f64>, std_dev: Option<f64>) -> Self {
        Self(value.zip(std_dev).map(|(value, std_dev)| [value, std_dev]))
    }

    /// The deviation from the truth that another estimate, which knows less, gives it.
    fn beside(self, other: Self) -> Option<f64> {
        let ([value, _], [wider, std_dev]) = self.0.zip(other.0)?;
        Some(std_dev.hypot(value - wider))
    }
}

fn admit_parameter(parameter: &mut Parameter, other: &Parameter) {
    let estimate = Estimated::of(parameter.value, parameter.std_dev);
    let std_dev = estimate.beside(Estimated::of(other.value, other.std_dev));
    *parameter = match std_dev {
        Some(_) => Parameter {
            std_dev,
            std_dev_statistical: parameter
                .std_dev_statistical
                .and(estimate.beside(Estimated::of(other.value, other.std_dev_statistical))),
            ci95: interval(parameter.value, std_dev),
            ..parameter.clone()
        },
        None => Parameter {
            description: parameter.description.clone(),
            shared_by: parameter.shared_by.clone(),
            ..Parameter::undetermined(&parameter.name, &parameter.unit)
        },
    };
}

fn interval(value: Option<f64>, std_dev: Option<f64>) -> Option<[f64; 2]> {
    let half = Distribution::Normal.two_sided(COVERAGE) * std_dev?;
    value.map(|value| [value - half, value + half])
}

/// C_w + (x − x_w)(x − x_w)ᵀ over the parameters of both, and the fit's own over others.
fn covariance(fitted: &Fitted, wider: &Fitted) -> Covariance {
    let (own, other) = (&fitted.estimate.covariance, &wider.estimate.covariance);
    let value = |fit: &Fitted, name: &str| fit.estimate.find(name)?.value;
    let place = |name: &String| {
        let at = other.parameters.iter().position(|known| known == name)?;
        Some((at, value(fitted, name)? - value(wider, name)?))
    };
    let places: Vec<Option<(usize, f64)>> = own.parameters.iter().map(place).collect();
    let entry = |r: usize, c: usize| match (places[r], places[c]) {
        (Some((i, x)), Some((j, y))) => other.matrix[i][j] + x * y,
        _ => own.matrix[r][c],
    };
    let count = own.parameters.len();
    let row = |r: usize| (0..count).map(|c| entry(r, c)).collect();
    Covariance {
        parameters: own.parameters.clone(),
        matrix: (0..count).map(row).collect(),
    }
}
