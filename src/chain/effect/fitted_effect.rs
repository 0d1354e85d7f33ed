//! An effect with its fitted values, from which the sentence of a finding is made.

use crate::chain::signal::Signal;
use crate::chain::words::short;

/// A parameter of a finding.
#[derive(Debug, Clone, Copy)]
pub struct Estimated<'a> {
    /// Within its effect.
    pub name: &'a str,
    /// SI unit of value and interval.
    pub unit: &'a str,
    /// Absent where the recordings do not determine it.
    pub value: Option<f64>,
    /// 95 % confidence interval, lower and upper end.
    pub ci95: Option<[f64; 2]>,
}

/// An effect that a fit found.
#[derive(Debug, Clone)]
pub struct FittedEffect<'a> {
    /// The joints that it is named by.
    pub who: String,
    /// Of a coupling: the joints that are moved, and the motors that move them.
    pub moved: String,
    /// Of a coupling: the motors that move them.
    pub by: Vec<String>,
    /// What was recorded, by which the finding was made.
    pub signal: Signal,
    /// Its estimated parameters.
    pub parameters: Vec<Estimated<'a>>,
}

impl FittedEffect<'_> {
    fn of(&self, name: &str) -> Option<&Estimated<'_>> {
        self.parameters.iter().find(|p| p.name == name)
    }

    /// The value of a parameter.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.of(name)?.value
    }

    /// Its values at all joints that it is of.
    pub fn values(&self, name: &str) -> Vec<f64> {
        let own = self.parameters.iter().filter(|p| p.name == name);
        own.filter_map(|p| p.value).collect()
    }

    /// Whether a parameter has a value that its interval tells from zero.
    pub fn is_told_from_zero(&self, name: &str) -> bool {
        let holds_zero =
            |p: &Estimated<'_>| p.ci95.is_some_and(|[low, high]| low <= 0.0 && high >= 0.0);
        let parameter = self.of(name).filter(|p| p.value.is_some());
        parameter.is_some_and(|p| !holds_zero(p))
    }

    /// `12.3 N·m (95 %: 11.9 to 12.7)`.
    pub fn quantity(&self, name: &str) -> Option<String> {
        self.scaled(name, self.of(name)?.unit, |x| x)
    }

    /// The same in another unit.
    pub fn scaled(&self, name: &str, unit: &str, of: impl Fn(f64) -> f64) -> Option<String> {
        let parameter = self.of(name)?;
        let value = of(parameter.value?);
        // A factor stands without the unit of numbers.
        let unit = if unit == "1" { "" } else { unit };
        let size = format!("{} {unit}", short(value));
        Some(match parameter.ci95 {
            Some(ends) => {
                let [one, other] = ends.map(of);
                let (low, high) = (one.min(other), one.max(other));
                format!(
                    "{} (95 %: {} to {})",
                    size.trim_end(),
                    short(low),
                    short(high)
                )
            }
            None => size.trim_end().to_string(),
        })
    }

    /// `who TEXT SIZE; LACKING`, or without a size `who: LACKING`.
    pub fn with(&self, text: &str, size: &str, lacking: &str) -> String {
        let who = &self.who;
        match self.quantity(size) {
            Some(size) => format!("{who} {text} {size}; {lacking}"),
            None => format!("{who}: {lacking}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An interval that reaches beyond a lossless gearbox reaches no negative loss.
    #[test]
    fn a_loss_is_never_negative() {
        let efficiency = Estimated {
            name: "R",
            unit: "",
            value: Some(0.99),
            ci95: Some([0.97, 1.01]),
        };
        let found = FittedEffect {
            who: "a3".into(),
            moved: String::new(),
            by: Vec::new(),
            signal: Signal::Current,
            parameters: vec![efficiency],
        };
        let loss = found.scaled("R", "%", |r| 100.0 * (1.0 - r).max(0.0));
        assert_eq!(loss.unwrap(), "1.00 % (95 %: 0 to 3.00)");
    }
}
