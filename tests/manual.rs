//! What the command line says of itself: examples in every help, completions, pages of `man`.

use std::process::Command;

fn exid(arguments: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_exid"));
    let output = command.args(arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}");
    String::from_utf8(output.stdout).unwrap()
}

/// The verbs as the help lists them.
fn verbs() -> Vec<String> {
    let help = exid(&["--help"]);
    let (_, rest) = help.split_once("Commands:\n").unwrap();
    let (list, _) = rest.split_once("\n\n").unwrap();
    let words = list.lines().filter_map(|line| {
        // A second line of a description is indented further.
        let line = line.strip_prefix("  ").filter(|l| !l.starts_with(' '))?;
        line.split_whitespace().next()
    });
    words.filter(|w| *w != "help").map(str::to_owned).collect()
}

#[test]
fn every_verb_has_examples_that_name_it() {
    let verbs = verbs();
    assert!(verbs.len() >= 12, "{verbs:?}");
    for verb in verbs {
        let help = exid(&[&verb, "--help"]);
        let (_, examples) = help.split_once("\nExample").expect(&verb);
        let (_, examples) = examples.split_once(":\n").unwrap();
        let lines: Vec<&str> = examples.lines().take_while(|l| !l.is_empty()).collect();
        assert!(!lines.is_empty(), "{verb}");
        let start = format!("  exid {verb} ");
        let own = |line: &str| line.starts_with(&start) || line == start.trim_end();
        assert!(lines.iter().all(|line| own(line)), "{verb}: {examples}");
    }
}

#[test]
fn completions_know_every_verb() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let text = exid(&["completions", shell]);
        assert!(verbs().iter().all(|verb| text.contains(verb)), "{shell}");
    }
}

/// The shell itself reads what is printed for it.
#[test]
fn bash_completes_verbs() {
    let script = exid(&["completions", "bash"]);
    let words =
        "COMP_WORDS=(exid dia); COMP_CWORD=1; _exid exid dia exid; echo \"${COMPREPLY[@]}\"";
    let bash = Command::new("bash")
        .args(["-c", &format!("{script}\n{words}")])
        .output();
    // Where there is no such shell there is nothing to read it.
    if let Ok(output) = bash {
        assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), "diagnose");
    }
}

#[test]
fn manual_has_a_page_for_every_verb() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("man1");
    exid(&["man", target.to_str().unwrap()]);
    let page = |name: &str| std::fs::read_to_string(target.join(name)).unwrap();
    assert!(page("exid.1").contains(".SH SUBCOMMANDS"));
    for verb in verbs() {
        assert!(
            page(&format!("exid-{verb}.1")).contains(".SH EXAMPLES\n"),
            "{verb}"
        );
    }
}
