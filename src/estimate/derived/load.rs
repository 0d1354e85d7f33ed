//! The load as a body: principal moments and axes of inertia, and whether a body can have its parameters.
//!
//! `I_c = Σ_k λ_k a_k a_kᵀ`, and to first order `dλ_k = a_kᵀ dI_c a_k`. A body with these parameters exists
//! if `m > 0` and no λ exceeds the sum of the other two, which is a positive definite pseudo-inertia
//! (Wensing, Kim and Slotine 2018).

use crate::outcome::estimate::Estimate;
use crate::outcome::load::{Load, PrincipalMoment};
use crate::outcome::parameter::Source;
use crate::stats::distribution::Distribution;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Prefix of the names of a load's parameters.
const OWNER: &str = "payload.";

/// Entries of the tensor by the names under which they are reported.
const ENTRIES: [(&str, usize, usize); 6] = [
    ("payload.inertia_xx", 0, 0),
    ("payload.inertia_xy", 0, 1),
    ("payload.inertia_xz", 0, 2),
    ("payload.inertia_yy", 1, 1),
    ("payload.inertia_yz", 1, 2),
    ("payload.inertia_zz", 2, 2),
];

/// The load of an estimate; `None` where the model has none.
pub fn describe(estimate: &Estimate) -> Option<Load> {
    let all = estimate.parameters.iter();
    let own: Vec<_> = all.filter(|p| p.name.starts_with(OWNER)).collect();
    if own.is_empty() {
        return None;
    }
    let undetermined = own.iter().filter(|p| p.source == Source::Undetermined);
    let mut load = Load {
        possible: None,
        principal: Vec::new(),
        undetermined: undetermined.map(|p| p.name.clone()).collect(),
    };
    let value = |name: &str| own.iter().find(|p| p.name == name).and_then(|p| p.value);
    let mut tensor = Matrix3::zeros();
    for (name, a, b) in ENTRIES {
        let Some(entry) = value(name) else {
            return Some(load);
        };
        tensor[(a, b)] = entry;
        tensor[(b, a)] = entry;
    }
    let Some(mass) = value("payload.mass") else {
        return Some(load);
    };
    let eigen = SymmetricEigen::new(tensor);
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
    let principal = order.map(|k| {
        let axis: Vector3<f64> = eigen.eigenvectors.column(k).into_owned();
        moment(estimate, eigen.eigenvalues[k], axis)
    });
    load.possible = Some(mass > 0.0 && principal[0].value < eigen.eigenvalues.sum() / 2.0);
    load.principal = principal.to_vec();
    Some(load)
}

fn moment(estimate: &Estimate, value: f64, axis: Vector3<f64>) -> PrincipalMoment {
    let slopes = ENTRIES.map(|(_, a, b)| if a == b { 1.0 } else { 2.0 } * axis[a] * axis[b]);
    let covariance = &estimate.covariance;
    let position = |name: &str| covariance.parameters.iter().position(|p| p == name);
    let positions = ENTRIES.map(|(name, ..)| position(name));
    // Known entries have no row and no variance.
    let mut variance = 0.0;
    for (row, by_row) in positions.iter().zip(slopes) {
        for (column, by_column) in positions.iter().zip(slopes) {
            if let (Some(i), Some(j)) = (row, column) {
                variance += by_row * covariance.matrix[*i][*j] * by_column;
            }
        }
    }
    let uncertain = positions.iter().any(Option::is_some);
    let std_dev = uncertain.then(|| variance.max(0.0).sqrt());
    let sign = axis[axis.iamax()].signum();
    PrincipalMoment {
        value,
        std_dev,
        ci95: std_dev.map(|s| {
            let half = Distribution::Normal.two_sided(0.95) * s;
            [value - half, value + half]
        }),
        axis: (axis * sign).into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::estimate::Covariance;
    use crate::outcome::parameter::Parameter;
    use nalgebra::Rotation3;

    fn estimate(mass: f64, tensor: &Matrix3<f64>, variance: f64) -> Estimate {
        let entries = ENTRIES.iter();
        let mut parameters: Vec<Parameter> = entries
            .map(|&(name, a, b)| Parameter::known(name, "kg·m²", tensor[(a, b)]))
            .collect();
        parameters.push(Parameter::known("payload.mass", "kg", mass));
        let row = |k: usize| {
            (0..6)
                .map(|j| if j == k { variance } else { 0.0 })
                .collect()
        };
        Estimate {
            parameters,
            covariance: Covariance {
                parameters: ENTRIES.iter().map(|e| e.0.to_string()).collect(),
                matrix: (0..6).map(row).collect(),
            },
            ..Estimate::default()
        }
    }

    #[test]
    fn recovers_known_truth_of_a_turned_body() {
        let turn = Rotation3::from_euler_angles(0.3, -0.8, 1.1);
        let tensor = turn * Matrix3::from_diagonal(&[4.0, 2.0, 3.0].into()) * turn.transpose();
        let load = describe(&estimate(5.0, &tensor, 0.01)).unwrap();
        assert_eq!(load.possible, Some(true));
        for (found, (value, axis)) in load.principal.iter().zip([(4.0, 0), (3.0, 2), (2.0, 1)]) {
            assert!((found.value - value).abs() < 1e-12);
            let along = turn.matrix().column(axis).dot(&Vector3::from(found.axis));
            assert!((along.abs() - 1.0).abs() < 1e-12);
            // Σ (∂λ/∂I_ab)² with the products counted twice lies between 1 and 2 for a unit vector.
            assert!((0.1..=0.1 * 2f64.sqrt()).contains(&found.std_dev.unwrap()));
        }
    }

    #[test]
    fn no_body_has_a_moment_above_the_sum_of_the_others() {
        let tensor = Matrix3::from_diagonal(&[4.0, 1.0, 2.0].into());
        assert_eq!(
            describe(&estimate(5.0, &tensor, 0.0)).unwrap().possible,
            Some(false)
        );
        let tensor = Matrix3::from_diagonal(&[4.0, 3.0, 2.0].into());
        assert_eq!(
            describe(&estimate(-5.0, &tensor, 0.0)).unwrap().possible,
            Some(false)
        );
        assert_eq!(
            describe(&estimate(5.0, &tensor, 0.0)).unwrap().possible,
            Some(true)
        );
    }
}
