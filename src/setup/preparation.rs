//! How recordings are filtered and differentiated, as a problem file says it.

use crate::problem_file::choices::DifferentiationMethod;
use crate::problem_file::{Located, RecordingsTable};
use crate::recording::settings::{Differentiation, InCommon, Method, Preparation};

/// How the problem file wants its recordings made ready.
pub fn preparation(table: &RecordingsTable) -> Preparation {
    let number = |entry: &Option<Located<f64>>| entry.as_ref().map(|e| e.value);
    let differentiation = &table.differentiation;
    Preparation {
        rate: number(&table.rate),
        period: number(&table.period),
        differentiation: Differentiation {
            method: differentiation.method.as_ref().map(|m| match m.value {
                DifferentiationMethod::Fourier => Method::Fourier,
                DifferentiationMethod::Smoother => Method::Smoother,
                DifferentiationMethod::Lowpass => Method::Lowpass,
            }),
            cutoff_hz: number(&differentiation.cutoff_hz),
            parallel_hz: number(&differentiation.parallel_hz),
            in_common: InCommon::default(),
        },
    }
}
