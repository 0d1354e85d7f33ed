//! Fits find what lies far from where their parameters start.

use crate::chain::dataset::Dataset;
use crate::estimate::fit_problem::estimator::Estimator;
use crate::estimate::tests::{USUAL, WAYS, Way, pendulum, torque, valued};
use crate::recording::split::Split;

/// The order of a ripple has an optimum every half cycle or so: a fit scans it, wherever it is said to start.
#[test]
fn recovers_known_order_of_a_ripple_far_from_its_start() {
    let model = pendulum(&["viscous_friction", "torque_ripple"]);
    let order = model.find("hinge.torque_ripple.order").unwrap();
    for true_order in [7.3, 43.0] {
        let named = [
            ("viscous_friction.Fv", 1.5),
            ("torque_ripple.order", true_order),
            ("torque_ripple.amplitude", 0.6),
            ("torque_ripple.phase", 0.8),
            ("torque_ripple.amplitude2", 0.2),
            ("torque_ripple.phase2", -1.0),
        ];
        let torque = torque(&model, &valued(&model, &named));
        assert!((model.parameters()[order].value - true_order).abs() > 5.0);
        for way in WAYS {
            let recordings = vec![USUAL.record(&torque, (1, Split::Train))];
            let fitted = way.fit(&model, &Dataset { recordings });
            let found = fitted.estimate.find("hinge.torque_ripple.order").unwrap();
            let off = (found.value.unwrap() - true_order).abs();
            assert!(off <= 5.0 * found.std_dev.unwrap(), "{way:?}: {found:?}");
        }
    }
}

/// A spot of friction has an optimum at every place where something else is left: a fit looks for it over the whole range, narrow and
/// as wide as the motion.
#[test]
fn recovers_known_spot_far_from_its_start() {
    let effects = [
        "coulomb_friction",
        "viscous_friction",
        "position_dependent_friction",
    ];
    let model = pendulum(&effects);
    // The motion goes from -1.0 to 0.9 rad.
    for (place, width) in [(-0.6, 0.1), (0.0, 0.05), (0.9, 0.07), (-0.5, 1.5)] {
        let named = [
            ("coulomb_friction.Fc", 2.0),
            ("viscous_friction.Fv", 1.5),
            ("position_dependent_friction.dF", 3.0),
            ("position_dependent_friction.q0", place),
            ("position_dependent_friction.width", width),
        ];
        let torque = torque(&model, &valued(&model, &named));
        for way in [Estimator::Ordinary, Estimator::MaximumLikelihood] {
            let recordings = vec![USUAL.record(&torque, (1, Split::Train))];
            let fitted = Way::Free(way).fit(&model, &Dataset { recordings });
            let name = "hinge.position_dependent_friction.q0";
            let found = fitted.estimate.find(name).unwrap();
            let off = (found.value.unwrap() - place).abs();
            assert!(off <= 5.0 * found.std_dev.unwrap(), "{way:?}: {found:?}");
            assert!(off <= 0.1 * width, "{way:?}: {found:?}");
        }
    }
}

/// Bristles that bend by half of the motion act like a spring, and without dry friction they do nothing: a fit finds it though it begins
/// with none.
#[test]
fn dry_friction_of_soft_bristles_is_found() {
    let effects = [
        "coulomb_friction",
        "viscous_friction",
        "presliding_hysteresis",
    ];
    let mut model = pendulum(&effects);
    let bristles = [("sigma0", 8.0), ("sigma1", 0.02), ("Fs", 1.0), ("vs", 0.3)];
    let bristles = bristles.map(|(name, value)| (format!("presliding_hysteresis.{name}"), value));
    for (name, value) in &bristles {
        let position = model.find(&format!("hinge.{name}")).unwrap();
        model.fix(position, *value).unwrap();
    }
    let mut named = vec![("viscous_friction.Fv", 1.5), ("coulomb_friction.Fc", 4.0)];
    named.extend(bristles.iter().map(|(name, value)| (name.as_str(), *value)));
    let recordings =
        vec![USUAL.record(&torque(&model, &valued(&model, &named)), (1, Split::Train))];
    let data = Dataset { recordings };
    for way in [Estimator::Ordinary, Estimator::MaximumLikelihood] {
        let fitted = Way::Free(way).fit(&model, &data);
        let found = fitted.estimate.find("hinge.coulomb_friction.Fc").unwrap();
        let off = (found.value.unwrap() - 4.0).abs();
        assert!(off <= 5.0 * found.std_dev.unwrap(), "{way:?}: {found:?}");
    }
}
