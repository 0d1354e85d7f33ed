//! Command lines that break, results folders that are in the way, results that are none.

use crate::bench::Bench;
use crate::{Case, case};

fn out(bench: &mut Bench, folder: &str) {
    bench.command(&["fit", "problem.toml", "--out", folder]);
}

#[rustfmt::skip]
pub const CASES: &[Case] = &[
    case("a misspelled verb", 2, ["subcommand", "'fits'", "similar subcommand exists: 'fit'"], |b| b.command(&["fits", "problem.toml"])),
    case("no problem", 2, ["<PROBLEM>", "not provided", "Usage: exid fit"], |b| b.command(&["fit"])),
    case("an unknown flag", 2, ["argument '--thread'", "unexpected", "'--threads'"], |b| b.with(&["--thread", "2"])),
    case("no threads", 2, ["--threads", "'0'", "1..=1024"], |b| b.with(&["--threads", "0"])),
    case("threads in words", 2, ["--threads", "'two'", "invalid digit"], |b| b.with(&["--threads", "two"])),
    case("a negative seed", 2, ["--seed", "'-1'", "invalid digit"], |b| b.with(&["--seed=-1"])),
    case("an override without a value", 2, ["problem.toml: --set fit.estimator", "\"fit.estimator\"", "fit.estimator=wls"], |b| b.with(&["--set", "fit.estimator"])),
    case("an override of an unknown key", 2, ["fit.estimater", "unknown key \"estimater\"", "mean \"estimator\"?"], |b| b.with(&["--set", "fit.estimater=wls"])),
    case("an override with a broken value", 2, ["--set drive.torque_constant", "[1, 2", "quote it for the shell"], |b| b.with(&["--set", "drive.torque_constant=[1, 2"])),
    case("an override below a number", 2, ["--set recordings.differentiation.cutoff_hz.low", "has no keys", "as a whole"], |b| b.with(&["--set", "recordings.differentiation.cutoff_hz.low=1"])),
    case("an override that is too deep", 2, ["problem.toml: ", "18 parts", "name a key"], |b| b.with(&["--set", "a.b.c.d.e.f.g.h.i.j.k.l.m.n.o.p.q.r=1"])),
    case("an override with a wrong word", 2, ["--set fit.estimator", "\"wsl\"", "mean \"wls\"?"], |b| b.with(&["--set", "fit.estimator=wsl"])),
    case("an unknown effect", 2, ["effect", "`backlsh`", "mean `"], |b| b.command(&["effects", "backlsh"])),
    case("a file where the results go", 2, ["notes.txt: ", "a file is where", "--out"], |b| { b.write("notes.txt", "mine"); out(b, "notes.txt"); }),
    case("results below a file", 2, ["notes.txt/fit: ", "could not", "check the path"], |b| { b.write("notes.txt", "mine"); out(b, "notes.txt/fit"); }),
    case("a folder with other files", 2, ["mine: ", "`thesis.txt`", "empty this one"], |b| { b.folder("mine"); b.write("mine/thesis.txt", "all of it"); out(b, "mine"); }),
    case("the working folder", 2, [".: ", "replace the working directory", "run from elsewhere"], |b| out(b, ".")),
    case("a folder nobody may write to", 2, ["locked/fit: ", "no permission", "change the permissions"], |b| { b.folder("locked"); b.forbid("locked", 0o555); out(b, "locked/fit"); }),
    case("a report of no folder", 2, ["none", "No such file", "check the path"], |b| b.command(&["report", "none"])),
    case("a report of another folder", 2, ["mine/result.json: ", "not the result of a run", "run wrote"], |b| { b.folder("mine"); b.write("mine/result.json", "[1, 2]"); b.command(&["report", "mine"]); }),
    case("a report of a problem file", 2, ["problem.toml: ", "not the result of a run", "folder that a run wrote"], |b| b.command(&["report", "problem.toml"])),
];
