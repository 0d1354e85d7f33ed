//! The search of a diagnosis over prepared recordings: selection, conclusion and report, and again where the motion does not suit what
//! was selected, or beside what changes from period to period.

use crate::chain::dataset::Dataset;
use crate::diagnose::conclusion::explanation::{Explaining, Explanation};
use crate::diagnose::conclusion::last_selection::LastSelection;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::findings::report::{Reported, Reporting};
use crate::diagnose::fit::context::is_in_time;
use crate::diagnose::fit::contexts::{Contexts, HeldOutHalves};
use crate::diagnose::fit::declared::Declared;
use crate::diagnose::fit::held_out;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::fit::recording_parameters;
use crate::diagnose::selection::between_periods;
use crate::diagnose::selection::stepwise::{Rules, Selection};
use crate::diagnose::stage::Stage;
use crate::estimate::bandwidth::Preparing;
use crate::problem::defect::{Defect, guarded};
use crate::problem::solution::Control;
use crate::problem_file::RecordingsTable;
use crate::setup::model_spec::ModelSpec;
use crate::setup::recording_file::RecordedRobot;
use crate::setup::robot::Robot;

/// Recordings whose held-out rows are in two halves.
pub(super) struct Recorded {
    /// The rows that fit, choose and test.
    pub halves: HeldOutHalves,
    /// Rows of the training recordings were held out.
    pub held_out: bool,
}

impl Recorded {
    /// Of recordings, of which some rows are held out where none of them is.
    pub fn of(data: Dataset) -> Self {
        let (data, held_out) = held_out::with_held_out(data);
        Self {
            halves: halves(data, held_out),
            held_out,
        }
    }
}

/// The held-out rows in halves; parameters of one recording are fitted between them where these are samples in the order
/// of time and not blocks of what was fitted.
fn halves(data: Dataset, held_out: bool) -> HeldOutHalves {
    match held_out || !is_in_time(&data) {
        true => HeldOutHalves::of(data, Vec::new()),
        false => {
            let (judged, between) = recording_parameters::alternate(&data);
            HeldOutHalves::of(judged, between)
        }
    }
}

/// The search of a diagnosis over prepared recordings.
pub(super) struct Search<'a> {
    /// Where the recordings are, of which the motion may be estimated anew.
    pub recordings: &'a RecordingsTable,
    /// As its file says.
    pub robot: &'a Robot,
    /// The declared model.
    pub declared: &'a ModelSpec,
    /// What is sought, and how sure a finding has to be.
    pub rules: Rules<'a>,
    /// Rows of the training recordings were held out.
    pub held_out: bool,
    /// The motion may be estimated anew beside what is found.
    pub may_move: bool,
    /// Hears of every stage.
    pub on_stage: &'a (dyn Fn(Stage) + Sync),
}

/// What a search comes to.
pub(super) enum Searched {
    /// What is to be reported.
    Found(Box<Found>),
    /// The recordings with a motion that suits what was selected, in which the search begins again.
    Moved(Dataset),
}

/// What a search reports.
pub(super) struct Found {
    /// Findings and the final model.
    pub reported: Reported,
    /// The recordings that it is of, where these are not the given ones.
    pub data: Option<Dataset>,
}

impl Search<'_> {
    /// What a search finds, or had found when a defect ended it.
    pub fn guarded(
        &self,
        halves: &HeldOutHalves,
        declared: &Declared,
        control: &Control<'_>,
    ) -> Result<(Searched, Option<Defect>), DiagnoseError> {
        let reached = LastSelection::default();
        let search = || self.whole(halves, declared, control, &reached);
        let defect = match guarded(search) {
            Ok(found) => return Ok((found?, None)),
            Err(defect) => defect,
        };
        // The declared model alone, where the defect lies in what was selected.
        for selection in [reached.get(), None] {
            let at = selection.unwrap_or_else(|| Selection::of(declared.fit.clone()));
            let report = || self.stopped_at(halves, declared, at);
            if let Ok(Ok(found)) = guarded(report) {
                return Ok((Searched::Found(Box::new(found)), Some(defect)));
            }
        }
        Err(defect.into())
    }

    /// Grows the declared model and reports what it has become.
    fn whole(
        &self,
        halves: &HeldOutHalves,
        declared: &Declared,
        control: &Control<'_>,
        reached: &LastSelection,
    ) -> Result<Searched, DiagnoseError> {
        let contexts = self.contexts(halves, declared, control)?;
        let explaining = self.explaining(&contexts, reached);
        let selection = explaining.select(declared.fit.clone())?;
        // An interrupt loses the motion that is estimated anew, and not what was selected.
        let moved = match self.moved(&selection.fit, &halves.whole, control) {
            Err(_) if control.is_interrupted() => None,
            moved => moved?,
        };
        if let Some(data) = moved {
            return Ok(Searched::Moved(data));
        }
        let explanation = explaining.conclude(selection)?;
        let changing =
            between_periods::sought(&halves.whole, declared.fit.model.catalogue(), self.rules);
        if let Some(effects) = changing.filter(|_| !control.is_interrupted()) {
            (self.on_stage)(Stage::Drift);
            let successive_periods =
                self::halves(halves.whole.in_successive_periods(), self.held_out);
            let mut over_time = successive_periods.contexts(self.declared, control);
            over_time.set(&declared.limits, declared.noise.as_deref());
            // What is selected there is of other rows than those that a defect leaves.
            let apart = LastSelection::default();
            let explaining = self.explaining(&over_time, &apart);
            if let Some(reported) = self.over_periods(&explaining, &explanation.full, &effects)? {
                return Ok(Searched::Found(Box::new(Found {
                    reported,
                    data: Some(successive_periods.whole),
                })));
            }
        }
        Ok(Searched::Found(Box::new(Found {
            reported: self.report(&explaining, explanation)?,
            data: None,
        })))
    }

    /// The recordings with the motion that suits a model with findings, if that is another one.
    fn moved(
        &self,
        found: &ModelFit,
        present: &Dataset,
        control: &Control<'_>,
    ) -> Result<Option<Dataset>, DiagnoseError> {
        if found.hypotheses.is_empty() || !self.may_move {
            return Ok(None);
        }
        let model = found.started();
        let preparing = Preparing {
            recorded: RecordedRobot {
                table: self.recordings,
                robot: self.robot,
                model: &model,
            },
            prior: &found.prior,
            control,
        };
        Ok(preparing.anew(present)?)
    }

    /// Reports a selected model as a search that is interrupted there does.
    fn stopped_at(
        &self,
        halves: &HeldOutHalves,
        declared: &Declared,
        selection: Selection,
    ) -> Result<Found, DiagnoseError> {
        let stopped = Control::stopped();
        let contexts = self.contexts(halves, declared, &stopped)?;
        let reached = LastSelection::default();
        let explaining = self.explaining(&contexts, &reached);
        let explanation = explaining.conclude(selection)?;
        Ok(Found {
            reported: self.report(&explaining, explanation)?,
            data: None,
        })
    }

    /// Contexts that know the declared model.
    fn contexts<'c>(
        &'c self,
        halves: &'c HeldOutHalves,
        declared: &Declared,
        control: &'c Control<'c>,
    ) -> Result<Contexts<'c>, DiagnoseError> {
        let mut contexts = halves.contexts(self.declared, control);
        contexts.set(&declared.limits, declared.noise.as_deref());
        let known = || Ok(declared.fit.clone());
        contexts.selection.cache.fit_model(&[], known)?;
        Ok(contexts)
    }

    fn explaining<'c>(
        &'c self,
        contexts: &'c Contexts<'c>,
        reached: &'c LastSelection,
    ) -> Explaining<'c> {
        Explaining {
            contexts,
            rules: self.rules,
            on_stage: self.on_stage,
            reached,
        }
    }

    /// What is to be reported where effects that change from period to period are found beside what explains the averages.
    fn over_periods(
        &self,
        explaining: &Explaining<'_>,
        full: &ModelFit,
        effects: &[String],
    ) -> Result<Option<Reported>, DiagnoseError> {
        let of_time = Rules {
            sought: Some(effects),
            ..explaining.rules
        };
        let context = &explaining.contexts.selection;
        let Some(selection) = between_periods::found(context, full, of_time)? else {
            return Ok(None);
        };
        let explanation = explaining.conclude(selection)?;
        let is_of_time = |h: &Hypothesis| effects.iter().any(|id| id == h.effect.id);
        match explanation.full.hypotheses.iter().any(is_of_time) {
            true => self.report(explaining, explanation).map(Some),
            false => Ok(None),
        }
    }

    /// Reports an explanation, without the names in whose place formulas leave less.
    fn report(
        &self,
        explaining: &Explaining<'_>,
        mut explanation: Explanation,
    ) -> Result<Reported, DiagnoseError> {
        loop {
            let reporting = Reporting {
                contexts: explaining.contexts,
                explanation: &explanation,
                rules: explaining.rules,
            };
            let reported = reporting.report()?;
            let outdone = reported.nameless.outdone();
            if outdone.is_empty() {
                return Ok(reported);
            }
            explanation = explaining.without(&explanation, &outdone)?;
        }
    }
}
