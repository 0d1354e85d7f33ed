//! Where the motion is noisy too, the rows of the linear model agree with the cost that is minimised.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::prior::Prior;
use crate::estimate::errors_in_variables::problem::ErrorsInVariables;
use crate::estimate::fit_problem::estimator::Training;
use crate::estimate::fit_problem::problem::FitProblem;
use crate::estimate::fit_problem::unknowns::Unknowns;
use crate::estimate::residual::weights::Weights;
use crate::estimate::tests::{
    DECLARED, NOISE, Recorder, TRUE_FRICTION, USUAL, pendulum, torque, valued,
};
use crate::problem::Problem;
use crate::recording::split::Split;
use crate::robot::random::{generator, symmetric};
use nalgebra::DVector;

#[test]
fn matches_the_cost_and_its_differences() {
    let model = pendulum(&DECLARED);
    let shaken = Recorder {
        shake: 2e-3,
        ..USUAL
    };
    let torque = torque(&model, &valued(&model, &TRUE_FRICTION));
    let recordings = [1, 2].map(|seed| shaken.record(&torque, (seed, Split::Train)));
    let data = Dataset {
        recordings: recordings.to_vec(),
    };
    let prior = Prior::none(model.parameters().len());
    let unknowns = Unknowns::find(&model, &data, &prior);
    let training: Vec<&Prepared> = data.recordings.iter().collect();
    let weights = Weights::by_deviation(&[NOISE]);
    let inner = FitProblem::new(
        &model,
        &unknowns,
        Training {
            recordings: &training,
            prior: &prior,
        },
        weights,
    );
    let problem = ErrorsInVariables::new(&inner).unwrap();
    assert!(problem.unknowns() > problem.parameters() + 12);
    let mut rng = generator(5);
    let x = DVector::from_fn(problem.unknowns(), |_, _| symmetric(&mut rng, 1.0));
    let cost = |x: &DVector<f64>| problem.values(x).unwrap().cost;
    let linear = problem.linearize(&x).unwrap();
    assert!((linear.cost / cost(&x) - 1.0).abs() < 1e-10);
    const STEP: f64 = 1e-4;
    for k in 0..x.len() {
        let at = |by: f64| {
            let mut x = x.clone();
            x[k] += by;
            cost(&x)
        };
        let expected = (at(STEP) - at(-STEP)) / (2.0 * STEP);
        let off = (linear.gradient[k] - expected).abs();
        // Rounding of the cost of 1e7 at most, over the step, and of the differences by which the signal follows the motion.
        let most = 1e-4 + 1e-5 * expected.abs();
        assert!(off < most && cost(&x) < 1e7, "{k}: {off} of {expected}");
    }
}
