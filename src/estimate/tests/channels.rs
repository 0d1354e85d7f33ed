//! Fits of an arm of two joints: how its channels are weighted against each other.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::effect;
use crate::chain::evaluate::{Evaluator, Segment};
use crate::chain::model::{Model, ModelSettings, Signal};
use crate::estimate::feasible::Form;
use crate::estimate::fit::Fitted;
use crate::estimate::fit_problem::estimator::Estimator;
use crate::estimate::tests::{PERIOD_S, PERIODS, ROWS, Way, motion};
use crate::recording::preprocess::prepare;
use crate::recording::samples::Recording;
use crate::recording::settings::Preparation;
use crate::recording::split::Split;
use crate::robot::batch::Trajectory;
use crate::robot::random::generator;
use crate::robot::urdf;
use rand::RngExt;
use rand_distr::StandardNormal;
use std::path::Path;

const ARM: &str = r#"<robot name="arm"><link name="base"/>
<link name="upper"><inertial><origin xyz="0.2 0.0 -0.1"/><mass value="3.0"/>
<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.05"/></inertial></link>
<link name="fore"><inertial><origin xyz="0.1 0.0 0.05"/><mass value="1.0"/>
<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
<joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/></joint>
<joint name="elbow" type="continuous"><parent link="upper"/><child link="fore"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/></joint>
</robot>"#;

/// N·m of one sample of either channel, of a noise that both have.
const NOISE: [f64; 2] = [0.6, 0.02];

/// Correlation of the noise of the two channels.
const CORRELATION: f64 = 0.9;

fn arm(effects: &[&str]) -> Model {
    let effects: Vec<_> = effects.iter().map(|id| effect::find(id).unwrap()).collect();
    let tree = urdf::parse(ARM, Path::new("arm.urdf")).unwrap();
    Model::new(ModelSettings {
        effects: vec![effects; 2],
        ..ModelSettings::bodies(tree, Signal::Torque)
    })
    .unwrap()
}

/// A recording of the arm with viscous friction and offsets, whose elbow lags a quarter of a period behind its shoulder.
fn recorded() -> Dataset {
    let model = arm(&["viscous_friction", "torque_offset"]);
    let mut values = model.values();
    for (p, value) in model.tree().parameters().into_iter().enumerate() {
        values[p] = value;
    }
    for (name, value) in [
        ("shoulder.viscous_friction.Fv", 1.5),
        ("elbow.viscous_friction.Fv", 0.7),
        ("shoulder.torque_offset.offset", 1.2),
        ("elbow.torque_offset.offset", -0.4),
    ] {
        values[model.find(name).unwrap()] = value;
    }
    let [q, dq, ddq] = motion().map(|shoulder| {
        let mut elbow = shoulder.clone();
        elbow.rotate_left(ROWS / 4);
        vec![shoulder, elbow]
    });
    let motors = Trajectory {
        q: &q,
        dq: &dq,
        ddq: &ddq,
    };
    let mut evaluator = Evaluator::along(&model, &values, &[], ROWS);
    let evaluated = evaluator.evaluate(Segment::states(motors, false), 0..ROWS);
    let torque = [0, 1].map(|j| evaluated.value(j).to_vec());
    let mut rng = generator(1);
    let mut signal = vec![Vec::new(), Vec::new()];
    for row in 0..PERIODS * ROWS {
        let [first, second]: [f64; 2] = std::array::from_fn(|_| rng.sample(StandardNormal));
        let both = [
            first,
            CORRELATION * first + (1.0 - CORRELATION * CORRELATION).sqrt() * second,
        ];
        for (c, series) in signal.iter_mut().enumerate() {
            series.push(torque[c][row % ROWS] + NOISE[c] * both[c]);
        }
    }
    let position = q.iter().map(|series| series.repeat(PERIODS)).collect();
    let recording = Recording::of_samples("arm".to_string(), position, signal);
    let preparation = Preparation {
        rate: Some(ROWS as f64 / PERIOD_S),
        period: Some(PERIOD_S),
        ..Preparation::default()
    };
    let experiment = prepare(recording, &preparation).unwrap();
    let recording = Prepared::new("arm".to_string(), Split::Train, false, experiment);
    Dataset {
        recordings: vec![recording],
    }
}

/// The largest difference of a base parameter, in standard deviations.
fn apart(one: &Fitted, another: &Fitted) -> f64 {
    let pairs = one
        .fit
        .base_parameters
        .iter()
        .zip(&another.fit.base_parameters);
    let of = pairs.map(|(a, b)| {
        let off = a.value.unwrap() - b.value.unwrap();
        off.abs() / b.std_dev.unwrap()
    });
    of.fold(0.0, f64::max)
}

/// Where possible bodies explain a recording as well as any, they are found by the same weights: the covariance across
/// channels that the periods show, or the deviation of each channel's residual.
#[test]
fn invariant_channels_weigh_the_same_with_possible_bodies() {
    let data = recorded();
    for (effects, of_likelihood) in [
        // Two thirds of a standard deviation between the weights.
        (&["viscous_friction", "torque_offset"][..], 0.5..1.0),
        // Physics is missing: the periods no longer say how far a row is off.
        (&["viscous_friction"][..], 0.0..0.01),
    ] {
        let model = arm(effects);
        let fit = |way: Way| way.fit(&model, &data);
        let likely = fit(Way::Free(Estimator::MaximumLikelihood));
        let weighted = fit(Way::Free(Estimator::Weighted));
        assert!(of_likelihood.contains(&apart(&likely, &weighted)));
        for (form, free) in [
            (Form::MaximumLikelihood, &likely),
            (Form::Weighted, &weighted),
        ] {
            let off = apart(&fit(Way::Feasible(form)), free);
            // Rounding.
            assert!(off < 1e-6, "{form:?}, {effects:?}: {off:e}");
        }
    }
}
