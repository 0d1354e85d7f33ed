//! The task behind `exid diagnose`: from a problem file to findings.

use crate::chain::dataset::Dataset;
use crate::chain::model::Model;
use crate::check;
use crate::diagnose::bench::{Bench, is_in_time};
use crate::diagnose::conclude::{self, Step};
use crate::diagnose::drift;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::floor::{self, Floor};
use crate::diagnose::holdout;
use crate::diagnose::locate::locate;
use crate::diagnose::refit::{Refit, refit};
use crate::diagnose::rest;
use crate::diagnose::rivals::{Contest, Doubt, contest, doubts, exchange};
use crate::diagnose::search::{self, Grown, Rules, Trial, fit_without, grow, prune};
use crate::diagnose::smooth::{self, Smooth};
use crate::diagnose::summary;
use crate::diagnose::{next, outweighed, own, shadow};
use crate::estimate::bandwidth;
use crate::estimate::figures::{Predictions, noise_rms, predictions};
use crate::estimate::fit::{Fitted, outcome};
use crate::estimate::task::{notes, preprocessing};
use crate::outcome::diagnose::{Baseline, Diagnosis, Final, Finding};
use crate::outcome::estimate::Estimate;
use crate::outcome::parameter::Parameter;
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::problem_file::diagnose::SoughtEffects;
use crate::recording::split::Split;
use crate::setup;
use nalgebra::DVector;

/// A diagnosis with the recordings that it was made from.
#[derive(Debug)]
pub struct DiagnoseRun {
    pub diagnosis: Diagnosis,
    pub estimate: Estimate,
    pub model: Model,
    /// Values of the parameters of that model.
    pub values: DVector<f64>,
    pub data: Dataset,
    /// Predictions of the declared and of the final model, `[recording][channel][row]`.
    pub baseline: Predictions,
    pub finally: Predictions,
    /// Findings with rivals that the recordings cannot set aside.
    pub doubts: Vec<Doubt>,
}

/// Steps of a diagnosis, as progress shows them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    Reading,
    Checking,
    Fitting,
    Searching { found: usize },
    Comparing,
    Drift,
}

impl Stage {
    pub fn words(self) -> String {
        match self {
            Self::Reading => "reading and differentiating the recordings".to_string(),
            Self::Checking => "looking for mistakes in the inputs".to_string(),
            Self::Fitting => "fitting the declared model".to_string(),
            Self::Searching { found } => {
                format!("trying what may be missing ({found} found so far)")
            }
            Self::Drift => "looking at what changes from period to period".to_string(),
            Self::Comparing => "comparing what was found with its rivals".to_string(),
        }
    }
}

/// The grown model with the evidence for each finding.
struct Explanation {
    full: Refit,
    needed: Vec<Trial>,
    contests: Vec<Contest>,
    /// Models with the first 0, 1, ... findings.
    prefixes: Vec<Refit>,
    examined: usize,
    /// Joints of names that explained less than they left.
    withdrawn: Vec<usize>,
    /// Every hypothesis that was fitted while the model grew.
    tried: Vec<search::Step>,
}

impl Explanation {
    /// One finding after the other.
    fn steps(&self) -> Vec<Step<'_>> {
        let step = |k: usize| Step {
            before: &self.prefixes[k],
            after: &self.prefixes[k + 1],
            needed: &self.needed[k],
            contest: &self.contests[k],
        };
        (0..self.full.hypotheses.len()).map(step).collect()
    }
}

/// Runs a diagnosis; `watch` hears of every stage.
pub fn run(
    problem: &ProblemFile,
    control: &Control<'_>,
    watch: &(dyn Fn(Stage) + Sync),
) -> Result<DiagnoseRun, DiagnoseError> {
    watch(Stage::Reading);
    let robot = setup::robot::open(problem)?;
    let mut model = setup::model::build(problem, &robot)?;
    let prior = setup::prior::build(problem, &mut model)?;
    let data = bandwidth::prepared(problem, &robot, &model, &prior, control)?;
    let (data, held_out) = holdout::with_held_out(rest::left_out(&model, data));
    watch(Stage::Checking);
    let mistakes = check::run(problem, control);
    let split = |data: Dataset| match held_out || !is_in_time(&data) {
        true => (data, Vec::new()),
        false => own::alternate(&data),
    };
    let (data, between) = split(data);
    let mut bench = Bench {
        between,
        ..Bench::new((problem, &robot), &data, control)
    };
    watch(Stage::Fitting);
    let declared = baseline(&bench)?;
    bench.noise = noise_rms(&declared.model, &declared.values, &data);
    let sought = sought(problem);
    let rules = Rules {
        sought: sought.as_deref(),
        significance: problem.diagnose.significance.value,
    };
    let explanation = explain(&bench, &declared, (rules, watch))?;
    let (unrolled, between) = split(drift::unrolled(&data));
    let over_time = Bench {
        between,
        noise: bench.noise.clone(),
        ..Bench::new((problem, &robot), &unrolled, control)
    };
    let drifting = over_periods(&over_time, (&data, &explanation.full), (rules, watch))?;
    let drifts = drifting.is_some();
    let (mut diagnosis, fitted, [before, after], doubts) = match drifting {
        Some(grown) => {
            let explanation = conclude_search(&over_time, grown, (rules, watch))?;
            report(&over_time, (&explanation, rules))?
        }
        None => report(&bench, (&explanation, rules))?,
    };
    diagnosis.mistakes = mistakes;
    let note = held_out.then(|| HELD_OUT.to_string());
    diagnosis.notes.extend(note);
    Ok(DiagnoseRun {
        diagnosis,
        estimate: fitted.estimate,
        model: fitted.model,
        values: fitted.values,
        baseline: before,
        finally: after,
        doubts,
        data: if drifts { unrolled } else { data },
    })
}

const HELD_OUT: &str = "No recording is kept for validation: every third of twelve blocks of each training \
                        recording was held out of the fits and is what the held-out figures are of.";

/// The model grown by what changes from period to period, if anything does.
fn over_periods(
    bench: &Bench<'_>,
    (data, full): (&Dataset, &Refit),
    (rules, watch): (Rules<'_>, &(dyn Fn(Stage) + Sync)),
) -> Result<Option<Grown>, DiagnoseError> {
    let Some(effects) = drift::sought(data, rules) else {
        return Ok(None);
    };
    watch(Stage::Drift);
    let rules = Rules {
        sought: Some(&effects),
        ..rules
    };
    drift::found(bench, (full, rules))
}

fn sought(problem: &ProblemFile) -> Option<Vec<String>> {
    match &problem.diagnose.effects.value {
        SoughtEffects::All => None,
        SoughtEffects::Listed(ids) => Some(ids.iter().map(|id| id.value.clone()).collect()),
    }
}

fn baseline(bench: &Bench<'_>) -> Result<Refit, DiagnoseError> {
    let first = bench.signal_rms(Split::Train);
    let fit = || refit(bench, &[], (&Vec::new(), &first));
    bench.memory.refit(&[], fit)
}

/// Rounds in which a finding may be exchanged for a better rival.
const EXCHANGES: usize = 3;

fn explain(
    bench: &Bench<'_>,
    baseline: &Refit,
    (rules, watch): (Rules<'_>, &(dyn Fn(Stage) + Sync)),
) -> Result<Explanation, DiagnoseError> {
    let searching = |found| watch(Stage::Searching { found });
    let grown = grow(bench, baseline.clone(), (rules, &searching))?;
    conclude_search(bench, grown, (rules, watch))
}

/// Prunes a grown model, has rivals contest each finding, exchanges what is bettered, and withdraws names that explain
/// less than they leave or that are the shadow of another joint.
fn conclude_search(
    bench: &Bench<'_>,
    mut grown: Grown,
    (rules, watch): (Rules<'_>, &(dyn Fn(Stage) + Sync)),
) -> Result<Explanation, DiagnoseError> {
    let searching = |found| watch(Stage::Searching { found });
    let examined = grown.examined;
    watch(Stage::Comparing);
    let mut tried = grown.steps.clone();
    let mut round = 0;
    let mut withdrawn = Vec::new();
    loop {
        let (full, needed) = prune(bench, grown.refit.clone(), (rules, examined))?;
        let floor = floor::of_rows(bench, &full, &[]);
        let contests = (0..full.hypotheses.len())
            .map(|k| contest(bench, &full, (k, rules, &floor)))
            .collect::<Result<Vec<_>, _>>()?;
        let mut exchanged = None;
        for (k, contest) in contests.iter().enumerate() {
            if exchanged.is_none() && round < EXCHANGES {
                exchanged = exchange(bench, (contest, k))?;
            }
        }
        match exchanged {
            Some(refit) => {
                grown = grow(bench, refit, (rules, &searching))?;
                tried.extend(grown.steps.iter().cloned());
                round += 1;
            }
            None => {
                let withdraw = outweighed::weakest(&floor, &full, &contests).or_else(|| {
                    shadow::first((bench, rules.significance), (&floor, &full), &contests)
                });
                if let Some(k) = withdraw {
                    withdrawn.extend(full.hypotheses[k].named_joints());
                    grown.refit = fit_without(bench, &full, k)?;
                    round = EXCHANGES;
                    continue;
                }
                return Ok(Explanation {
                    prefixes: prefixes(bench, &full)?,
                    full,
                    needed,
                    contests,
                    examined,
                    withdrawn,
                    tried,
                });
            }
        }
    }
}

/// Models with the first 0, 1, ... of the findings of a model.
fn prefixes(bench: &Bench<'_>, full: &Refit) -> Result<Vec<Refit>, DiagnoseError> {
    let mut prefixes = vec![full.clone()];
    for count in (0..full.hypotheses.len()).rev() {
        let shorter = fit_without(bench, &prefixes[0], count)?;
        prefixes.insert(0, shorter);
    }
    Ok(prefixes)
}

const UNMEASURED: &str = "Nothing repeats, so the noise is not known apart from the misfit: shares are of what the \
                          best model found takes away, and what it leaves counts as noise.";

type Reported = (Diagnosis, Fitted, [Predictions; 2], Vec<Doubt>);

fn report(
    bench: &Bench<'_>,
    (explanation, rules): (&Explanation, Rules<'_>),
) -> Result<Reported, DiagnoseError> {
    let full = &explanation.full;
    // The search may have found a better fit of the declared model than its first one.
    let baseline = &baseline(bench)?;
    let recordings = bench.recordings(Split::Train);
    let fitted = |refit: &Refit| outcome(&refit.problem(&recordings), &refit.solution, bench.data);
    let (mut before, mut after) = (fitted(baseline), fitted(full));
    let smooths = smooth::of_all(bench, full);
    let tried = smooths.len();
    let needed: Vec<&Smooth> = smooths
        .iter()
        .filter(|s| conclude::is_needed(s, (rules.significance, tried)))
        .collect();
    let floor = floor::of_rows(bench, full, &needed);
    let parameters = after.estimate.parameters.clone();
    let cut_short = bench.control.is_interrupted();
    let of_smooth = (&needed[..], tried);
    let findings = findings(
        bench,
        (explanation, rules, &floor),
        (of_smooth, &parameters),
    );
    let corrected = summary::correct(bench, (full, &mut after), &needed);
    if bench.in_time && floor.measured {
        // Between periods there is also what the findings say changes from one to the next.
        for fitted in [&mut before, &mut after] {
            floor.judge(&fitted.model, &mut fitted.estimate.joints);
        }
    }
    let lacks = lacks(&floor, &findings, (baseline, full));
    let verdict = conclude::verdict(&findings, lacks);
    let mut notes = notes(&after.model, bench.data);
    notes.extend((!floor.measured).then(|| UNMEASURED.to_string()));
    let diagnosis = Diagnosis {
        verdict,
        summary: summary::paragraph(verdict, &findings, (explanation.examined, cut_short)),
        located: locate(bench, baseline, rules.significance),
        findings,
        mistakes: Vec::new(),
        spoiled: conclude::spoiled(&before.estimate.parameters, &parameters),
        baseline: Baseline {
            joints: before.estimate.joints,
        },
        outcome: Final {
            joints: after.estimate.joints.clone(),
            parameters,
        },
        next_experiment: next::experiment(bench, full, &explanation.contests),
        preprocessing: preprocessing(&after.model, bench.data),
        notes,
        fit: Some(after.fit.clone()),
        evidence: conclude::evidence(&explanation.tried),
    };
    let first = predictions(&baseline.model, &baseline.values, bench.data);
    let doubts = doubts(full, &explanation.contests);
    Ok((diagnosis, after, [first, corrected], doubts))
}

/// What has a name, what a smooth correction takes the place of, and what is left.
fn findings(
    bench: &Bench<'_>,
    (explanation, rules, floor): (&Explanation, Rules<'_>, &Floor),
    ((smooths, tried), parameters): ((&[&Smooth], usize), &[Parameter]),
) -> Vec<Finding> {
    let full = &explanation.full;
    let mut findings = conclude::findings(&explanation.steps(), floor, parameters);
    let cut_short = bench.control.is_interrupted();
    let without_name = smooths
        .iter()
        .map(|s| conclude::unnamed(s, full, (floor, tried, cut_short)));
    findings.extend(without_name);
    let open = conclude::unexplained(
        bench,
        ([&explanation.prefixes[0], full], floor, rules.significance),
        (&findings, &explanation.withdrawn, cut_short),
    );
    findings.extend(open);
    findings
}

/// Lack of fit of two models pooled over the joints that findings name.
fn lacks(floor: &Floor, findings: &[Finding], (before, after): (&Refit, &Refit)) -> (f64, f64) {
    let channels = after.model.channels().iter().enumerate();
    let named = channels.filter(|(_, c)| findings.iter().any(|f| f.joints.contains(&c.name)));
    let joints: Vec<usize> = named.map(|(c, _)| c).collect();
    let lack = |refit: &Refit| floor.lack_of_fit(&refit.validation, &joints);
    (lack(before), lack(after))
}
