//! Identification from the reaction of the base: what Raucent, Campion, Bastin, Samin and Willems (1992)
//! print, sensors that stand anywhere, spinning rotors, and truths that are known.

#[path = "../common/mod.rs"]
mod common;
mod recovered;
mod structure;

use exid::chain::model::Model;
use exid::problem_file::ProblemFile;
use exid::robot::inertia::CentralInertia;
use exid::robot::tree::Tree;
use exid::setup;
use exid::setup::model_spec::ModelSpec;
use std::path::{Path, PathBuf};

fn shipped() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/puma562_reaction/problem.toml")
}

fn model(path: &Path, overrides: &[&str]) -> Model {
    let ids = exid::chain::effect::ids();
    let overrides: Vec<String> = overrides.iter().map(|o| o.to_string()).collect();
    let problem = ProblemFile::read(path, &overrides, &ids).unwrap_or_else(|e| panic!("{e}"));
    let robot = setup::robot::open(&problem).unwrap_or_else(|e| panic!("{e}"));
    let declared = ModelSpec::without_prior(&problem, &robot);
    let built = declared.and_then(|declared| declared.build());
    built.unwrap_or_else(|e| panic!("{e}")).model
}

/// θ_d as the paper prints it (section 5.1), at the bodies of the shipped robot.
fn published_theta_d(tree: &Tree) -> [f64; 9] {
    let body = |k: usize| tree.joints()[k].inertia.central().unwrap();
    let [one, two, three] = [body(0), body(1), body(2)];
    let d3 = tree.joints()[2].translation.z;
    let j = |body: &CentralInertia, axis: usize| body.tensor[(axis, axis)];
    let (m1, m2, m3) = (one.mass, two.mass, three.mass);
    let (l1, l2, l3) = (one.centre, two.centre, three.centre);
    [
        j(&one, 2)
            + m1 * l1.y.powi(2)
            + j(&two, 2)
            + m2 * l2.y.powi(2)
            + j(&three, 2)
            + m3 * l3.y.powi(2),
        j(&two, 0) - j(&two, 2) + m3 * d3.powi(2) + m2 * l2.z.powi(2),
        j(&two, 1) + m3 * d3.powi(2) + m2 * l2.z.powi(2),
        -m2 * l2.y * l2.z - m3 * d3 * l3.y,
        j(&three, 0) - j(&three, 2) + m3 * l3.z.powi(2),
        j(&three, 1) + m3 * l3.z.powi(2),
        -m3 * l3.y * l3.z,
        m3 * d3 + m2 * l2.z,
        m3 * l3.z,
    ]
}

/// The parameters that lead the paper's combinations, in its order.
const LEADING: [&str; 9] = [
    "link1.Izz",
    "link2.Ixx",
    "link2.Iyy",
    "link2.Iyz",
    "link3.Ixx",
    "link3.Iyy",
    "link3.Iyz",
    "link2.mcz",
    "link3.mcz",
];
