//! An effect of one's own, in Rust: drag of the oil in a gear, fitted to recordings.
//!
//! ```text
//! torque = c·v
//! cargo run --release --example own_effect
//! ```
//!
//! The recordings are those of `problems/arm6`, simulated with viscous friction, which is this law under another name: the
//! values that come out are those that its problem file states. A law without states and of few terms needs no Rust: see
//! `[[law]]` of problem files.

use exid::chain::effect::catalogue::register;
use exid::chain::effect::expression::{Expression, Variable};
use exid::chain::effect::knowledge::{Change, Knowledge, Sizes};
use exid::chain::effect::{
    Confounder, Contribution, Dependence, Effect, ParameterInfo, Power, Samples, TorqueLaw, Unit,
    ids,
};
use exid::estimate::task as fit;
use exid::problem::solution::Control;
use exid::problem_file::builder::ProblemBuilder;
use std::error::Error;
use std::path::Path;

#[derive(Debug)]
struct OilDrag;

impl TorqueLaw for OilDrag {
    fn add(&self, samples: Samples<'_>, parameters: &[f64], out: &mut Contribution<'_>) {
        let [c] = *parameters else { return };
        for (k, v) in samples.velocity.iter().enumerate() {
            out.torque[k] += c * v;
            out.by_parameter[0][k] = *v;
        }
    }

    fn power(&self) -> Power {
        Power::Dissipates
    }

    fn torque(&self) -> Expression {
        Expression::parameter(0) * Variable::Velocity
    }
}

static OIL_DRAG: Effect = Effect {
    sentence: "The oil in the gear drags in proportion to speed.",
    equation: "c·v",
    depends_on: &[Dependence::Speed],
    confounded_with: &[Confounder {
        with: "coulomb_friction",
        separated_by: "motion at several speeds",
    }],
    knowledge: Knowledge {
        change: Some(Change::FRICTION),
        sizes: Sizes::First,
        ..Knowledge::NONE
    },
    ..Effect::at_motor("oil_drag", &[DRAG], &OilDrag)
};

const DRAG: ParameterInfo = ParameterInfo::linear("c", Unit::TorquePerSpeed, "drag per speed", 1.0)
    .within(0.0, f64::INFINITY);

fn main() -> Result<(), Box<dyn Error>> {
    register(&OIL_DRAG)?;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/arm6");
    let problem = ProblemBuilder::in_folder(folder)
        .urdf("arm6.urdf")
        .train("train.csv.gz")
        .validation("validation.csv.gz")
        .torque_constant([13.1, 13.0, 12.8, 9.2, 9.1, 9.3])
        .rotor_inertia([1.40, 1.50, 1.10, 0.35, 0.34, 0.33])
        .effects(&["coulomb_friction", "oil_drag", "torque_offset"])
        .build(&ids())?;
    let estimate = fit::run(&problem, &Control::default(), |_| ())?
        .fitted
        .estimate;
    for joint in &estimate.joints {
        let name = format!("{}.oil_drag.c", joint.joint);
        let drag = estimate.find(&name).ok_or("not estimated")?;
        let (value, std_dev) = drag.value.zip(drag.std_dev).ok_or("not determined")?;
        println!("{name} = {value:.3} ± {std_dev:.3} {}", drag.unit);
    }
    Ok(())
}
