//! The page as a whole: self-contained, escaped, made from the folder alone.

use std::io::Write;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;
use sha2::{Digest, Sha256};

use crate::outcome::check::{Check, Mistake, Severity};
use crate::outcome::design::{Design, ExpectedDeviation};
use crate::outcome::estimate::{Covariance, Estimate, Solver};
use crate::outcome::fit::{BaseParameter, Comparison, Fit, Posterior, Preprocessing};
use crate::outcome::folder::ResultFolder;
use crate::outcome::input::Input;
use crate::outcome::joint::JointFigures;
use crate::outcome::parameter::{Parameter, Source};
use crate::outcome::predictions::{Block, Column, PredictionsWriter, Quantity};
use crate::outcome::provenance::{Provenance, VERSION};
use crate::outcome::rollout::{Before, Horizon, Integrator, JointErrors, Rollout, Spread};
use crate::outcome::run::Run;
use crate::outcome::sharing::{SeparateValue, SharedParameter, Sharing};
use crate::outcome::simulation::{RealisedNoise, Simulation};
use crate::outcome::{Outcome, PREDICTIONS_FILE, Part, RESULT_FILE};
use crate::recording::split::Split;
use crate::report::written::Tables;
use crate::report::{html, render, text};

const JOINTS: usize = 6;

/// Inertial quantities of a link with their units.
const INERTIAL: [(&str, &str); 4] = [
    ("mass", "kg"),
    ("com_x", "m"),
    ("com_y", "m"),
    ("inertia_zz", "kg·m²"),
];

fn figures(joint: usize, scale: f64) -> JointFigures {
    let rmse = scale * 0.21 / joint as f64;
    JointFigures {
        joint: format!("joint{joint}"),
        unit: "A".to_string(),
        rmse_train: rmse,
        rmse_validation: Some(1.13 * rmse),
        rmse_train_raw: 2.4 * rmse,
        rmse_validation_raw: Some(2.5 * rmse),
        mae_train: 0.8 * rmse,
        mae_validation: Some(0.9 * rmse),
        relative_train: 0.02 * joint as f64,
        relative_validation: Some(0.024 * joint as f64),
        noise_rms: Some(0.85 * rmse),
        lack_of_fit: Some(1.77),
    }
}

fn parameters() -> Vec<Parameter> {
    let determined = |name: String, unit: &str, value: f64, text: &str| Parameter {
        value: Some(value),
        std_dev: Some(0.03 * value.abs()),
        ci95: Some([value - 0.06 * value.abs(), value + 0.06 * value.abs()]),
        source: Source::Data,
        ..Parameter::undetermined(name, unit).described(text)
    };
    let mut all = Vec::new();
    for link in 1..=JOINTS {
        for (k, (quantity, unit)) in INERTIAL.into_iter().enumerate() {
            let name = format!("link{link}.{quantity}");
            all.push(if (link + k) % 3 == 0 {
                Parameter::undetermined(name, unit)
            } else {
                let value = 12.0 / 10f64.powi(k as i32) / (link as f64 - 3.5);
                determined(name, unit, value, "")
            });
        }
    }
    for joint in 1..=JOINTS {
        let scale = 1.0 / joint as f64;
        let name = |rest| format!("joint{joint}.{rest}");
        all.push(determined(
            name("coulomb_friction.Fc"),
            "N·m",
            9.3 * scale,
            "Coulomb friction level",
        ));
        all.push(Parameter::known(name("coulomb_friction.w"), "rad/s", 0.004));
        all.push(determined(
            name("viscous_friction.Fv"),
            "N·m·s/rad",
            14.1 * scale,
            "viscous friction",
        ));
        all.push(determined(
            name("rotor_inertia.Jm"),
            "kg·m²",
            3.7e-5 * scale,
            "reflected rotor inertia",
        ));
    }
    all[4].source = Source::Bound;
    all[12].source = Source::Prior;
    all
}

fn base_parameters() -> Vec<BaseParameter> {
    (1..=20)
        .map(|k| BaseParameter {
            expression: (0..=k)
                .map(|j| {
                    format!(
                        "{}link{}.inertia_xx",
                        if j == 0 {
                            String::new()
                        } else {
                            format!("{:.4}*", 0.1 * j as f64)
                        },
                        j % 6 + 1
                    )
                })
                .collect::<Vec<_>>()
                .join(" + "),
            unit: "kg·m²".to_string(),
            value: Some(2.5 / k as f64),
            std_dev: Some(0.02),
            ci95: None,
        })
        .collect()
}

fn run(problem: serde_json::Value) -> Run {
    Run {
        version: VERSION.to_string(),
        seed: 1,
        problem,
        inputs: ["arm.toml", "arm.urdf", "train.csv", "validation.csv"]
            .map(|path| Input {
                path: path.to_string(),
                sha256: "0123456789abcdef".repeat(4),
            })
            .to_vec(),
        wall_s: 1.234,
        provenance: Provenance {
            command: ["fit", "arm.toml", "--set", "fit.estimator=\"wls\""]
                .map(String::from)
                .to_vec(),
            directory: "/home/someone".to_string(),
            date: "2026-01-31T12:00:00Z".to_string(),
            threads: 4,
            revision: "version 0.1.0".to_string(),
            features: Vec::new(),
            processor: "x86_64 linux".to_string(),
        },
    }
}

/// A fit of a six-joint arm with every kind of parameter and long combinations.
fn arm() -> Outcome {
    Outcome {
        name: "six_joint_arm".to_string(),
        run: run(json!({
            "name": "six_joint_arm",
            "robot": {"urdf": "arm.urdf", "gravity": [0.0, 0.0, -9.81]},
            "drive": {"effects": ["coulomb_friction", "viscous_friction"], "torque_constant": [11.0, 11.2]},
            "recordings": {"train": ["train.csv"], "signal": "current"},
        })),
        mistakes: Vec::new(),
        estimate: Estimate {
            parameters: parameters(),
            joints: (1..=JOINTS).map(|joint| figures(joint, 1.0)).collect(),
            covariance: Covariance::default(),
            solver: Some(Solver {
                name: "maximum_likelihood".to_string(),
                stop: "cost_tolerance".to_string(),
                converged: true,
                iterations: 7,
                evaluations: 19,
                cost: 12345.678,
            }),
        },
        part: Part::Fit(Fit {
            feasibility: None,
            motors: None,
            posterior: Posterior::default(),
            base_parameters: base_parameters(),
            rank: 36,
            unknowns: 78,
            payload: None,
            condition_number: 87.3,
            feasible: Some(true),
            min_pseudo_inertia_eigenvalue: Some(3.2e-4),
            comparison: vec![Comparison {
                name: "Stribeck".to_string(),
                effects: vec![
                    "coulomb_friction".to_string(),
                    "stribeck_friction".to_string(),
                ],
                joints: (1..=JOINTS).map(|joint| figures(joint, 0.97)).collect(),
            }],
            contests: Vec::new(),
            sharing: vec![sharing()],
            joint_torque_parameters: Vec::new(),
            realization: Vec::new(),
            model: None,
            machine: None,
            nearest: Vec::new(),
            possible_machine: None,
            simulator: None,
            preprocessing: vec![Preprocessing {
                recording: "train.csv".to_string(),
                channel: Some("joint1".to_string()),
                text: "position as a Fourier series of 14 harmonics, chosen from the data"
                    .to_string(),
            }],
            notes: vec!["6 periods averaged; the last 0.31 s left out.".to_string()],
        }),
    }
}

/// Two joints with one viscous friction.
fn sharing() -> Sharing {
    let own = |joint: &str, value: f64| SeparateValue {
        joint: joint.to_string(),
        value: Some(value),
        std_dev: Some(0.04),
    };
    Sharing {
        effect: "viscous_friction".to_string(),
        joints: vec!["joint1".to_string(), "joint2".to_string()],
        in_model: true,
        parameters: vec![SharedParameter {
            name: "viscous_friction.Fv".to_string(),
            unit: "N·m·s/rad".to_string(),
            value: Some(1.21),
            std_dev: Some(0.03),
            ci95: Some([1.15, 1.27]),
            separate: vec![own("joint1", 1.19), own("joint2", 1.24)],
        }],
        statistic: Some(0.8),
        degrees_of_freedom: 1,
        p_value: Some(0.37),
        refused: false,
        sentence: "joint1 and joint2 have it in common.".to_string(),
    }
}

/// Writes the outcome and the predictions of two recordings into a results folder.
fn write_folder(target: &Path, outcome: &Outcome) {
    let header: Vec<Column> = (1..=JOINTS)
        .flat_map(|joint| {
            [Quantity::Recorded, Quantity::Predicted, Quantity::Velocity].map(|quantity| Column {
                joint: format!("joint{joint}"),
                quantity,
            })
        })
        .collect();
    let t: Vec<f64> = (0..3000).map(|k| 0.005 * f64::from(k)).collect();
    let wave = |joint: usize, phase: f64| {
        let w = 0.9 + 0.2 * joint as f64;
        t.iter()
            .map(move |t| (w * t + phase).sin() + 0.4 * (3.1 * w * t).cos())
            .collect::<Vec<f64>>()
    };
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for joint in 0..JOINTS {
        let recorded = wave(joint, 0.0);
        let ripple = (0..t.len()).map(|k| 0.05 * (k as f64 * 12.9898).sin());
        columns.push(
            recorded
                .iter()
                .zip(ripple)
                .map(|(y, e)| 8.0 * (y + e))
                .collect(),
        );
        columns.push(recorded.iter().map(|y| 8.0 * y).collect());
        columns.push(wave(joint, 1.0));
    }
    let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let folder = ResultFolder::prepare(target).unwrap();
    let json = outcome.to_json().unwrap();
    folder
        .write(RESULT_FILE, |out| out.write_all(json.as_bytes()))
        .unwrap();
    folder
        .write(PREDICTIONS_FILE, |out| {
            let mut writer = PredictionsWriter::new(out, &header)?;
            for (recording, split) in [
                ("train.csv", Split::Train),
                ("validation.csv", Split::Validation),
            ] {
                writer.block(&Block {
                    recording,
                    split,
                    t: &t,
                    columns: &columns,
                })?;
            }
            Ok(())
        })
        .unwrap();
    folder.commit().unwrap();
}

fn rendered(outcome: &Outcome) -> String {
    let root = tempfile::tempdir().unwrap();
    let target = root.path().join("fit");
    write_folder(&target, outcome);
    render(&target).unwrap()
}

#[test]
fn the_page_loads_nothing_and_shows_every_section() {
    let page = rendered(&arm());
    // The script may name its author's page; what the page is made of may name none.
    let (document, rest) = page
        .split_once("<script type=\"application/json\"")
        .unwrap();
    let (data, script) = rest.split_once("<script>").unwrap();
    assert_eq!(
        data.matches('<').count(),
        1,
        "the data end where their element ends"
    );
    let (script, end) = script.split_once("</script>").unwrap();
    assert_eq!(end.trim(), "</body>\n</html>");
    for forbidden in [
        "http:", "https:", "//", "src=", "url(", "@import", "<link", "NaN",
    ] {
        assert!(!document.contains(forbidden), "{forbidden}");
    }
    for forbidden in [
        "fetch(",
        "XMLHttpRequest",
        "import(",
        "eval(",
        "new Function",
        "innerHTML",
    ] {
        assert!(!script.contains(forbidden), "{forbidden}");
    }
    let digest = STANDARD.encode(Sha256::digest(script.as_bytes()));
    assert!(document.contains(&format!("script-src 'sha256-{digest}'")));
    for id in [
        "summary",
        "joints",
        "signals",
        "parameters",
        "sharing",
        "base-parameters",
        "comparison",
        "preprocessing",
        "notes",
        "solver",
        "repeat",
    ] {
        assert!(page.contains(&format!("<section id=\"{id}\" ")), "{id}");
        assert!(page.contains(&format!("<a href=\"#{id}\">")), "{id}");
    }
    // Per recording and joint: signals and residual over speed; and the charts with rows.
    assert!(page.matches("<svg ").count() > 2 * 2 * JOINTS);
    assert_eq!(
        page.matches("<svg ").count(),
        page.matches("</svg>").count()
    );
    assert!(!page.contains("could not be drawn"));
    assert!(page.contains("exid fit arm.toml --set &#39;fit.estimator=&quot;wls&quot;&#39;"));
    assert!(page.contains("urdf = &quot;arm.urdf&quot;"));
}

#[test]
fn invariant_the_page_depends_on_the_folder_alone() {
    assert_eq!(rendered(&arm()), rendered(&arm()));
}

#[test]
fn undetermined_parameters_are_names_in_one_line_that_unfolds() {
    let page = rendered(&arm());
    let folded = page
        .split("<details class=\"undetermined\">")
        .nth(1)
        .unwrap();
    let folded = folded.split("</details>").next().unwrap();
    assert!(folded.starts_with("<summary>8 undetermined"));
    assert_eq!(folded.matches("<code>").count(), 8);
    assert!(folded.contains("<code>link1.<wbr>com_<wbr>y</code>"));
    // Nowhere else do they have a row.
    assert_eq!(
        page.matches("<code>link1.<wbr>com_<wbr>y</code>").count(),
        1
    );
}

#[test]
fn text_of_users_is_escaped_everywhere() {
    let bad = "<img src=x onerror='a'>&\"";
    let mut outcome = arm();
    outcome.name = bad.to_string();
    outcome.run.problem = json!({"name": bad});
    outcome.run.inputs[0].path = bad.to_string();
    outcome.estimate.joints[0].joint = bad.to_string();
    outcome.estimate.joints[0].unit = bad.to_string();
    outcome.estimate.parameters[0].name = bad.to_string();
    outcome.estimate.parameters[1].name = format!("{bad}.{bad}");
    outcome.estimate.parameters[2].unit = bad.to_string();
    outcome.estimate.parameters[3].description = bad.to_string();
    if let Part::Fit(fit) = &mut outcome.part {
        fit.base_parameters[0].expression = bad.to_string();
        fit.comparison[0].name = bad.to_string();
        fit.comparison[0].effects[0] = bad.to_string();
        fit.preprocessing[0].text = bad.to_string();
        fit.notes[0] = bad.to_string();
    }
    let page = rendered(&outcome);
    assert!(!page.contains("<img"));
    assert!(page.contains("&lt;img"));
}

#[test]
fn a_solver_that_did_not_converge_is_the_first_thing_said() {
    let mut outcome = arm();
    if let Some(solver) = &mut outcome.estimate.solver {
        solver.converged = false;
        solver.stop = "iteration_limit".to_string();
    }
    let page = rendered(&outcome);
    let alert = page.find("did not converge (iteration limit)").unwrap();
    assert!(alert < page.find("class=\"lead\"").unwrap());
    assert!(!rendered(&arm()).contains("class=\"alert\""));
}

#[test]
fn matches_the_expected_terminal_summary() {
    let mut outcome = arm();
    outcome.estimate.joints.truncate(2);
    outcome.estimate.joints[1].rmse_validation = None;
    let text = text::summary(&outcome, Some(Path::new("results/arm/fit/report.html")));
    assert_eq!(
        text,
        "\
six_joint_arm: fit
  joint   unit  RMSE train  held out    noise  relative train  held out
  joint1  A         0.2100    0.2373   0.1785          2.00 %    2.40 %
  joint2  A         0.1050         –  0.08925          4.00 %    4.80 %
rank 36 of 78, condition number 87.30, physically feasible
parameters: 32 from data, 1 from the prior, 1 on a bound, 6 known, 8 undetermined
  joint        Fc [N·m]  Fv [N·m·s/rad]         Jm [kg·m²]
  joint1    9.30 ± 0.28    14.10 ± 0.42  3.700e-5 ± 1.1e-6
  joint2    4.65 ± 0.14     7.05 ± 0.21  1.850e-5 ± 5.5e-7
  joint3  3.100 ± 0.093     4.70 ± 0.14  1.233e-5 ± 3.7e-7
  joint4  2.325 ± 0.070     3.52 ± 0.11  9.250e-6 ± 2.8e-7
  joint5  1.860 ± 0.056   2.820 ± 0.085  7.400e-6 ± 2.2e-7
  joint6  1.550 ± 0.046   2.350 ± 0.070  6.167e-6 ± 1.8e-7
  of                mass [kg]       com_x [m]  inertia_zz [kg·m²]         com_y [m]
  link1          -4.80 ± 0.14  -0.480 ± 0.014  -0.00480 ± 0.00014
  link2  -8.00 ± 0.24 (bound)                  -0.00800 ± 0.00024  -0.0800 ± 0.0024
  link3                        -2.400 ± 0.072                      -0.2400 ± 0.0072
  link4  24.00 ± 0.72 (prior)   2.400 ± 0.072   0.02400 ± 0.00072
  link5           8.00 ± 0.24                   0.00800 ± 0.00024   0.0800 ± 0.0024
  link6                         0.480 ± 0.014                       0.0480 ± 0.0014
20 base parameters:
  link1.inertia_xx + 0.1000*link2.i…  2.500 ± 0.020 kg·m²  link1.inertia_xx + 0.1000*link2.i…  0.227 ± 0.020 kg·m²
  link1.inertia_xx + 0.1000*link2.i…  1.250 ± 0.020 kg·m²  link1.inertia_xx + 0.1000*link2.i…  0.208 ± 0.020 kg·m²
  link1.inertia_xx + 0.1000*link2.i…  0.833 ± 0.020 kg·m²  link1.inertia_xx + 0.1000*link2.i…  0.192 ± 0.020 kg·m²
  link1.inertia_xx + 0.1000*link2.i…  0.625 ± 0.020 kg·m²  link1.inertia_xx + 0.1000*link2.i…  0.179 ± 0.020 kg·m²
  link1.inertia_xx + 0.1000*link2.i…  0.500 ± 0.020 kg·m²  link1.inertia_xx + 0.1000*link2.i…  0.167 ± 0.020 kg·m²
  link1.inertia_xx + 0.1000*link2.i…  0.417 ± 0.020 kg·m²  link1.inertia_xx + 0.1000*link2.i…  0.156 ± 0.020 kg·m²
  link1.inertia_xx + 0.1000*link2.i…  0.357 ± 0.020 kg·m²  link1.inertia_xx + 0.1000*link2.i…  0.147 ± 0.020 kg·m²
  link1.inertia_xx + 0.1000*link2.i…  0.312 ± 0.020 kg·m²  link1.inertia_xx + 0.1000*link2.i…  0.139 ± 0.020 kg·m²
  link1.inertia_xx + 0.1000*link2.i…  0.278 ± 0.020 kg·m²  link1.inertia_xx + 0.1000*link2.i…  0.132 ± 0.020 kg·m²
  link1.inertia_xx + 0.1000*link2.i…  0.250 ± 0.020 kg·m²  link1.inertia_xx + 0.1000*link2.i…  0.125 ± 0.020 kg·m²
maximum_likelihood converged (cost tolerance) after 7 iterations
joint1 and joint2 have it in common.
note: 6 periods averaged; the last 0.31 s left out.
report: results/arm/fit/report.html
"
    );
}

fn finding(severity: Severity, code: &str) -> Mistake {
    Mistake {
        code: code.to_string(),
        severity,
        file: Some("train.csv".to_string()),
        channel: Some("i2".to_string()),
        message: "the current <opposes> the motion".to_string(),
        remedy: "change its sign".to_string(),
        line: None,
    }
}

#[test]
fn findings_are_told_the_worst_first() {
    let outcome = Outcome {
        mistakes: Vec::new(),
        estimate: Estimate::default(),
        part: Part::Check(Check {
            findings: vec![
                finding(Severity::Note, "late"),
                finding(Severity::Error, "sign"),
            ],
        }),
        ..arm()
    };
    let page = html::page(&outcome, &Tables::default());
    assert!(page.contains("1 error, 1 note"));
    assert!(page.find("<code>sign</code>") < page.find("<code>late</code>"));
    assert!(page.contains("&lt;opposes&gt;"));
    assert!(!page.contains("id=\"parameters\""));
    let text = text::summary(&outcome, None);
    assert!(text.contains(
        "error: train.csv: i2: the current <opposes> the motion [sign]\n  change its sign\n"
    ));
}

/// The result, not what is noted on the inputs, is what a reader came for.
#[test]
fn several_notes_on_the_inputs_of_a_result_are_folded() {
    let page = |mistakes| {
        let outcome = Outcome { mistakes, ..arm() };
        html::page(&outcome, &Tables::default())
    };
    let late = || finding(Severity::Note, "late");
    let several = page(vec![late(), finding(Severity::Error, "sign"), late()]);
    let fold = several
        .find("<details class=\"notes\"><summary>2 notes: ")
        .unwrap();
    assert!(several.find("<code>sign</code>").unwrap() < fold);
    assert!(!page(vec![late()]).contains("<details class=\"notes\">"));
    let long = Mistake {
        message: "word ".repeat(80),
        ..late()
    };
    assert!(page(vec![long]).contains("<details class=\"notes\"><summary>1 note: "));
}

#[test]
fn code_in_notes_is_set_as_code() {
    let part = Part::Design(Design {
        notes: vec!["more `design.starts` may help".to_string()],
        ..Design::default()
    });
    let page = html::page(&Outcome { part, ..arm() }, &Tables::default());
    assert!(page.contains("more <code>design.<wbr>starts</code> may help"));
}

#[test]
fn a_value_that_nothing_states_is_no_number() {
    let part = Part::Design(Design {
        expected_std_dev: vec![ExpectedDeviation {
            name: "link1.mass".to_string(),
            unit: "kg".to_string(),
            std_dev: Some(0.1),
            value: None,
        }],
        ..Design::default()
    });
    let page = html::page(&Outcome { part, ..arm() }, &Tables::default());
    assert!(page.contains("data-label=\"Value\">–</td>"));
}

#[test]
fn a_design_that_was_cut_off_can_be_used_and_is_no_solution() {
    let mut outcome = Outcome {
        part: Part::Design(Design::default()),
        ..arm()
    };
    outcome.estimate.solver = outcome.estimate.solver.map(|solver| Solver {
        converged: false,
        stop: "iteration_limit".to_string(),
        ..solver
    });
    let sentence = "feasible; stopped at the iteration limit after 7 iterations";
    let page = html::page(&outcome, &Tables::default());
    assert!(page.contains(sentence) && !page.contains("class=\"alert\""));
    assert!(text::summary(&outcome, None).contains(sentence));
}

#[test]
fn a_rollout_has_nothing_of_a_model_before_the_fit_where_there_is_none() {
    let spread = Spread {
        median: Some(0.5),
        ..Spread::default()
    };
    let page = |before: Option<Before>| {
        let joint = JointErrors {
            joint: "joint1".to_string(),
            unit: "rad".to_string(),
            before: before.map(|_| spread),
            after: spread,
            noise: spread,
            integration: 1e-6,
        };
        let part = Part::Rollout(Box::new(Rollout {
            before,
            horizons: vec![Horizon {
                horizon: 0.5,
                joints: vec![joint],
            }],
            integrator: Integrator {
                checked: 1,
                ..Integrator::default()
            },
            ..Rollout::default()
        }));
        html::page(&Outcome { part, ..arm() }, &Tables::default())
    };
    let (alone, beside) = (page(None), page(Some(Before::DeclaredFitted)));
    assert!(alone.contains("the steps change in 1 window, RMS"));
    assert!(!alone.contains("<th class=\"number\">Before</th>"));
    assert!(beside.contains("<th class=\"number\">Before</th>"));
    assert!(!alone.contains("– to –") && !beside.contains("– to –"));
}

#[test]
fn a_simulation_names_its_files_and_noise() {
    let outcome = Outcome {
        mistakes: Vec::new(),
        estimate: Estimate::default(),
        part: Part::Simulate(Simulation {
            files: vec!["train.csv".to_string()],
            realised_noise: vec![RealisedNoise {
                channel: "i1".to_string(),
                unit: "A".to_string(),
                std_dev: 0.5,
            }],
            positions: Vec::new(),
            notes: Vec::new(),
        }),
        ..arm()
    };
    let page = html::page(&outcome, &Tables::default());
    assert!(page.contains("<code>train.<wbr>csv</code>") && page.contains("0.5000"));
    assert!(text::summary(&outcome, None).contains("noise of i1: 0.5000 A"));
}

#[test]
fn a_folder_without_predictions_still_has_a_report() {
    let root = tempfile::tempdir().unwrap();
    std::fs::write(root.path().join(RESULT_FILE), arm().to_json().unwrap()).unwrap();
    let page = render(root.path()).unwrap();
    assert!(page.contains("id=\"parameters\"") && !page.contains("id=\"signals\""));
    let error = render(&root.path().join("nothing")).unwrap_err();
    assert!(error.to_string().contains("nothing"));
}
