//! Formulas that diagnoses propose for laws which nobody told them of: their variables, their blocks, and none where there is
//! nothing to be said.

use super::{Folder, Problem};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;
use std::fs;

/// A law of the elbow that no diagnosis knows: its torque, the truth, and the variables that a formula for it has to have.
struct Hidden {
    torque: &'static str,
    truth: &'static [(&'static str, f64)],
    variables: &'static [&'static str],
}

const SPEED_OF_SHOULDER: Hidden = Hidden {
    torque: "a*v[shoulder]*abs(v)",
    truth: &[("a", 0.25)],
    variables: &["v[shoulder]", "v"],
};

const LAWS: &[Hidden] = &[
    SPEED_OF_SHOULDER,
    Hidden {
        torque: "a*q[shoulder]*sin(3*q)",
        truth: &[("a", 1.5)],
        variables: &["q[shoulder]", "q"],
    },
    Hidden {
        torque: "a*tau*sin(n*q + phi)",
        truth: &[("a", 0.25), ("n", 9.0), ("phi", 0.4)],
        variables: &["tau", "q"],
    },
    Hidden {
        torque: "a*q[shoulder]*v",
        truth: &[("a", 1.5)],
        variables: &["q[shoulder]", "v"],
    },
];

/// Less noise than other tests have: laws of a few hundredths of a newton metre are to be seen.
fn quiet(folder: &Folder, name: &str) {
    let text = fs::read_to_string(folder.path(name)).unwrap();
    let text = text.replacen("noise = [0.02, 0.02]", "noise = [0.004, 0.004]", 1);
    fs::write(folder.path(name), text).unwrap();
}

/// A folder with recordings in which a law acts, and a problem that does not know it.
fn concealing(hidden: Option<&Hidden>, seed: &str) -> Folder {
    concealing_in(hidden, seed, &|text| text)
}

/// The same in recordings of which both problems say something else.
fn concealing_in(hidden: Option<&Hidden>, seed: &str, change: &dyn Fn(String) -> String) -> Folder {
    let folder = Folder::new();
    let (mut laws, mut values) = (String::new(), String::new());
    if let Some(hidden) = hidden {
        laws = format!(
            "[[law]]\nid = \"hidden\"\nsentence = \"Hidden.\"\nacts_on = \"motor\"\ntorque = {:?}\n[law.parameters]\n",
            hidden.torque
        );
        for (name, value) in hidden.truth {
            laws += &format!("{name} = {{ typical = {value:?} }}\n");
            values += &format!("\"elbow.hidden.{name}\" = {value:?}\n");
        }
    }
    let effects: &[&str] = if hidden.is_some() { &["hidden"] } else { &[] };
    folder.write(
        "truth.toml",
        &Problem {
            effects,
            laws: &laws,
            values: &values,
            ..Problem::default()
        },
    );
    folder.write("problem.toml", &Problem::default());
    for name in ["truth.toml", "problem.toml"] {
        quiet(&folder, name);
        let text = fs::read_to_string(folder.path(name)).unwrap();
        fs::write(folder.path(name), change(text)).unwrap();
    }
    folder.simulate("truth.toml", seed);
    folder
}

fn diagnosed(folder: &Folder) -> Value {
    folder.json(&["diagnose", "problem.toml", "--json", "--out", "found"])
}

/// The formulas of a diagnosis.
fn formulas(result: &Value) -> Vec<Value> {
    let findings = result["findings"].as_array().unwrap().iter();
    let formulas = findings.map(|finding| finding["formula"].clone());
    formulas.filter(|formula| !formula.is_null()).collect()
}

/// The variables of a formula, each once.
fn variables(expression: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    // The exponent of a number is no variable.
    let plain = ["e-", "e+"]
        .iter()
        .fold(expression.to_string(), |text, e| text.replace(e, ""));
    let mut rest = plain.as_str();
    while let Some(start) = rest.find(char::is_alphabetic) {
        rest = &rest[start..];
        let word = rest
            .find(|c: char| !c.is_alphanumeric())
            .unwrap_or(rest.len());
        let end = match rest[word..].starts_with('[') {
            true => rest.find(']').unwrap() + 1,
            false => word,
        };
        let name = &rest[..end];
        let is_function = rest[end..].starts_with('(');
        if (!is_function || name == "sign") && !found.iter().any(|known| known == name) {
            found.push(name.to_string());
        }
        rest = &rest[end..];
    }
    found.retain(|name| name != "sign");
    found.sort();
    found
}

#[test]
fn recognises_variables_of_formulas() {
    let found = variables("0.3·tau·sin(8.00·q + 1.2) - 1e-3·v[a 1]·abs(v)·sign(v)");
    assert_eq!(found, ["q", "tau", "v", "v[a 1]"]);
}

#[test]
fn formulas_have_the_variables_of_laws_that_were_concealed() {
    for hidden in LAWS {
        for seed in ["1", "2"] {
            let result = diagnosed(&concealing(Some(hidden), seed));
            let found = formulas(&result);
            let said = format!(
                "{} of seed {seed}: {found:#?}\n{}",
                hidden.torque, result["summary"]
            );
            assert_eq!(found.len(), 1, "{said}");
            assert_eq!(found[0]["joint"], "elbow", "{said}");
            let mut expected = hidden.variables.to_vec();
            expected.sort_unstable();
            assert_eq!(
                variables(found[0]["expression"].as_str().unwrap()),
                expected,
                "{said}"
            );
            assert!(found[0]["explains"].as_f64().unwrap() > 0.9, "{said}");
            assert!(found[0]["probability"].as_f64().unwrap() > 0.95, "{said}");
        }
    }
}

#[test]
fn recovers_known_truth_of_a_concealed_law_and_its_block_is_fitted() {
    let folder = concealing(Some(&SPEED_OF_SHOULDER), "1");
    let result = diagnosed(&folder);
    let [formula] = &formulas(&result)[..] else {
        panic!("{}", result["summary"]);
    };
    let [size] = &formula["parameters"].as_array().unwrap()[..] else {
        panic!("{formula:#}");
    };
    let (found, std_dev) = (
        size["value"].as_f64().unwrap(),
        size["std_dev"].as_f64().unwrap(),
    );
    // Four deviations, and what differentiation of positions with encoder counts leaves: 1 %.
    assert!(
        (found.abs() - 0.25).abs() < 4.0 * std_dev + 0.01 * 0.25,
        "{formula:#}"
    );
    let id = formula["effect"].as_str().unwrap();
    assert_eq!(size["name"], format!("elbow.{id}.a"));
    // The block in the problem file, and the file of the results folder as its laws.
    let block = formula["law"].as_str().unwrap();
    let file = fs::read_to_string(folder.path("found/formulas.toml")).unwrap();
    assert_eq!(file, block);
    for (laws, top) in [(block, ""), ("", "laws = [\"found/formulas.toml\"]")] {
        let with = Problem {
            laws,
            top,
            effects: &[id],
            ..Problem::default()
        };
        folder.write("with.toml", &with);
        let checked = folder.json(&["check", "with.toml", "--json", "--out", "checked"]);
        let findings = checked["findings"].as_array().unwrap();
        assert!(
            findings.iter().all(|f| f["severity"] != "error"),
            "{findings:#?}"
        );
        let fit = folder.json(&["fit", "with.toml", "--json", "--out", "fit"]);
        let [again, _] = super::parameter(&fit, &format!("elbow.{id}.a"));
        assert!((again - found).abs() < 2.0 * std_dev, "{again} and {found}");
    }
}

/// Nothing repeats, and no smooth function follows a wave of so many periods: nothing attests the noise, and a formula alone says
/// that what is left is none.
#[test]
fn what_is_left_and_not_known_to_be_noise_is_given_a_formula() {
    let hidden = Hidden {
        torque: "a*sin(n*q[shoulder] + phi)",
        truth: &[("a", 1.2), ("n", 12.0), ("phi", 0.4)],
        variables: &["q[shoulder]"],
    };
    let folder = concealing_in(Some(&hidden), "1", &|text| {
        let text = text.replace(
            "period = 4.0\n[design]\nperiod = 4.0",
            "[design]\nperiod = 24.0",
        );
        text.replace("periods = 3", "periods = 1")
    });
    let result = diagnosed(&folder);
    let [formula] = &formulas(&result)[..] else {
        panic!("{}", result["summary"]);
    };
    let said = result["summary"].as_str().unwrap();
    assert!(said.contains("no smooth correction"), "{said}");
    assert_eq!(formula["joint"], "elbow");
    assert_eq!(
        variables(formula["expression"].as_str().unwrap()),
        hidden.variables
    );
    assert!(formula["explains"].as_f64().unwrap() > 0.9, "{formula:#}");
}

/// A torque that has the sign of no friction at half of the positions, and outweighs that of the joint.
#[test]
fn what_drives_a_joint_is_a_formula_where_none_that_brakes_is_as_good() {
    let hidden = Hidden {
        torque: "a*v*abs(v)*tanh(q[shoulder]/0.3)",
        truth: &[("a", 10.0)],
        variables: &["q[shoulder]", "v"],
    };
    let result = diagnosed(&concealing(Some(&hidden), "1"));
    let [formula] = &formulas(&result)[..] else {
        panic!("{}", result["summary"]);
    };
    assert_eq!(formula["drives"], true, "{formula:#}");
    assert_eq!(
        variables(formula["expression"].as_str().unwrap()),
        hidden.variables
    );
}

/// The mean of the one is a torque constant, and the signal of the shoulder takes a part of the other.
#[test]
fn a_law_of_another_joint_is_not_given_the_name_of_a_part_of_it() {
    let by_position = Hidden {
        torque: "a*tau*exp(n*q[shoulder])",
        truth: &[("a", 0.3), ("n", -0.6)],
        variables: &["q[shoulder]", "tau"],
    };
    let by_speed = Hidden {
        torque: "a*exp(n*v[shoulder])",
        truth: &[("a", 0.5), ("n", -0.8)],
        variables: &["v[shoulder]"],
    };
    for hidden in [by_position, by_speed] {
        let result = diagnosed(&concealing(Some(&hidden), "1"));
        let findings = result["findings"].as_array().unwrap();
        let [finding] = &findings[..] else {
            panic!("{}", result["summary"]);
        };
        assert_eq!(finding["effect"], "unnamed", "{}", result["summary"]);
        let formula = finding["formula"]["expression"].as_str().unwrap();
        assert_eq!(variables(formula), hidden.variables, "{formula}");
    }
}

#[test]
fn where_nothing_is_concealed_there_is_no_formula() {
    for seed in ["1", "2", "3"] {
        let result = diagnosed(&concealing(None, seed));
        assert!(formulas(&result).is_empty(), "seed {seed}: {result:#}");
        assert!(
            result["findings"].as_array().unwrap().is_empty(),
            "seed {seed}"
        );
    }
}

/// First-order noise on a current: each sample remembers 0.98 of the last, a quarter of a second at 200 Hz.
fn with_red_noise(text: &str, seed: u64) -> String {
    const MEMORY: f64 = 0.98;
    const DEVIATION: f64 = 0.03;
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let mut lines = text.lines();
    let mut out = lines.next().unwrap().to_string() + "\n";
    let column = out.trim().split(',').position(|name| name == "i2").unwrap();
    let mut state = 0.0;
    for line in lines {
        let step: f64 = StandardNormal.sample(&mut random);
        state = MEMORY * state + DEVIATION * (1.0 - MEMORY * MEMORY).sqrt() * step;
        let mut cells: Vec<String> = line.split(',').map(str::to_string).collect();
        let value: f64 = cells[column].parse().unwrap();
        cells[column] = format!("{}", value + state);
        out += &(cells.join(",") + "\n");
    }
    out
}

#[test]
fn red_noise_is_no_formula() {
    for seed in 1..4 {
        let folder = concealing(None, &seed.to_string());
        for (k, file) in ["train.csv", "validation.csv"].into_iter().enumerate() {
            let text = fs::read_to_string(folder.path(file)).unwrap();
            let noisy = with_red_noise(&text, 10 * seed + k as u64);
            fs::write(folder.path(file), noisy).unwrap();
        }
        let result = diagnosed(&folder);
        assert!(
            formulas(&result).is_empty(),
            "seed {seed}: {}",
            result["findings"]
        );
    }
}
