//! How a design ends: out of time, interrupted, going on from an earlier one, or without a feasible motion.

use crate::bench::{Bench, holds, value};
use crate::common::interrupting::interrupt;
use std::time::{Duration, Instant};

/// Beyond the budget: reading, checking on the dense grid and writing, on a machine that does other work.
const SLACK: Duration = Duration::from_secs(30);

#[test]
fn a_budget_ends_the_search_with_the_best_feasible_so_far() {
    let bench = Bench::shipped("scara_excitation");
    let began = Instant::now();
    let keys = ["design.starts=1000000", "design.budget_s=4"];
    let result = bench.design("out", &keys, 0);
    assert!(began.elapsed() < Duration::from_secs(4) + SLACK);
    assert_eq!(result["solver"]["stop"], "time_limit");
    assert_eq!(result["solver"]["converged"], false);
    assert!(value(&result).is_finite() && holds(&result));
}

/// One start comes to a motion that misses its limits between samples; a smaller one of the same form keeps them.
#[test]
fn a_motion_that_is_scaled_into_its_limits_is_no_solution() {
    let bench = Bench::shipped("h4_parallel");
    let result = bench.design("out", &["design.starts=1"], 0);
    assert!(holds(&result));
    assert_eq!(result["solver"]["stop"], "iteration_limit");
    assert_eq!(result["solver"]["converged"], false);
    let expected = result["expected_std_dev"].as_array().unwrap();
    assert!(expected.iter().all(|d| d["value"].is_null()));
}

/// Seconds in which a seven-joint arm between walls gets no search to its end, or just one.
#[test]
fn a_short_budget_gives_a_motion_that_keeps_the_limits() {
    let bench = Bench::shipped("panda_excitation");
    for seconds in [1, 3, 9] {
        let keys = [format!("design.budget_s={seconds}")];
        let result = bench.design("out", &keys.each_ref().map(String::as_str), 0);
        assert!(value(&result).is_finite() && holds(&result), "{seconds} s");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupt_leaves_the_best_so_far() {
    let bench = Bench::shipped("scara_excitation");
    let child = bench
        .command("out", &["design.budget_s=600", "design.starts=1000000"])
        .spawn()
        .unwrap();
    assert_eq!(interrupt(child, Duration::from_secs(2)), Some(130));
    let result = bench.result("out");
    assert_eq!(result["solver"]["stop"], "interrupted");
    assert_eq!(result["solver"]["converged"], false);
    assert!(value(&result).is_finite());
    for name in ["trajectory.csv", "coefficients.json", "report.html"] {
        assert!(bench.path("out").join(name).exists(), "{name}");
    }
}

#[test]
fn a_design_goes_on_from_an_earlier_one_and_loses_nothing() {
    let bench = Bench::shipped("scara_excitation");
    let first = value(&bench.design("first", &["design.starts=1"], 0));
    for (out, file) in [
        ("result", "result.json"),
        ("coefficients", "coefficients.json"),
    ] {
        let from = format!(
            "design.start_from=\"{}\"",
            bench.path("first").join(file).display()
        );
        let next = bench.design(out, &["design.starts=1", &from], 0);
        println!("{first} goes on to {}", value(&next));
        assert!(holds(&next));
        // Both are checked between samples, and drawn back by parts in a thousand where that shows something.
        assert!(
            value(&next) <= first + 5e-3 * first.abs(),
            "{}",
            value(&next)
        );
    }
}

/// The note that says what stands in the way.
fn obstacle(result: &serde_json::Value) -> String {
    let notes = result["notes"].as_array().unwrap();
    notes[0].as_str().unwrap().to_string()
}

#[test]
fn where_no_motion_is_feasible_the_result_names_the_limit_the_joint_and_the_time() {
    let bench = Bench::shipped("scara_excitation");
    // The elbow turns about the vertical and moves more than a kilogram; its motor may exert next to nothing, and
    // its friction alone takes more.
    let weak = [
        "design.starts=1",
        "design.limits.torque=[220.0, 90.0, 5.0, 4.0]",
    ];
    let result = bench.design("weak", &weak, 4);
    assert_eq!(result["solver"]["stop"], "infeasible");
    assert_eq!(result["solver"]["converged"], false);
    let words = obstacle(&result);
    // The spindle carries 1.1 kg and more against gravity: 5 N do not hold it.
    assert!(
        words.contains("torque of joint `spindle`: at t = "),
        "{words}"
    );
    assert!(words.contains("limit 5"), "{words}");
    let worst = &result["worst_margins"].as_array().unwrap();
    let torque = worst
        .iter()
        .find(|m| m["constraint"] == "torque" && m["joint"] == "spindle")
        .unwrap();
    assert!(torque["margin"].as_f64().unwrap() < 0.0);
    assert!((0.0..=6.0).contains(&torque["time"].as_f64().unwrap()));
    let high = [
        "design.starts=1",
        "design.workspace.halfspace=[{ frame = \"flange\", normal = [0.0, 0.0, 1.0], offset = 2.0 }]",
    ];
    let words = obstacle(&bench.design("high", &high, 4));
    assert!(words.contains("half-space of flange: at t = "), "{words}");
}
