//! The page: what was left out, what was found, and how the held-out errors fell.

use crate::Proof;
use exid::diagnose::task::DiagnoseRun;
use exid::outcome::diagnose::Verdict;
use std::fmt::Write;

pub fn page(done: &[(&Proof, DiagnoseRun)]) -> String {
    let mut page = String::from(
        "# Recordings of real robots, with one effect left out of the declared model\n\n\
         The tool sees the recording and the declared model. Held-out errors are of rows that were not fitted: another\n\
         run for the UR10e, the second half of the run for TX40 and EMPS, every third block of the one run with a load.\n\
         The problems are those of `examples/real_proofs`;\n\n\
         ```sh\ncargo run --release --example real_proofs\n```\n\n\
         made this page from public recordings that do not ship (`EXID_DATA`), in a quarter of an hour on two cores.\n",
    );
    for (proof, run) in done {
        section(&mut page, proof, run);
    }
    page
}

fn section(page: &mut String, proof: &Proof, run: &DiagnoseRun) {
    let diagnosis = &run.diagnosis;
    // Writing to a string does not fail.
    let _ = writeln!(page, "\n## {}: {} left out\n", proof.name, proof.left_out);
    let _ = writeln!(page, "By hand: {}.\n", proof.by_hand);
    let _ = writeln!(page, "Verdict: {}.\n", Verdict::or_none(diagnosis.verdict));
    for (k, finding) in diagnosis.findings.iter().enumerate() {
        let _ = writeln!(
            page,
            "{}. `{}`: {}",
            k + 1,
            finding.effect,
            finding.sentence
        );
        for parameter in &finding.parameters {
            if let (Some(value), Some(deviation)) = (parameter.value, parameter.std_dev) {
                let _ = writeln!(
                    page,
                    "   - {} = {value:.4} ± {:.4} {}",
                    parameter.name,
                    2.0 * deviation,
                    parameter.unit
                );
            }
        }
        let rivals = finding.rivals.iter().filter(|r| !r.separable);
        let alike: Vec<&str> = rivals.map(|r| r.effect.as_str()).collect();
        if !alike.is_empty() {
            let _ = writeln!(page, "   - not told apart from {}", alike.join(", "));
        }
    }
    let _ = writeln!(
        page,
        "\n| joint | unit | held out before | after | ratio |\n|---|---|---|---|---|"
    );
    let pairs = diagnosis
        .baseline
        .joints
        .iter()
        .zip(&diagnosis.outcome.joints);
    for (before, after) in pairs {
        if let (Some(old), Some(new)) = (before.rmse_validation, after.rmse_validation) {
            let _ = writeln!(
                page,
                "| {} | {} | {old:.4} | {new:.4} | {:.2} |",
                before.joint,
                before.unit,
                new / old
            );
        }
    }
}
