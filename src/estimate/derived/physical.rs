//! Physical parameters from the raw parameters of an estimate: mass, centre of mass, inertia about the centre of mass, constants
//! of effects, each with its uncertainty and with what determines it.
//!
//! `c = h/m`, `I_c = I − m (cᵀc·1 − c cᵀ)`; standard deviations by first-order propagation.

use crate::chain::effect;
use crate::chain::model::Model;
use crate::chain::parameter::{Parameter, Role, State};
use crate::estimate::fit_problem::unknowns::Unknowns;
use crate::outcome::estimate::Covariance;
use crate::outcome::parameter::{Parameter as Reported, Source};
use crate::robot::inertia::{PER_LINK, REPORTED, TENSOR};
use crate::stats::distribution::Distribution;
use nalgebra::{DMatrix, DVector, RowDVector};

/// Coverage of the intervals that are reported.
pub(in crate::estimate) const COVERAGE: f64 = 0.95;

/// An estimate before it is reported.
#[derive(Debug, Clone, Copy)]
pub struct Estimated<'a> {
    /// Says which parameters belong to which body or effect.
    pub model: &'a Model,
    /// What was estimated, and in which order.
    pub unknowns: &'a Unknowns,
    /// Values of all parameters.
    pub values: &'a DVector<f64>,
    /// Covariance of the unknowns in their order.
    pub covariance: &'a DMatrix<f64>,
    /// The part of it that noise makes, where there is another.
    pub statistical: Option<&'a DMatrix<f64>>,
    /// Unknowns that only a prior determines.
    pub from_prior: &'a [usize],
    /// Unknowns that lie at a bound, as variables of the estimate.
    pub at_bound: &'a [usize],
    /// Intervals of unknowns that are not those of normal errors.
    pub intervals: &'a [Option<[f64; 2]>],
}

struct Quantity {
    name: String,
    unit: String,
    description: String,
    shared_by: Vec<String>,
    /// `None`: the data do not determine it.
    value: Option<f64>,
    /// Derivatives with respect to raw parameters.
    gradient: Vec<(usize, f64)>,
}

impl Quantity {
    fn undetermined(&self) -> Reported {
        Reported::undetermined(&self.name, &self.unit)
            .described(&self.description)
            .shared_by(self.shared_by.clone())
    }
}

/// Physical parameters with their covariance.
#[derive(Debug, Clone)]
pub struct PhysicalEstimate {
    /// With value, standard deviation, interval and source.
    pub parameters: Vec<Reported>,
    /// Of those that have a standard deviation.
    pub covariance: Covariance,
}

/// Every quantity that is reported, and their covariance.
pub fn report(estimated: &Estimated<'_>) -> PhysicalEstimate {
    let quantities = quantities(estimated);
    let positions = estimated.unknowns.positions();
    let mut reported = Vec::with_capacity(quantities.len());
    let mut names = Vec::new();
    let mut gradients: Vec<RowDVector<f64>> = Vec::new();
    for quantity in quantities {
        let mut row = RowDVector::zeros(positions.len());
        let mut from: Vec<usize> = Vec::new();
        for &(parameter, slope) in &quantity.gradient {
            if let Some(k) = positions.iter().position(|&p| p == parameter) {
                row[k] += slope;
                from.push(k);
            }
        }
        let parameter = one(&quantity, &row, &from, estimated);
        if parameter.std_dev.is_some() {
            names.push(parameter.name.clone());
            gradients.push(row);
        }
        reported.push(parameter);
    }
    let jacobian = if gradients.is_empty() {
        DMatrix::zeros(0, positions.len())
    } else {
        DMatrix::from_rows(&gradients)
    };
    let matrix = &jacobian * finite(estimated.covariance) * jacobian.transpose();
    let rows = matrix.row_iter().map(|row| row.iter().copied().collect());
    let covariance = Covariance {
        parameters: names,
        matrix: rows.collect(),
    };
    PhysicalEstimate {
        parameters: reported,
        covariance,
    }
}

/// The covariance without the infinite variances of what nothing determines, which has no quantity.
fn finite(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    covariance.map(|v| if v.is_finite() { v } else { 0.0 })
}

/// One reported parameter; it has a standard deviation where the data or a prior determine it.
fn one(
    quantity: &Quantity,
    row: &RowDVector<f64>,
    from: &[usize],
    estimated: &Estimated<'_>,
) -> Reported {
    let Some(value) = quantity.value else {
        return quantity.undetermined();
    };
    let known = Reported::known(&quantity.name, &quantity.unit, value)
        .described(&quantity.description)
        .shared_by(quantity.shared_by.clone());
    if from.is_empty() {
        return known;
    }
    let at_bound = from.iter().any(|k| estimated.at_bound.contains(k));
    if at_bound {
        return Reported {
            source: Source::Bound,
            ..known
        };
    }
    if from
        .iter()
        .any(|&k| !estimated.covariance[(k, k)].is_finite())
    {
        return quantity.undetermined();
    }
    let deviation = |covariance: &DMatrix<f64>| {
        let variance = (row * finite(covariance) * row.transpose())[(0, 0)];
        variance.max(0.0).sqrt()
    };
    let std_dev = deviation(estimated.covariance);
    let half = Distribution::Normal.two_sided(COVERAGE) * std_dev;
    let own = match from[..] {
        [k] if row[k] == 1.0 => estimated.intervals.get(k).copied().flatten(),
        _ => None,
    };
    let prior = from.iter().any(|k| estimated.from_prior.contains(k));
    Reported {
        std_dev: Some(std_dev),
        std_dev_statistical: estimated.statistical.map(deviation),
        ci95: Some(own.unwrap_or([value - half, value + half])),
        source: if prior { Source::Prior } else { Source::Data },
        ..known
    }
}

fn quantities(estimated: &Estimated<'_>) -> Vec<Quantity> {
    let model = estimated.model;
    let mut out = Vec::new();
    let weightless = |link: usize| model.mechanism().is_some_and(|m| m.is_massless(link));
    for (link, joint) in model.tree().joints().iter().enumerate() {
        if weightless(link) {
            continue;
        }
        body(estimated, &joint.link, PER_LINK * link, &mut out);
    }
    if let Some((_, first)) = model.payload() {
        body(estimated, "payload", first, &mut out);
    }
    for (p, parameter) in model.parameters().iter().enumerate() {
        let is_shared = matches!(parameter.state, State::Shared(_));
        let of_body = matches!(parameter.role, Role::Inertial { .. } | Role::Payload { .. });
        if !of_body && !is_shared {
            out.push(Quantity {
                name: parameter.name.clone(),
                unit: parameter.unit.clone(),
                description: meaning(model, parameter),
                shared_by: sharing_joints(model, p),
                value: determined(estimated, p).then_some(estimated.values[p]),
                gradient: vec![(p, 1.0)],
            });
        }
    }
    out
}

/// Names of the joints that have a parameter in common; none of a parameter of one joint.
fn sharing_joints(model: &Model, parameter: usize) -> Vec<String> {
    let all = model.sharing(parameter);
    if all.len() < 2 {
        return Vec::new();
    }
    let joint = |p: &usize| match model.parameters()[*p].role {
        Role::Effect { joint, .. } => Some(model.joints()[joint].name.clone()),
        _ => None,
    };
    all.iter().filter_map(joint).collect()
}

fn meaning(model: &Model, parameter: &Parameter) -> String {
    match parameter.role {
        Role::Effect {
            joint,
            effect,
            parameter,
        } => {
            let (effect, _) = model.joints()[joint].effects[effect];
            effect.parameters[parameter].meaning.to_string()
        }
        Role::Controller { gain, .. } => gain.meaning().to_string(),
        Role::Tilt { angle } => effect::TILT.parameters[angle].meaning.to_string(),
        _ => "speed of this joint per speed of the other joint's motor".to_string(),
    }
}

/// Known, or determined by data or prior by itself.
fn determined(estimated: &Estimated<'_>, parameter: usize) -> bool {
    let entry = &estimated.model.parameters()[parameter];
    !entry.is_free()
        || estimated.unknowns.nonlinear.contains(&parameter)
        || estimated.unknowns.base.determines(parameter)
}

/// The ten quantities of a body whose raw parameters start at `first`.
fn body(estimated: &Estimated<'_>, name: &str, first: usize, out: &mut Vec<Quantity>) {
    let raw: [f64; PER_LINK] = std::array::from_fn(|k| estimated.values[first + k]);
    let has = |entries: &[usize]| entries.iter().all(|&k| determined(estimated, first + k));
    let m = raw[0];
    let is_free = |k: usize| estimated.model.parameters()[first + k].is_free();
    // First moments that are known to be zero make a centre zero and no part of a tensor, whatever the mass is.
    let is_none = |k: usize| raw[k] == 0.0 && !is_free(k) && (m != 0.0 || is_free(0));
    let mut push = |index: usize, needs: &[usize], value: f64, gradient: Vec<(usize, f64)>| {
        let (quantity, unit) = REPORTED[index];
        out.push(Quantity {
            name: format!("{name}.{quantity}"),
            unit: unit.to_string(),
            description: String::new(),
            shared_by: Vec::new(),
            value: (has(needs) && value.is_finite()).then_some(value),
            gradient: gradient.into_iter().map(|(k, d)| (first + k, d)).collect(),
        });
    };
    push(0, &[0], m, vec![(0, 1.0)]);
    for axis in 0..3 {
        let h = raw[1 + axis];
        if is_none(1 + axis) {
            push(1 + axis, &[1 + axis], 0.0, Vec::new());
            continue;
        }
        let gradient = vec![(1 + axis, 1.0 / m), (0, -h / (m * m))];
        push(1 + axis, &[0, 1 + axis], h / m, gradient);
    }
    for (index, (a, b, entry)) in TENSOR.into_iter().enumerate() {
        let (value, mut gradient) = (raw[entry], vec![(entry, 1.0)]);
        let mut needs = vec![entry];
        // Products h_i h_j / m that Steiner's theorem takes away, with their signs.
        let products: Vec<(usize, usize, f64)> = if a == b {
            (0..3).filter(|&k| k != a).map(|k| (k, k, -1.0)).collect()
        } else {
            vec![(a, b, 1.0)]
        };
        let mut central = value;
        for (i, j, sign) in products {
            if is_none(1 + i) || is_none(1 + j) {
                continue;
            }
            let (hi, hj) = (raw[1 + i], raw[1 + j]);
            central += sign * hi * hj / m;
            gradient.push((1 + i, sign * hj / m));
            gradient.push((1 + j, sign * hi / m));
            gradient.push((0, -sign * hi * hj / (m * m)));
            needs.extend([0, 1 + i, 1 + j]);
        }
        push(4 + index, &needs, central, gradient);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::base_parameters::BaseParameters;
    use crate::chain::model::{ModelSettings, Signal};
    use crate::robot::urdf;
    use std::path::Path;

    const ARM: &str = r#"<robot name="arm"><link name="base"/><link name="a"/><link name="b"/>
<joint name="j1" type="continuous"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/></joint>
<joint name="j2" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/></joint>
</robot>"#;

    fn arm() -> Model {
        let tree = urdf::parse(ARM, Path::new("arm.urdf")).unwrap();
        Model::new(ModelSettings::bodies(tree, Signal::Torque)).unwrap()
    }

    /// Two bodies without any symmetry.
    fn values() -> DVector<f64> {
        let body = [2.0, 0.3, -0.2, 0.5, 0.4, 0.03, -0.02, 0.35, 0.05, 0.3];
        let other = body.map(|x| 1.7 * x - 0.1);
        DVector::from_iterator(2 * PER_LINK, body.into_iter().chain(other))
    }

    /// Where all raw parameters are determined.
    fn quantities_of(model: &Model, values: &DVector<f64>) -> Vec<Quantity> {
        let none = DMatrix::zeros(0, values.len());
        let unknowns = Unknowns {
            base: BaseParameters::structural(model, &[false], &none),
            nonlinear: (0..values.len()).collect(),
        };
        let found = quantities(&Estimated {
            model,
            unknowns: &unknowns,
            values,
            covariance: &DMatrix::zeros(0, 0),
            statistical: None,
            from_prior: &[],
            at_bound: &[],
            intervals: &[],
        });
        assert_eq!(found.len(), 2 * PER_LINK);
        found
    }

    /// A first moment that is known, other than zero, gives a centre; one that is estimated as zero is not known.
    #[test]
    fn only_what_is_known_to_be_zero_is_left_out() {
        let (mut model, mut values) = (arm(), values());
        let moment = model.find("a.mcx").unwrap();
        model.fix(moment, values[moment]).unwrap();
        let first = model.find("a.m").unwrap();
        values[first + 2] = 0.0;
        let found = quantities_of(&model, &values);
        let [x, y] = [1, 2].map(|k| &found[k]);
        assert_eq!((x.name.as_str(), x.value), ("a.com_x", Some(0.15)));
        assert_eq!((y.name.as_str(), y.value), ("a.com_y", Some(0.0)));
        assert_eq!(y.gradient[0], (first + 2, 0.5));
    }

    /// What standard deviations are propagated by, against central differences.
    #[test]
    fn matches_differences_of_every_quantity() {
        let (model, values) = (arm(), values());
        let of = |values: &DVector<f64>| quantities_of(&model, values);
        let step = 1e-6;
        for (index, quantity) in of(&values).into_iter().enumerate() {
            for p in 0..values.len() {
                let at = |by: f64| {
                    let mut values = values.clone();
                    values[p] += by;
                    of(&values)[index].value.unwrap()
                };
                let expected = (at(step) - at(-step)) / (2.0 * step);
                let own = quantity.gradient.iter().filter(|(of, _)| *of == p);
                let found: f64 = own.map(|(_, slope)| slope).sum();
                assert!((found - expected).abs() < 1e-8, "{} {p}", quantity.name);
            }
        }
    }
}
