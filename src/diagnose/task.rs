//! The task behind `exid diagnose`: from a problem file to findings.

use crate::chain::dataset::Dataset;
use crate::chain::model::Model;
use crate::check;
use crate::diagnose::bench::{Bench, is_in_time};
use crate::diagnose::benches::{Benches, Halves};
use crate::diagnose::conclude::{self, LackOfFit, Step};
use crate::diagnose::corrections::Corrections;
use crate::diagnose::drift;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::floor::{self, Floor};
use crate::diagnose::holdout;
use crate::diagnose::hypothesis::{self, Hypothesis};
use crate::diagnose::judge;
use crate::diagnose::locate::locate;
use crate::diagnose::refit::{Refit, refit};
use crate::diagnose::rest;
use crate::diagnose::rivals::{Contest, Doubt, contest, doubts, exchange};
use crate::diagnose::search::{self, Grown, Rules, Trial, fit_without, grow, prune};
use crate::diagnose::smooth::Smooth;
use crate::diagnose::summary::{self, About};
use crate::diagnose::uncertainty::Uncertainty;
use crate::diagnose::{next, outweighed, own, shadow};
use crate::estimate::bandwidth;
use crate::estimate::covariance::of_unknowns;
use crate::estimate::figures::{Predictions, noise_rms, predictions};
use crate::estimate::fit::{Fitted, outcome, outcome_with};
use crate::estimate::task::{notes, preprocessing};
use crate::outcome::check::Finding as Mistake;
use crate::outcome::diagnose::{Baseline, Diagnosis, Final, Finding, Unattested, Verdict};
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
    /// A mismatch that is a mistake in the input, not physics.
    pub mistakes: Vec<Mistake>,
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
    /// Each finding on rows that no choice has seen.
    tests: Vec<Trial>,
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
    /// One finding after the other, on rows that no choice has seen.
    fn steps<'b>(
        &'b self,
        benches: &Benches<'_>,
        (contests, floor): (&'b [Contest], &Floor),
    ) -> Vec<Step<'b>> {
        let step = |k: usize| {
            let (test, contest) = (&self.tests[k], &contests[k]);
            let rows = benches.testing(&test.hypothesis);
            Step {
                before: self.prefixes[k].on(rows),
                after: self.prefixes[k + 1].on(rows),
                test,
                contest,
                probabilities: judge::probabilities(rows, (test, contest), floor),
            }
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
    let mut halves = halves(data, held_out);
    let mut benches = halves.benches(problem, &robot, control);
    watch(Stage::Fitting);
    let declared = baseline(&benches.selection)?;
    let noise = noise_rms(&declared.model, &declared.values, &halves.whole);
    benches.set_noise(noise.clone());
    let sought = sought(problem);
    let rules = Rules {
        sought: sought.as_deref(),
        significance: problem.diagnose.significance.value,
    };
    let explanation = explain(&benches, &declared, (rules, watch))?;
    let reported = match drift::sought(&halves.whole, rules) {
        Some(effects) => {
            watch(Stage::Drift);
            let unrolled = self::halves(drift::unrolled(&halves.whole), held_out);
            let mut over_time = unrolled.benches(problem, &robot, control);
            over_time.set_noise(noise);
            let full = &explanation.full;
            let found = over_periods(&over_time, (full, &effects), (rules, watch))?;
            found.map(|reported| (reported, unrolled))
        }
        None => None,
    };
    let mut reported = match reported {
        Some((over_time, unrolled)) => {
            halves = unrolled;
            over_time
        }
        None => report(&benches, (&explanation, rules))?,
    };
    let note = held_out.then(|| HELD_OUT.to_string());
    reported.diagnosis.notes.extend(note);
    let estimated = &reported.diagnosis.outcome.parameters;
    let differences = setup::declared::differences(problem, &robot, &model, estimated);
    reported.diagnosis.notes.extend(differences);
    Ok(DiagnoseRun {
        diagnosis: reported.diagnosis,
        mistakes,
        estimate: reported.fitted.estimate,
        model: reported.fitted.model,
        values: reported.fitted.values,
        baseline: reported.declared,
        finally: reported.last,
        doubts: reported.doubts,
        data: halves.whole,
    })
}

const HELD_OUT: &str = "No recording is kept for validation: every third of twelve blocks of each training \
                        recording was held out of the fits and is what the held-out figures are of.";

/// The held-out rows in halves; parameters of one recording are fitted between them where these are samples in the order
/// of time and not blocks of what was fitted.
fn halves(data: Dataset, held_out: bool) -> Halves {
    match held_out || !is_in_time(&data) {
        true => Halves::of(data, Vec::new()),
        false => {
            let (judged, between) = own::alternate(&data);
            Halves::of(judged, between)
        }
    }
}

/// What is to be reported where effects that change from period to period are found beside what explains the averages.
fn over_periods(
    benches: &Benches<'_>,
    (full, effects): (&Refit, &[String]),
    (rules, watch): (Rules<'_>, &(dyn Fn(Stage) + Sync)),
) -> Result<Option<Reported>, DiagnoseError> {
    let of_time = Rules {
        sought: Some(effects),
        ..rules
    };
    let Some(grown) = drift::found(&benches.selection, (full, of_time))? else {
        return Ok(None);
    };
    let explanation = conclude_search(benches, grown, (rules, watch))?;
    let of_time = |h: &Hypothesis| effects.iter().any(|id| id == h.effect.id);
    match explanation.full.hypotheses.iter().any(of_time) {
        true => report(benches, (&explanation, rules)).map(Some),
        false => Ok(None),
    }
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
    benches: &Benches<'_>,
    baseline: &Refit,
    (rules, watch): (Rules<'_>, &(dyn Fn(Stage) + Sync)),
) -> Result<Explanation, DiagnoseError> {
    let searching = |found| watch(Stage::Searching { found });
    let choice = rules.of_choice();
    let grown = grow(&benches.selection, baseline.clone(), (choice, &searching))?;
    conclude_search(benches, grown, (rules, watch))
}

/// Prunes a grown model, has rivals contest each finding, exchanges what is bettered, withdraws names that explain
/// less than they leave or that are the shadow of another joint, and strikes out what fails on rows that chose nothing.
fn conclude_search(
    benches: &Benches<'_>,
    mut grown: Grown,
    (rules, watch): (Rules<'_>, &(dyn Fn(Stage) + Sync)),
) -> Result<Explanation, DiagnoseError> {
    let (bench, choice) = (&benches.selection, rules.of_choice());
    let searching = |found| watch(Stage::Searching { found });
    let examined = grown.examined;
    watch(Stage::Comparing);
    let mut tried = grown.steps.clone();
    let mut round = 0;
    let mut withdrawn = Vec::new();
    let mut tested = 0;
    loop {
        let full = prune(bench, grown.refit.clone(), (choice, examined))?;
        let floor = floor::of_rows(bench, &full, &[]);
        let contests = (0..full.hypotheses.len())
            .map(|k| contest(bench, &full, (k, choice, &floor)))
            .collect::<Result<Vec<_>, _>>()?;
        let mut exchanged = None;
        for (k, contest) in contests.iter().enumerate() {
            if exchanged.is_none() && round < EXCHANGES {
                exchanged = exchange(bench, (contest, k))?;
            }
        }
        if let Some(refit) = exchanged {
            grown = grow(bench, refit, (choice, &searching))?;
            tried.extend(grown.steps.iter().cloned());
            round += 1;
            continue;
        }
        let withdraw = outweighed::weakest(&floor, &full, &contests)
            .or_else(|| shadow::first((bench, rules.significance), (&floor, &full), &contests));
        if let Some(k) = withdraw {
            withdrawn.extend(full.hypotheses[k].named_joints());
            grown.refit = fit_without(bench, &full, k)?;
            round = EXCHANGES;
            continue;
        }
        tested = tested.max(full.hypotheses.len());
        let prefixes = prefixes(bench, &full)?;
        let tests = judge::tests(benches, &full, tested)?;
        let failing = judge::failing(benches, (&prefixes, &tests), rules.significance);
        if let Some(k) = failing {
            grown.refit = fit_without(bench, &full, k)?;
            round = EXCHANGES;
            continue;
        }
        return Ok(Explanation {
            prefixes,
            full,
            tests,
            contests,
            examined,
            withdrawn,
            tried,
        });
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

/// What is said of a model that a search has come to.
struct Reported {
    diagnosis: Diagnosis,
    fitted: Fitted,
    /// Predictions of the declared model.
    declared: Predictions,
    /// Predictions of the final model, with its corrections.
    last: Predictions,
    doubts: Vec<Doubt>,
}

fn report(
    benches: &Benches<'_>,
    (explanation, rules): (&Explanation, Rules<'_>),
) -> Result<Reported, DiagnoseError> {
    let bench = &benches.whole;
    let full = &explanation.full.on(bench);
    // The search may have found a better fit of the declared model than its first one.
    let baseline = &baseline(&benches.selection)?.on(bench);
    let recordings = bench.recordings(Split::Train);
    let mut before = outcome(
        &baseline.problem(&recordings),
        &baseline.solution,
        bench.data,
    );
    let of_full = full.problem(&recordings);
    let covariance = of_unknowns(&of_full, &full.solution.x);
    let predicted = Uncertainty::of(bench, full, covariance.as_ref());
    let mut after = outcome_with(&of_full, (&full.solution, covariance), bench.data);
    let corrections = Corrections::of(benches, &explanation.full, rules);
    let smooths: Vec<Smooth> = corrections.on(bench, full);
    let smooths: Vec<&Smooth> = smooths.iter().collect();
    let floor = floor::of_rows(bench, full, &smooths);
    let parameters = after.estimate.parameters.clone();
    let reporting = Reporting {
        benches,
        explanation,
        rules,
        corrections: &corrections,
        floor: &floor,
        predicted: &predicted,
        baseline,
        full,
    };
    let contests = reporting.contests();
    let findings = reporting.findings(&contests, &parameters);
    let corrected = summary::correct(bench, (full, &mut after), &smooths);
    judged_in_time(bench, &floor, [&mut before, &mut after]);
    let unattested = conclude::unattested(bench, full, &smooths, &floor, &predicted);
    let verdict = reporting.verdict(&findings, &unattested);
    let unmeasured = (!floor.measured).then(|| UNMEASURED.to_string());
    let diagnosis = Diagnosis {
        verdict,
        summary: reporting.summary(verdict, (&findings, &unattested)),
        located: locate(bench, baseline, rules.significance),
        findings,
        unattested,
        spoiled: conclude::spoiled(&before.estimate.parameters, &parameters),
        baseline: Baseline {
            joints: before.estimate.joints,
        },
        outcome: Final {
            joints: after.estimate.joints.clone(),
            parameters,
        },
        next_experiment: next::experiment(bench, full, &contests),
        preprocessing: preprocessing(&after.model, bench.data),
        notes: notes(&after.model, bench.data)
            .into_iter()
            .chain(unmeasured)
            .collect(),
        fit: Some(after.fit.clone()),
        evidence: conclude::evidence(&explanation.tried),
    };
    Ok(Reported {
        diagnosis,
        fitted: after,
        declared: predictions(&baseline.model, &baseline.values, bench.data),
        last: corrected,
        doubts: doubts(full, &contests),
    })
}

/// Effects of which a search that was interrupted has not fitted every hypothesis beside the model that it had come to.
fn untried(benches: &Benches<'_>, explanation: &Explanation, rules: Rules<'_>) -> Vec<String> {
    let (bench, full) = (&benches.selection, &explanation.full);
    let from = (&full.model, &full.prior);
    let last = explanation.tried.last().filter(|step| step.is_complete);
    let fitted = |h: &Hypothesis| last.is_some_and(|s| s.trials.iter().any(|t| t.hypothesis == *h));
    let open = hypothesis::open(from, (rules.sought, bench.in_time));
    let left = open.iter().filter(|h| !fitted(h)).map(|h| h.effect.id);
    let mut left: Vec<String> = left.map(str::to_string).collect();
    left.dedup();
    left
}

/// Between periods there is also what the findings say changes from one to the next.
fn judged_in_time(bench: &Bench<'_>, floor: &Floor, fitted: [&mut Fitted; 2]) {
    if bench.in_time && floor.measured {
        for fitted in fitted {
            floor.judge(&fitted.model, &mut fitted.estimate.joints);
        }
    }
}

/// What a report is made of.
struct Reporting<'b, 'a> {
    benches: &'b Benches<'a>,
    explanation: &'b Explanation,
    rules: Rules<'b>,
    corrections: &'b Corrections,
    floor: &'b Floor,
    predicted: &'b Uncertainty,
    /// The declared model, over all held-out rows.
    baseline: &'b Refit,
    /// The final model, over all held-out rows.
    full: &'b Refit,
}

impl Reporting<'_, '_> {
    fn is_cut_short(&self) -> bool {
        self.benches.whole.control.is_interrupted()
    }

    fn contests(&self) -> Vec<Contest> {
        let contests = self.explanation.contests.iter();
        let seen = contests.zip(&self.full.hypotheses);
        seen.map(|(contest, own)| contest.on(self.benches, self.floor, (self.full, own)))
            .collect()
    }

    /// What has a name, what a smooth correction takes the place of, and what is left.
    fn findings(&self, contests: &[Contest], parameters: &[Parameter]) -> Vec<Finding> {
        let steps = self.explanation.steps(self.benches, (contests, self.floor));
        let mut findings = conclude::findings(&steps, self.floor, parameters);
        findings.extend(self.corrections.findings(self.floor, self.is_cut_short()));
        findings.extend(conclude::unexplained(
            &self.benches.whole,
            (
                [self.baseline, self.full],
                self.floor,
                self.rules.significance,
            ),
            self.predicted,
            (&findings, &self.explanation.withdrawn, self.is_cut_short()),
        ));
        findings
    }

    /// `None` of a search that was interrupted.
    fn verdict(&self, findings: &[Finding], unattested: &[Unattested]) -> Option<Verdict> {
        let lack = || LackOfFit {
            before: self.lack_of_fit(self.baseline, findings),
            after: self.lack_of_fit(self.full, findings),
        };
        let verdict = || conclude::verdict(findings, lack(), unattested);
        (!self.is_cut_short()).then(verdict)
    }

    /// Pooled over the joints that findings name.
    fn lack_of_fit(&self, refit: &Refit, findings: &[Finding]) -> f64 {
        let channels = refit.model.channels().iter().enumerate();
        let named = channels.filter(|(_, c)| findings.iter().any(|f| f.joints.contains(&c.name)));
        let joints: Vec<usize> = named.map(|(c, _)| c).collect();
        self.floor.lack_of_fit(&refit.validation, &joints)
    }

    fn summary(
        &self,
        verdict: Option<Verdict>,
        (findings, unattested): (&[Finding], &[Unattested]),
    ) -> String {
        let about = About {
            examined: self.explanation.examined,
            unattested,
            untried: untried(self.benches, self.explanation, self.rules),
        };
        summary::paragraph(verdict, findings, &about)
    }
}
