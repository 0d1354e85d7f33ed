//! Cone programs that are stopped before they are solved.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::prior::Prior;
use crate::estimate::feasible::MARGIN;
use crate::estimate::feasible::program::Constraints;
use crate::estimate::feasible::solve::{Compressed, Setting, constrained, estimate};
use crate::estimate::feasible::standard::StandardParameters;
use crate::estimate::fit_problem::estimator::Training;
use crate::estimate::fit_problem::problem::FitProblem;
use crate::estimate::fit_problem::unknowns::Unknowns;
use crate::estimate::residual::weights::Weights;
use crate::estimate::tests::{DECLARED, NOISE, TRUE_FRICTION, USUAL, pendulum, torque, valued};
use crate::problem::solution::{Control, Stop, TraceRow};
use crate::recording::split::Split;
use nalgebra::DVector;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// What a test looks at: the residual of a pendulum whose friction drives it, and whose body is not that of the robot file, as
/// so many deviations for 1 N·m.
fn with_residual(weight: f64, test: impl Fn(Setting<'_>, &Compressed)) {
    let model = pendulum(&DECLARED);
    let mut values = valued(&model, &TRUE_FRICTION);
    for (name, value) in [("bob.Iyy", 0.5), ("hinge.viscous_friction.Fv", -1.5)] {
        values[model.find(name).unwrap()] = value;
    }
    let data = Dataset {
        recordings: vec![USUAL.record(&torque(&model, &values), (1, Split::Train))],
    };
    let prior = Prior::none(model.parameters().len());
    let unknowns = Unknowns::find(&model, &data, &prior);
    let training: Vec<&Prepared> = data.recordings.iter().collect();
    let weights = Weights::PerChannel(DVector::from_element(1, weight));
    let problem = FitProblem::new(
        &model,
        &unknowns,
        Training {
            recordings: &training,
            prior: &prior,
        },
        weights,
    );
    let count = unknowns.positions().len();
    let factor = problem.factor(&DVector::zeros(count)).matrix();
    let residual = Compressed {
        matrix: factor.columns(0, count).into_owned(),
        offset: factor.column(count).into_owned(),
    };
    let standard = StandardParameters::new(&model, &unknowns);
    let setting = Setting {
        standard: &standard,
        constraints: &Constraints::new(&standard, &[]),
        margin: MARGIN,
        prior: None,
    };
    test(setting, &residual);
}

/// It is no answer that would pass for one.
#[test]
fn what_an_interrupt_left_is_not_called_optimal() {
    with_residual(1.0 / NOISE, |setting, residual| {
        let stop = |interrupted: bool| {
            let control = Control {
                interrupt: Some(Arc::new(AtomicBool::new(interrupted))),
                ..Control::default()
            };
            estimate(setting, residual, &control).unwrap().stop
        };
        assert_eq!(stop(false), Stop::Optimal);
        assert_eq!(stop(true), Stop::Interrupted);
    });
}

/// Where a pull that costs too much is weakened, the answer to the stronger one stays until there is another.
#[test]
fn an_answer_is_kept_until_the_next_is_found() {
    // So small a residual that any pull costs more than its share of it.
    with_residual(1e-6, |setting, residual| {
        let programs = AtomicUsize::new(0);
        let interrupt = Arc::new(AtomicBool::new(false));
        let until = |last: usize| {
            programs.store(0, Ordering::Relaxed);
            interrupt.store(false, Ordering::Relaxed);
            let progress = |row: &TraceRow| {
                let begun = programs.fetch_add((row.iteration == 1).into(), Ordering::Relaxed);
                if row.iteration == 1 && begun == last {
                    interrupt.store(true, Ordering::Relaxed);
                }
            };
            let control = Control {
                interrupt: Some(Arc::clone(&interrupt)),
                progress: Some(&progress),
                ..Control::default()
            };
            let found = constrained(setting, setting.constraints, residual, &control);
            found.unwrap().solution
        };
        assert_eq!(until(usize::MAX).stop, Stop::Optimal);
        let count = programs.load(Ordering::Relaxed);
        assert!(count > 2);
        assert_eq!(until(0).stop, Stop::Interrupted);
        for last in 1..count {
            assert_eq!(until(last).stop, Stop::Optimal, "{last} of {count}");
        }
    });
}
