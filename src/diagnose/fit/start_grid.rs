//! Grid of initial values of the nonlinear parameters of a hypothesis.

use crate::chain::effect::{Effect, Linearity, Search};
use crate::chain::model::Model;
use crate::chain::parameter::Role;
use crate::estimate::search_range::{Bounded, MotionRange};

/// A linear parameter at this share of its typical value lets the derivatives with respect to the nonlinear
/// ones behind it be seen, and changes nothing else.
const GLIMPSE: f64 = 1e-3;

/// Where parameters of a hypothesis may lie, joint by joint alike.
#[derive(Debug, Clone)]
pub struct Grid {
    kinds: Vec<Kind>,
    /// Of each own parameter, the kind.
    of: Vec<usize>,
}

/// The parameters of one name.
#[derive(Debug, Clone)]
struct Kind {
    parameter: Option<usize>,
    linear: Option<f64>,
    values: Vec<f64>,
    scanned: bool,
    rising: bool,
    /// A time: the times of a law follow one another.
    time: bool,
    /// A scale of speed, or what has no values to try.
    begun_anew: bool,
}

impl Grid {
    /// The grid of the `own` parameters of an effect, with the motion of its joint.
    pub fn new(model: &Model, own: &[usize], effect: &Effect, motion: &MotionRange) -> Self {
        let mut kinds: Vec<Kind> = Vec::new();
        let mut of = Vec::new();
        for &p in own {
            let parameter = &model.parameters()[p];
            let number = match parameter.role {
                Role::Effect { parameter, .. } => Some(parameter),
                _ => None,
            };
            let known = kinds
                .iter()
                .position(|k| number.is_some() && k.parameter == number);
            of.push(known.unwrap_or(kinds.len()));
            if known.is_some() {
                continue;
            }
            let search = number
                .and_then(|k| effect.parameters.get(k))
                .map_or(Search::Typical, |info| info.search);
            let linear = parameter.linearity == Linearity::Linear;
            kinds.push(Kind {
                parameter: number,
                linear: linear.then_some(GLIMPSE * parameter.scale),
                values: match linear {
                    true => vec![0.0],
                    false => motion.grid(search, Bounded::of(parameter)),
                },
                scanned: search == Search::Cycles,
                rising: matches!(search, Search::Rising(_)),
                time: matches!(search, Search::Duration(_) | Search::Instant(_)),
                begun_anew: matches!(search, Search::Speed(_) | Search::Typical),
            });
        }
        Self { kinds, of }
    }

    /// Whether points come in an order in which each lies further off than the one before.
    pub fn is_rising(&self) -> bool {
        self.kinds.len() == 1 && self.kinds[0].rising
    }

    /// The own parameter with the most values to try, where several that are not scanned have more than one.
    pub fn main_shape(&self) -> Option<usize> {
        let shapes = |kind: &&Kind| !kind.scanned && kind.values.len() > 1;
        let most = self.kinds.iter().filter(shapes).map(|k| k.values.len());
        let main = |own: &usize| {
            let kind = &self.kinds[*own];
            shapes(&kind) && Some(kind.values.len()) == most.clone().max()
        };
        let several = most.clone().count() > 1;
        self.of.iter().position(main).filter(|_| several)
    }

    /// Scales of speed at each of their values, with what has no values to try where it is declared to start; what
    /// else there is stays as a search has it. Own parameters by their number.
    pub fn anew(&self) -> Vec<Vec<(usize, f64)>> {
        let reset = |kind: &&Kind| kind.begun_anew && kind.linear.is_none();
        let counts = self.kinds.iter().filter(reset).map(|k| k.values.len());
        let at = |choice: usize| {
            let own = self.of.iter().enumerate().filter_map(move |(p, &kind)| {
                let kind = Some(&self.kinds[kind]).filter(reset)?;
                Some((p, kind.values[choice.min(kind.values.len() - 1)]))
            });
            own.collect()
        };
        (0..counts.max().unwrap_or(0)).map(at).collect()
    }

    /// Whether an own parameter, by its number, is a scale that several values are tried of.
    pub fn is_scale(&self, own: usize) -> bool {
        self.kinds[self.of[own]].values.len() > 1
    }

    /// Points of what is scanned alone, with everything else at its first value; empty where nothing is.
    pub fn scan(&self) -> Vec<Vec<f64>> {
        if self.kinds.iter().all(|kind| !kind.scanned) {
            return Vec::new();
        }
        let choices = self
            .kinds
            .iter()
            .map(|kind| match (kind.scanned, kind.linear) {
                (true, _) => kind.values.clone(),
                (false, Some(glimpse)) => vec![glimpse],
                (false, None) => vec![kind.values[0]],
            });
        self.points(choices.collect())
    }

    /// All points; what was scanned stays where `scanned` has it.
    pub fn all(&self, scanned: Option<&[f64]>) -> Vec<Vec<f64>> {
        let choices = self.kinds.iter().enumerate().map(|(k, kind)| {
            let at = self.of.iter().position(|of| *of == k);
            match (scanned, kind.scanned, at) {
                (Some(point), true, Some(at)) => vec![point[at]],
                _ => kind.values.clone(),
            }
        });
        self.points(choices.collect())
    }

    /// Every combination of the choices in which times follow one another, one value per own parameter.
    fn points(&self, choices: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        let mut points = vec![Vec::new()];
        for values in &choices {
            let longer = |point: Vec<f64>| {
                values.iter().map(move |x| {
                    let mut longer = point.clone();
                    longer.push(*x);
                    longer
                })
            };
            points = points.into_iter().flat_map(longer).collect();
        }
        let times: Vec<usize> = (0..choices.len()).filter(|&k| self.kinds[k].time).collect();
        let follow = |point: &Vec<f64>| times.is_sorted_by(|&a, &b| point[a] < point[b]);
        points.retain(follow);
        let spread = |point: Vec<f64>| self.of.iter().map(|&kind| point[kind]).collect();
        points.into_iter().map(spread).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_begins_ends_later() {
        let kind = |values: &[f64], time: bool| Kind {
            parameter: None,
            linear: None,
            values: values.to_vec(),
            scanned: false,
            rising: false,
            time,
            begun_anew: false,
        };
        let grid = Grid {
            kinds: vec![
                kind(&[5.0], false),
                kind(&[1.0, 2.0], true),
                kind(&[1.0, 2.0, 3.0], true),
            ],
            of: vec![0, 1, 2],
        };
        let points = [[5.0, 1.0, 2.0], [5.0, 1.0, 3.0], [5.0, 2.0, 3.0]];
        assert_eq!(grid.all(None), points.map(Vec::from));
    }
}
