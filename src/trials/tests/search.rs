//! What a search saves itself: looks at hypotheses that still hold, delays one by one, and further starts of what cannot win.

use crate::chain::dataset::{Dataset, Prepared};
use crate::diagnose::candidates::motions::Motions;
use crate::diagnose::candidates::score_test::ScoreTests;
use crate::diagnose::candidates::screening::screen;
use crate::diagnose::candidates::screening_reuse::Reusable;
use crate::diagnose::candidates::signal_path::SignalPath;
use crate::diagnose::fit::candidate::{Candidate, Screening};
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::fitting::{fit_model, fit_model_searching_gaps};
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::fit::start::WarmStart;
use crate::diagnose::residuals::noise_level;
use crate::diagnose::selection::exact_fit::{ExactFit, competes, taken};
use crate::diagnose::selection::stepwise::{AlreadyTried, Rules, Stepwise};
use crate::estimate::estimator::Estimator;
use crate::estimate::fit::fit;
use crate::recording::split::Split;
use crate::setup::model_spec::ModelWithPrior;
use crate::stats::deviation::{deviation, rms};
use crate::trials::tests::bench::{Bench, SIGNIFICANCE, effect_of, offset};
use std::sync::Arc;

/// A look at a hypothesis holds beside any model with the same physics on its joint that leaves the same of it.
#[test]
fn a_look_holds_where_neither_physics_nor_residual_are_others() {
    let bench = Bench::new(&["torque_offset"]);
    let context = bench.context(&bench.opened.data);
    let declared = bench.declared(context.data);
    let joint = bench.plan.concealed[0].hypothesis.joints[0];
    let open = vec![offset(joint), effect_of("joint_spring", joint)];
    let make = || Ok(declared.clone());
    context.cache.fit_model(&[], make).unwrap();
    let look = || screen(&context, &declared, open.clone());
    context.cache.screening(&[], look).unwrap();
    let glance = |hypotheses: &[Hypothesis], moved: f64| {
        let mut other = declared.clone();
        other.hypotheses = hypotheses.to_vec();
        other.train[joint].iter_mut().for_each(|e| *e *= moved);
        let reusable = Reusable::of(&context, &other);
        let known = reusable.screening(&offset(joint));
        assert_eq!(known.is_some(), reusable.stands(&[], &offset(joint)));
        assert!(!reusable.stands(&[offset(joint)], &offset(joint)));
        known.map(|screening| screening.glance_at(&offset(joint)).cloned())
    };
    let elsewhere = [effect_of("joint_spring", (joint + 1) % 3)];
    let found = glance(&elsewhere, 1.0).unwrap().unwrap();
    assert_eq!(found.hypothesis, offset(joint));
    assert!(found.gain > 0.0);
    // What takes half a percent of the squares matters.
    assert!(glance(&elsewhere, 0.999).is_some());
    assert!(glance(&elsewhere, 0.8).is_none());
    assert!(glance(&[effect_of("joint_spring", joint)], 1.0).is_none());
}

/// Of what moves only signals that are known to be at their noise, nothing is looked at but delays, which show in some rows alone.
#[test]
fn what_could_not_matter_is_not_looked_at() {
    let bench = Bench::control();
    let mut context = bench.context(&bench.opened.data);
    let declared = bench.declared(context.data);
    let [joint, other] = [0, 1];
    let sought = [
        offset(joint),
        offset(other),
        effect_of("time_delay", other),
        effect_of("unmodelled_payload", 2),
        effect_of("joint_elasticity", other),
    ];
    let looked_at = |context: &Context<'_>| screen(context, &declared, sought.to_vec());
    let left: Vec<f64> = declared.validation.iter().map(|e| rms(e)).collect();
    context.noise = Some(left.clone());
    assert_eq!(
        looked_at(&context).unwrap().open,
        [effect_of("time_delay", other)]
    );
    let mut noise = left;
    noise[joint] *= 0.5;
    context.noise = Some(noise);
    let open = looked_at(&context).unwrap().open;
    assert!(
        open.contains(&offset(joint)) && open.ends_with(&sought[3..]),
        "{open:?}"
    );
    assert!(!open.contains(&offset(other)), "{open:?}");
    context.noise = None;
    assert_eq!(looked_at(&context).unwrap().open, sought);
}

/// A load shifts every signal, and is looked at beside motions that are as late as all signals are on the average: what it promises
/// is what the fit takes, of a law that is linear in its parameters.
#[test]
fn a_look_beside_delays_promises_what_a_fit_takes() {
    let bench = Bench::new(&["unmodelled_payload"]);
    let load = bench.plan.concealed[0].hypothesis.clone();
    let mut late = effect_of("time_delay", 0);
    late.joints = vec![0, 1, 2];
    // A signal is late beside a motion that is too early.
    let early = |recording: &Prepared| recording.late_by(-0.8 * recording.segment().step());
    let data = Dataset {
        recordings: bench.opened.data.recordings.iter().map(early).collect(),
    };
    let context = bench.context(&data);
    let before = bench.fit(context.data, std::slice::from_ref(&late));
    let after = bench.fit(context.data, &[late, load.clone()]);
    let recorded: Vec<Prepared> = data.recordings.clone();
    let motions = |fit| Motions::new(fit, SignalPath::of(&before.model), recorded.clone());
    assert!(motions(&before).all_late().is_some());
    // One signal that is a sample later than the others is not late alike.
    let mut apart = before.clone();
    apart.values[before.model.joints()[0].delay.unwrap()] += data.recordings[0].segment().step();
    assert!(motions(&apart).all_late().is_none());
    let promised = ScoreTests::new(&context, &before).examine(&context, &load);
    let promised = promised.unwrap().gain;
    let taken = taken(FitPair {
        poorer: &before,
        richer: &after,
    });
    assert!((promised / taken - 1.0).abs() < 0.1, "{promised} {taken}");
}

/// Signals that are late by different times are late one by one, though the delays of all together explain more than that of one; those
/// that are late alike are late together. A model that had one delay of all gives it up for theirs.
#[test]
fn a_delay_of_all_is_one_cause() {
    let bench = Bench::control();
    let mut all = effect_of("time_delay", 0);
    all.joints = vec![0, 1, 2];
    let found = |samples: [usize; 3], before: &[Hypothesis]| {
        let data = bench.changed(&[Split::Train, Split::Validation], |experiment| {
            let channels = experiment.signal.iter_mut().zip(samples);
            channels.for_each(|(signal, late)| signal.rotate_right(late));
        });
        let context = bench.context(&data);
        let sought = ["time_delay".to_string()];
        let stepwise = Stepwise {
            context: &context,
            rules: Rules {
                sought: Some(&sought),
                significance: SIGNIFICANCE,
            },
            progress: &|_| (),
        };
        let selection = stepwise.forward(bench.fit(&data, before)).unwrap();
        let found = selection.fit.hypotheses.into_iter();
        let mut joints: Vec<Vec<usize>> = found.map(|h| h.joints).collect();
        joints.sort();
        joints
    };
    for before in [&[][..], std::slice::from_ref(&all)] {
        assert_eq!(found([3, 3, 3], before), [[0, 1, 2]]);
        assert_eq!(found([6, 2, 0], before), [[0], [1]]);
    }
}

/// A candidate that promises less than half of what another was found to take is not searched from other starts, and has not
/// been refuted by its first.
#[test]
fn what_cannot_win_is_not_searched_to_the_end() {
    let bench = Bench::new(&["torque_offset"]);
    let context = bench.context(&bench.opened.data);
    let declared = bench.declared(context.data);
    let joint = bench.plan.concealed[0].hypothesis.joints[0];
    let looked = screen(&context, &declared, vec![offset(joint)]).unwrap();
    let candidate = &looked.candidates[0];
    let exact = ExactFit {
        context: &context,
        before: &declared,
        candidate,
    };
    assert!(competes(candidate, 1.9 * candidate.gain));
    assert!(!competes(candidate, 2.1 * candidate.gain));
    let first = exact.first().unwrap();
    assert!(exact.is_settled(&first));
    assert!(!context.cache.is_fitted(&first.hypotheses));
    let best = exact.best().unwrap();
    assert!(context.cache.is_fitted(&first.hypotheses));
    assert_eq!(best.values, first.values);
    // Twice of what it took is promised.
    let promising = Candidate {
        gain: 2.1
            * taken(FitPair {
                poorer: &declared,
                richer: &first,
            }),
        ..candidate.clone()
    };
    let exact = ExactFit {
        candidate: &promising,
        ..exact
    };
    assert!(!exact.is_settled(&first));
}

/// A start is followed that leads further than a parameter without meaning does; closer ends are one optimum.
#[test]
fn starts_that_lead_to_one_optimum_are_not_followed_twice() {
    let bench = Bench::new(&["torque_offset"]);
    let context = bench.context(&bench.opened.data);
    let declared = bench.declared(context.data);
    let joint = bench.plan.concealed[0].hypothesis.joints[0];
    let looked = screen(&context, &declared, vec![offset(joint)]).unwrap();
    let exact = ExactFit {
        context: &context,
        before: &declared,
        candidate: &looked.candidates[0],
    };
    let first = exact.first().unwrap();
    let rows: usize = first.train.iter().map(Vec::len).sum();
    // The logarithm of the likelihood of n residuals of deviation s is -n ln s.
    let likelier = |by: f64| {
        let mut fit = first.clone();
        let smaller = (-0.5 * by / rows as f64).exp();
        fit.train.iter_mut().flatten().for_each(|e| *e *= smaller);
        assert!((first.fitted_score() - fit.fitted_score() - by).abs() < 1e-3);
        fit
    };
    assert!(!exact.leads_further(&likelier(0.9), &first));
    assert!(exact.leads_further(&likelier(1.1), &first));
}

/// Beside an offset that takes much, an offset that promises what it does not take is searched to the end where that would be as
/// much as half of it; and so is one in the place of the offset.
#[test]
fn a_search_leaves_further_starts_of_what_cannot_win() {
    let bench = Bench::control();
    let data = bench.changed(&[Split::Train, Split::Validation], |experiment| {
        let size = 5.0 * deviation(&experiment.signal[0]);
        experiment.signal[0].iter_mut().for_each(|s| *s += size);
    });
    let declared = bench.declared(&data);
    let richer = bench.fit(&data, &[offset(0)]);
    let most = taken(FitPair {
        poorer: &declared,
        richer: &richer,
    });
    let is_searched = |share: f64, search: &dyn Fn(&Stepwise<'_>)| {
        let context = bench.context(&data);
        let looked = screen(&context, &declared, vec![offset(0)]).unwrap();
        let winner = looked.candidates[0].clone();
        let promising = Candidate {
            hypothesis: offset(1),
            gain: share * most,
            start: Vec::new(),
            ..winner.clone()
        };
        let known = Screening {
            candidates: vec![winner, promising],
            ..looked
        };
        context.cache.screening(&[], || Ok(known)).unwrap();
        let fit = || Ok(declared.clone());
        context.cache.fit_model(&[], fit).unwrap();
        let rules = Rules {
            sought: None,
            significance: SIGNIFICANCE,
        };
        let stepwise = Stepwise {
            context: &context,
            rules,
            progress: &|_| (),
        };
        search(&stepwise);
        context.cache.is_fitted(&[offset(1)])
    };
    let beside = |stepwise: &Stepwise<'_>| {
        let open = [offset(0), offset(1)];
        let tests = stepwise
            .tests(&declared, &open, AlreadyTried::default())
            .unwrap();
        assert!(tests[0].is_needed(SIGNIFICANCE) && !tests[1].is_needed(SIGNIFICANCE));
    };
    let in_place = |stepwise: &Stepwise<'_>| {
        let noise_level = noise_level::of_rows(stepwise.context, &richer, &[]);
        stepwise.rivals(&richer, 0, &noise_level).unwrap();
    };
    for search in [&beside as &dyn Fn(&Stepwise<'_>), &in_place] {
        assert!(!is_searched(0.45, search));
        assert!(is_searched(0.55, search));
    }
}

/// Derivatives are kept for the models that others are compared with, and are those of one model.
#[test]
fn derivatives_are_kept_for_the_model_that_they_are_of() {
    let bench = Bench::control();
    let context = bench.context(&bench.opened.data);
    let declared = bench.declared(context.data);
    let [fitted, held_out] = [Split::Train, Split::Validation].map(|s| context.recordings(s));
    let of = |fit: &ModelFit| context.derivatives.of(fit, &fitted, &held_out).unwrap();
    let first = of(&declared);
    assert!(Arc::ptr_eq(&first, &of(&declared)));
    let mut other = declared.clone();
    other.values[0] += 1.0;
    assert!(!Arc::ptr_eq(&first, &of(&other)));
    let mut named = declared.clone();
    named.hypotheses = vec![offset(0)];
    assert!(!Arc::ptr_eq(&first, &of(&named)));
    // Two others have come since.
    assert!(!Arc::ptr_eq(&first, &of(&declared)));
    // One that was asked for in between stays.
    let again = of(&declared);
    of(&other);
    assert!(Arc::ptr_eq(&again, &of(&declared)));
    of(&named);
    assert!(Arc::ptr_eq(&again, &of(&declared)));
}

/// Steps of all parameters from a usual gap end at another than the one that strikes where the recording does.
#[test]
fn a_gap_is_found_wherever_a_search_begins() {
    let bench = Bench::numbered(&["backlash"], 5);
    let context = bench.context(&bench.opened.data);
    let hidden = &bench.plan.concealed[0];
    let hypotheses = std::slice::from_ref(&hidden.hypothesis);
    let gap = |fit: &ModelFit| {
        let joint = hidden.hypothesis.joints[0];
        fit.values[fit.model.joints()[joint].play.unwrap()]
    };
    let from = WarmStart {
        values: Vec::new(),
        deviations: context.signal_rms(Split::Train),
    };
    let stepwise = gap(&fit_model(&context, hypotheses, &from).unwrap());
    let searched = gap(&fit_model_searching_gaps(&context, hypotheses, &from).unwrap());
    let truth = hidden.values[0].1;
    assert!((searched / truth - 1.0).abs() < 0.01, "{searched} {truth}");
    let ModelWithPrior { model, prior } = context.model(hypotheses).unwrap();
    let estimator = Estimator::MaximumLikelihood;
    let fitted = fit(&model, context.data, estimator, &prior, &bench.control).unwrap();
    let of_a_fit = fitted.values[model.joints()[hidden.hypothesis.joints[0]].play.unwrap()];
    assert!((of_a_fit / truth - 1.0).abs() < 0.01, "{of_a_fit} {truth}");
    assert!((stepwise / truth - 1.0).abs() > 0.5, "{stepwise} {truth}");
}
