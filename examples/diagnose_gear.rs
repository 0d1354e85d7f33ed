//! Which physics a model lacks: an arm whose third gear loses torque, of which the declared model knows nothing.
//!
//! ```text
//! cargo run --release --example diagnose_gear
//! ```
//!
//! The recordings are those of `problems/arm6_gearbox`, simulated with a gear on axis 3 that loses 18 % of the torque that it
//! transmits; the problem itself is stated here, in Rust.

use exid::chain::effect::ids;
use exid::diagnose::task as diagnose;
use exid::problem::solution::Control;
use exid::problem_file::builder::ProblemBuilder;
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/arm6_gearbox");
    let problem = ProblemBuilder::in_folder(folder)
        .urdf("../arm6/arm6.urdf")
        .train("train.csv.gz")
        .validation("validation.csv.gz")
        .torque_constant([13.1, 13.0, 12.8, 9.2, 9.1, 9.3])
        .rotor_inertia([1.40, 1.50, 1.10, 0.35, 0.34, 0.33])
        .effects(&["coulomb_friction", "viscous_friction"])
        .build(&ids())?;
    let watch = |stage: exid::diagnose::stage::Stage| eprintln!("{}", stage.words());
    let diagnosis = diagnose::run(&problem, &Control::default(), &watch)?.diagnosis;
    println!("{}", diagnosis.summary);
    for finding in &diagnosis.findings {
        println!(
            "\n{} at {}: probability {:.3}, p = {:.1e}",
            finding.effect,
            finding.joints.join(", "),
            finding.probability,
            finding.p_value
        );
        for parameter in &finding.parameters {
            if let Some((value, std_dev)) = parameter.value.zip(parameter.std_dev) {
                let (name, unit) = (&parameter.name, &parameter.unit);
                println!("  {name} = {value:.4} ± {std_dev:.4} {unit}");
            }
        }
        for rival in finding.rivals.iter().filter(|rival| !rival.separable) {
            println!(
                "  {} at {} explains as much",
                rival.effect,
                rival.joints.join(", ")
            );
        }
    }
    Ok(())
}
