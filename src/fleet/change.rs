//! What changed: each parameter of each robot against its own history, and against the robots of its type.
//!
//! Per parameter of a type three passes over its robots: what nights differ by (ω), what robots differ by (μ, τ), and the
//! tests. ω comes from differences between successive nights, of which a change spoils one in a robot's history.

use crate::fleet::error::FleetError;
use crate::fleet::history::{BetweenNights, Night};
use crate::fleet::kind;
use crate::fleet::scratch::{Group, Leaning, RobotTest, Scratch};
use crate::outcome::fleet::{ParameterFigures, Reason, Shown};
use crate::stats::change_point::{
    Mean, Observation, is_rather_a_line, largest_step, mean, p_value,
};
use crate::stats::distribution::Distribution;
use crate::stats::random_effects::{Pooled, Population, Square, excess_variance};
use crate::stats::robust::median;

/// A parameter of a type with what its robots have in common.
#[derive(Debug, Clone)]
pub struct Common {
    pub group: Group,
    pub nights: BetweenNights,
    pub population: Option<Population>,
    /// Median standard deviation of a fit.
    pub of_a_fit: f64,
}

/// Degrees of freedom that the median of the squares of successive differences gives to each: 0.37 for the median, two
/// thirds because neighbours share a night.
const FREEDOM_OF_DIFFERENCE: f64 = 0.25;

/// Differences, or deviations, that a median is taken of at most: it is then known to half a per cent.
const MOST: usize = 20_000;

/// A sample of a series of unknown length, evenly spread: when it is full, every other value goes.
struct Thinned<T> {
    values: Vec<T>,
    every: usize,
    seen: usize,
}

impl<T> Thinned<T> {
    fn new() -> Self {
        Self {
            values: Vec::new(),
            every: 1,
            seen: 0,
        }
    }

    fn push(&mut self, value: T) {
        if self.seen.is_multiple_of(self.every) {
            if self.values.len() == MOST {
                let mut keep = false;
                self.values.retain(|_| {
                    keep = !keep;
                    keep
                });
                self.every *= 2;
            }
            if self.seen.is_multiple_of(self.every) {
                self.values.push(value);
            }
        }
        self.seen += 1;
    }
}

/// What the robots of a group have in common.
pub fn common(scratch: &Scratch, group: Group) -> Result<Common, FleetError> {
    let mut squares = Thinned::new();
    let mut deviations = Thinned::new();
    scratch.each_robot(&group, |_, nights| {
        for pair in nights.windows(2) {
            squares.push(Square {
                square: (pair[1].value - pair[0].value).powi(2),
                variance: pair[0].noise.powi(2) + pair[1].noise.powi(2),
                times: 2.0,
            });
        }
        nights.iter().for_each(|night| deviations.push(night.noise));
        Ok(())
    })?;
    let nights = BetweenNights {
        variance: excess_variance(&squares.values),
        freedom: (FREEDOM_OF_DIFFERENCE * squares.seen as f64).max(1.0),
    };
    let mut means: Vec<Mean> = Vec::new();
    scratch.each_robot(&group, |_, own| {
        means.push(mean(&nights.observations(own)));
        Ok(())
    })?;
    Ok(Common {
        group,
        nights,
        population: Population::of(&means),
        of_a_fit: median(&deviations.values).unwrap_or(f64::NAN),
    })
}

/// Tests every robot of a group and keeps the tests.
pub fn test(scratch: &Scratch, common: &Common) -> Result<(), FleetError> {
    let mut tests = Vec::new();
    scratch.each_robot(&common.group, |robot, nights| {
        let observations = common.nights.observations(nights);
        let shown = [
            common.against_history(nights, &observations),
            common.against_type(&observations),
        ];
        let shown = shown
            .into_iter()
            .flatten()
            .filter(|shown| shown.p_value.is_finite());
        tests.extend(shown.map(|shown| RobotTest {
            robot: robot.to_string(),
            shown,
        }));
        if tests.len() > MOST {
            scratch.add_tests(&common.group, &tests)?;
            tests.clear();
        }
        Ok(())
    })?;
    scratch.add_tests(&common.group, &tests)
}

impl Common {
    pub fn figures(&self) -> ParameterFigures {
        ParameterFigures {
            name: self.group.parameter.clone(),
            unit: self.group.unit.clone(),
            mean: self.population.map(|p| p.mean.value),
            between_robots: self.population.map(|p| p.spread),
            between_nights: self.nights.variance.sqrt(),
            of_a_fit: self.of_a_fit,
        }
    }

    /// The largest step of a robot's history.
    fn against_history(&self, nights: &[Night], observations: &[Observation]) -> Option<Shown> {
        let step = largest_step(observations)?;
        let reason = match is_rather_a_line(observations, &step) {
            true => Reason::Drifts,
            false => Reason::Changed,
        };
        let z = as_if_normal(step.z, self.nights.freedom);
        Some(Shown {
            since: Some(nights[step.first].time),
            p_value: p_value(z, observations),
            ..self.shown(reason, step.before, step.after, step.z)
        })
    }

    /// A robot's mean among those of its type.
    fn against_type(&self, observations: &[Observation]) -> Option<Shown> {
        let population = self.population?;
        let own = mean(observations);
        let variance = own.variance + population.spread.powi(2) + population.mean.variance;
        let z = (own.value - population.mean.value) / variance.sqrt();
        let student = Distribution::StudentT {
            freedom: population.freedom(),
        };
        let among = Mean {
            value: population.mean.value,
            variance: population.spread.powi(2),
        };
        Some(Shown {
            p_value: (2.0 * student.upper_tail(z.abs())).min(1.0),
            ..self.shown(Reason::UnlikeItsType, among, own, z)
        })
    }

    fn shown(&self, reason: Reason, before: Mean, after: Mean, z: f64) -> Shown {
        Shown {
            parameter: self.group.parameter.clone(),
            unit: self.group.unit.clone(),
            reason,
            kind: kind::of(&self.group.parameter, after.value - before.value).words,
            since: None,
            before: before.value,
            before_std: before.variance.sqrt(),
            after: after.value,
            after_std: after.variance.sqrt(),
            z,
            p_value: f64::NAN,
            probability: f64::NAN,
        }
    }
}

/// The normal deviate with the tail of Student's t: a deviation over an estimated scale counts for less.
fn as_if_normal(t: f64, freedom: f64) -> f64 {
    /// From here on both agree to a per cent of a p-value of 1e-6.
    const MANY: f64 = 20_000.0;
    if freedom > MANY {
        return t;
    }
    let tail = Distribution::StudentT { freedom }.upper_tail(t.abs());
    Distribution::Normal.upper_quantile(tail.max(f64::MIN_POSITIVE))
}

/// Keeps what every value of a group leans on: a robot's own nights so far since its last listed change, and its type as
/// long as nothing of it is listed.
pub fn pool(scratch: &Scratch, common: &Common) -> Result<(), FleetError> {
    let mut leaning: Vec<Leaning> = Vec::new();
    scratch.each_robot(&common.group, |robot, nights| {
        let flagged = scratch.flagged(&common.group, robot)?;
        let observations = common.nights.observations(nights);
        let is_flagged = |night: &Night| flagged.is_some_and(|since| night.time >= since);
        let first_flagged = nights.iter().position(is_flagged).unwrap_or(nights.len());
        for (k, night) in nights.iter().enumerate() {
            let first = if k < first_flagged { 0 } else { first_flagged };
            let own = mean(&observations[first..=k]);
            let population = common.population.filter(|_| k < first_flagged);
            let mut pooled = match population {
                Some(population) => population.pool(own),
                None => Pooled {
                    share: 0.0,
                    mean: own,
                },
            };
            // What is common to all nights of a robot is not averaged away.
            pooled.mean.variance += (night.std.powi(2) - night.noise.powi(2)).max(0.0);
            leaning.push(Leaning {
                night: *night,
                pooled,
            });
        }
        if leaning.len() > MOST {
            scratch.add_pooled(&leaning)?;
            leaning.clear();
        }
        Ok(())
    })?;
    scratch.add_pooled(&leaning)
}
