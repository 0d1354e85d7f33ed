//! Exported code, compiled and run, gives the signal of the chain.

use super::*;

/// A program that calls the exported functions at the states and prints what they give, line by line.
fn rust_driver(functions: &[String], motion: &Motion) -> String {
    let mut text = String::from("mod robot;\nuse robot::*;\nfn main() {\n");
    for state in 0..STATES {
        let row = |order: usize| motion[order].iter().map(|s| s[state]).collect::<Vec<f64>>();
        for function in functions {
            text.push_str(&format!(
                "    {{ let mut out = [0.0; JOINTS]; {function}(&{:?}, &{:?}, &{:?}, &mut out);\n      \
                 println!(\"{{:?}}\", out); }}\n",
                row(0),
                row(1),
                row(2)
            ));
        }
    }
    text + "}\n"
}

fn c_driver(functions: &[String], motion: &Motion) -> String {
    let mut text = String::from("#include \"robot.h\"\n#include <stdio.h>\nint main(void) {\n");
    for state in 0..STATES {
        let row = |order: usize| {
            let values = motion[order].iter().map(|s| format!("{:?}", s[state]));
            format!("(double[]){{{}}}", values.collect::<Vec<_>>().join(", "))
        };
        for function in functions {
            text.push_str(&format!(
                "  {{ double out[ROBOT_JOINTS]; robot_{function}({}, {}, {}, out); printf(\"[\");\n    \
                 for (int k = 0; k < ROBOT_JOINTS; k++) printf(k ? \",%.17g\" : \"%.17g\", out[k]);\n    \
                 printf(\"]\\n\"); }}\n",
                row(0),
                row(1),
                row(2)
            ));
        }
    }
    text + "  return 0;\n}\n"
}

/// Runs a compiler and the program it makes; `None`, recorded as a skip, where there is no such compiler.
pub fn run(folder: &Path, compiler: &str, arguments: &[&str]) -> Option<Vec<Vec<f64>>> {
    let compiled = Command::new(compiler)
        .current_dir(folder)
        .args(arguments)
        .output();
    let Ok(compiled) = compiled else {
        common::skip(&format!("no {compiler} on this machine"));
        return None;
    };
    let words = String::from_utf8_lossy(&compiled.stderr);
    assert!(compiled.status.success() && words.is_empty(), "{words}");
    let output = Command::new(folder.join("driver")).output().unwrap();
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    Some(
        text.lines()
            .map(|line| serde_json::from_str(line).unwrap())
            .collect(),
    )
}

/// Exported code gives joint torques and the signal, without and with the load.
fn assert_code(
    format: Format,
    compile: impl Fn(&Path, &[String], &Motion) -> Option<Vec<Vec<f64>>>,
) {
    for case in cases() {
        case.export(format);
        let current = case.machine().joints[0].torque_constant.is_some();
        let last = if current {
            "motor_current"
        } else {
            "motor_torque"
        };
        let loads: &[bool] = if case.machine().payload.is_some() {
            &[false, true]
        } else {
            &[false]
        };
        let suffix = |loaded: &bool| if *loaded { "_with_load" } else { "" };
        let functions: Vec<String> = loads
            .iter()
            .flat_map(|l| ["joint_torque", last].map(|f| format!("{f}{}", suffix(l))))
            .collect();
        let motors = motion(case.model.tree().len());
        let joints = case.joints(&motors);
        let Some(rows) = compile(case.folder.path(), &functions, &joints) else {
            return;
        };
        let expected: Vec<Vec<Vec<f64>>> = loads
            .iter()
            .flat_map(|&l| {
                [
                    torques(&case.machine().tree(l), &joints),
                    case.signal(&motors, l),
                ]
            })
            .collect();
        for (f, expected) in expected.iter().enumerate() {
            let found: Vec<Vec<f64>> = (0..joints[0].len())
                .map(|j| {
                    (0..STATES)
                        .map(|s| rows[s * functions.len() + f][j])
                        .collect()
                })
                .collect();
            assert_close(&found, expected, TORQUES, &functions[f]);
        }
    }
}

#[test]
fn invariant_rust_code_gives_the_signal() {
    assert_code(Format::Rust, |folder, functions, motion| {
        fs::write(folder.join("driver.rs"), rust_driver(functions, motion)).unwrap();
        let arguments = [
            "--edition",
            "2021",
            "-A",
            "dead_code",
            "driver.rs",
            "-o",
            "driver",
        ];
        run(folder, "rustc", &arguments)
    });
}

#[test]
fn invariant_c_code_gives_the_signal() {
    assert_code(Format::C, |folder, functions, motion| {
        fs::write(folder.join("driver.c"), c_driver(functions, motion)).unwrap();
        let arguments = [
            "-std=c99",
            "-Wall",
            "-Wextra",
            "-pedantic",
            "driver.c",
            "robot.c",
            "-o",
            "driver",
            "-lm",
        ];
        run(folder, "cc", &arguments)
    });
}

#[test]
fn names_cannot_leave_a_comment_or_a_text() {
    let names = [
        "*/ #error \"\n#error\\",
        "\"\"\"\nraise SystemExit(1)\n\"\"\" # ' \\",
        "/* \r #error \u{2028} {} %s ??/",
    ];
    for (format, compiler, arguments) in [
        (
            Format::C,
            "cc".into(),
            vec!["-std=c99", "-pedantic", "-Wall", "-c", "robot.c"],
        ),
        (
            Format::Rust,
            "rustc".into(),
            vec!["--crate-type", "lib", "-Adead_code", "robot.rs"],
        ),
        (
            Format::NumPy,
            drives::python().unwrap_or_else(|| "no Python".into()),
            vec!["-W", "error", "robot.py"],
        ),
    ] {
        let [mut case, ..] = cases();
        let Part::Fit(fit) = &mut case.outcome.part else {
            panic!("a fit")
        };
        let machine = fit.machine.as_mut().unwrap();
        for (joint, name) in machine.joints.iter_mut().zip(names) {
            joint.name = name.to_string();
        }
        case.outcome.name = "*/\n#error \"\"\" \\".to_string();
        let (_, first) = case.export(format);
        let arguments = arguments.into_iter().map(|a| match a.split_once('.') {
            Some(("robot", ending)) => first.with_extension(ending).display().to_string(),
            _ => a.to_string(),
        });
        let compiled = Command::new(&compiler)
            .current_dir(case.folder.path())
            .args(arguments)
            .output();
        match compiled {
            Err(_) => common::skip(&format!("no {compiler:?} on this machine")),
            Ok(output) => {
                let words = String::from_utf8_lossy(&output.stderr);
                assert!(output.status.success() && words.is_empty(), "{words}");
            }
        }
    }
}
