//! Rows that are held out take no part in any fit.

use crate::chain::dataset::Dataset;
use crate::chain::effect;
use crate::chain::model::{Model, ModelSettings, Payload, Signal};
use crate::chain::prior::Prior;
use crate::estimate::errors_in_variables;
use crate::estimate::fit::fit;
use crate::estimate::fit_problem::estimator::Estimator;
use crate::estimate::load_by_difference;
use crate::estimate::tests::{
    DECLARED, PENDULUM, TRUE_FRICTION, USUAL, WAYS, pendulum, torque, valued,
};
use crate::problem::solution::Control;
use crate::recording::split::Split;
use crate::robot::urdf;
use nalgebra::Isometry3;
use std::path::Path;

/// A held-out recording of another torque leaves every value of the fit as it is, to the bit.
#[test]
fn invariant_rows_that_are_held_out_take_no_part_in_a_fit() {
    let model = pendulum(&DECLARED);
    let torque = torque(&model, &valued(&model, &TRUE_FRICTION));
    let other: Vec<f64> = torque.iter().map(|torque| 1.5 * torque + 1.0).collect();
    for way in WAYS {
        let fitted = |held_out: &[f64]| {
            let recordings = vec![
                USUAL.record(&torque, (1, Split::Train)),
                USUAL.record(held_out, (2, Split::Validation)),
            ];
            way.fit(&model, &Dataset { recordings })
        };
        let (one, another) = (fitted(&torque), fitted(&other));
        assert_eq!(one.values, another.values, "{way:?}");
        let [right, wrong] = [&one, &another].map(|f| f.estimate.joints[0].rmse_validation);
        assert!(wrong.unwrap() > 5.0 * right.unwrap(), "{way:?}");
    }
}

/// Neither where the motion is noisy too, nor in the second of two fits whose difference is the load.
#[test]
fn invariant_rows_that_are_held_out_take_no_part_in_fits_of_motions_and_loads() {
    let control = Control::default();
    let model = pendulum(&DECLARED);
    let lighter = torque(&model, &valued(&model, &TRUE_FRICTION));
    let heavier: Vec<f64> = lighter.iter().map(|torque| 1.2 * torque).collect();
    let other: Vec<f64> = lighter.iter().map(|torque| 1.5 * torque + 1.0).collect();
    let none = Prior::none(model.parameters().len());
    let along = |held_out: &[f64]| {
        let recordings = vec![
            USUAL.record(&lighter, (1, Split::Train)),
            USUAL.record(held_out, (2, Split::Validation)),
        ];
        let data = Dataset { recordings };
        errors_in_variables::fit::fit(&model, &data, &none, &control)
            .unwrap()
            .values
    };
    assert_eq!(along(&lighter), along(&other));

    let tree = urdf::parse(PENDULUM, Path::new("pendulum.urdf")).unwrap();
    let effects = DECLARED.iter().map(|id| effect::find(id).unwrap());
    let loaded = Model::new(ModelSettings {
        effects: vec![effects.collect()],
        payload: Some(Payload {
            link: 0,
            frame: Isometry3::identity(),
        }),
        ..ModelSettings::bodies(tree, Signal::Torque)
    })
    .unwrap();
    let none = Prior::none(loaded.parameters().len());
    let difference = |held_out: &[f64]| {
        let with_load = |torque: &[f64], of: (u64, Split)| {
            let mut recording = USUAL.record(torque, of);
            recording.loaded = true;
            recording
        };
        let data = Dataset {
            recordings: vec![
                USUAL.record(&lighter, (1, Split::Train)),
                with_load(&heavier, (2, Split::Train)),
                with_load(held_out, (3, Split::Validation)),
            ],
        };
        let alone = load_by_difference::without_load(&loaded, &data).unwrap();
        let first = fit(&loaded, &alone, Estimator::Weighted, &none, &control).unwrap();
        load_by_difference::second(first, &data, Estimator::Weighted, &control)
            .unwrap()
            .values
    };
    assert_eq!(difference(&heavier), difference(&other));
}
