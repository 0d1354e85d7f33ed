//! The parameters of an arm from its URDF and a CSV of positions and motor currents, with 95 % intervals.
//!
//! ```text
//! cargo run --release --example fit_arm
//! ```
//!
//! The recordings are those of `problems/arm6`, simulated with friction and offsets that its problem file states; the problem
//! itself is stated here, in Rust.

use exid::chain::effect::ids;
use exid::estimate::task as fit;
use exid::problem::solution::Control;
use exid::problem_file::builder::ProblemBuilder;
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/arm6");
    let problem = ProblemBuilder::in_folder(folder)
        .urdf("arm6.urdf")
        .train("train.csv.gz") // t, s; q1 to q6, rad; i1 to i6, A
        .validation("validation.csv.gz")
        .torque_constant([13.1, 13.0, 12.8, 9.2, 9.1, 9.3])
        .rotor_inertia([1.40, 1.50, 1.10, 0.35, 0.34, 0.33])
        .effects(&["coulomb_friction", "viscous_friction", "torque_offset"])
        .build(&ids())?;
    let fitted = fit::run(&problem, &Control::default(), |step| {
        eprintln!("{}", step.words());
    })?
    .fitted;
    println!("{:<30} {:>11}  95 % interval", "parameter", "value");
    for parameter in &fitted.estimate.parameters {
        // The others are known, or the motion does not determine them by themselves.
        if let (Some(value), Some([lower, upper])) = (parameter.value, parameter.ci95) {
            let (name, unit) = (&parameter.name, &parameter.unit);
            println!("{name:<30} {value:>11.4}  {lower:.4} .. {upper:.4} {unit}");
        }
    }
    for joint in &fitted.estimate.joints {
        let held_out = joint.rmse_validation.unwrap_or(f64::NAN);
        println!(
            "{}: {held_out:.4} {} are left on the recording that was not fitted",
            joint.joint, joint.unit
        );
    }
    Ok(())
}
