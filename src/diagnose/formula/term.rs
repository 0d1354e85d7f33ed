//! Terms of formulas: products of factors with one size.

use crate::diagnose::formula::factor::{Factor, Shape};
use crate::diagnose::formula::rows::FittedRows;
use crate::diagnose::residuals::quantity::Quantity;

/// Factors that a term may have.
pub const MOST_FACTORS: usize = 3;

/// A product of factors.
#[derive(Debug, Clone, PartialEq)]
pub struct Term {
    pub factors: Vec<Factor>,
}

impl Term {
    pub fn of(factors: impl Into<Vec<Factor>>) -> Self {
        Self {
            factors: factors.into(),
        }
    }

    /// Its series over the fitted rows, in what the signal shows of a torque: one for each size that is to be found, two where
    /// a factor is a sum.
    pub fn columns(&self, rows: &FittedRows) -> Vec<Vec<f64>> {
        let mut columns = vec![rows.by_torque.clone()];
        for factor in &self.factors {
            factor.multiply(rows, &mut columns);
        }
        columns
    }

    /// The factor that is a sum, if there is one.
    pub fn sum(&self) -> Option<&Factor> {
        self.factors.iter().find(|factor| factor.shape.is_sum())
    }

    /// Sizes, phases and parameters of factors.
    pub fn parameters(&self) -> usize {
        let own = |f: &Factor| usize::from(f.shape.has_inner()) + usize::from(f.has_centre());
        let inner: usize = self.factors.iter().map(own).sum();
        1 + usize::from(self.sum().is_some()) + inner
    }

    /// The same factors, whatever their parameters.
    pub fn is_like(&self, other: &Self) -> bool {
        let has = |factor: &Factor| other.factors.iter().any(|f| f.is_like(factor));
        self.factors.len() == other.factors.len() && self.factors.iter().all(has)
    }

    /// Whether it turns over with the speed of its joint, and knows the speed of no other.
    pub fn is_friction(&self) -> bool {
        let of_speed = |f: &&Factor| f.quantity == Quantity::Velocity && f.shape.is_odd();
        let odd = self.factors.iter().filter(of_speed).count();
        let knows_others = |f: &Factor| matches!(f.quantity, Quantity::OtherVelocity(_));
        odd % 2 == 1 && !self.factors.iter().any(knows_others)
    }

    /// Whether it has no two factors of which a product is another factor, at most one that repeats and one that is a sum, and none alone that is an
    /// offset and another.
    pub fn is_sound(&self) -> bool {
        let number = |of: fn(Shape) -> bool| self.factors.iter().filter(|f| of(f.shape)).count();
        let alike = |k: usize| {
            let of_same = |other: &Factor| self.factors[k].quantity == other.quantity;
            let both = |other: &&Factor| of_same(other) && !is_decay(other);
            !is_decay(&self.factors[k]) && self.factors[..k].iter().any(|other| both(&other))
        };
        let decays = self.factors.iter().filter(|f| is_decay(f)).count();
        let count = self.factors.len();
        let is_shifted_alone = count == 1 && self.factors[0].shape == Shape::Shifted;
        (1..=MOST_FACTORS).contains(&count)
            && !is_shifted_alone
            && number(Shape::is_periodic) <= 1
            && number(Shape::is_sum) <= 1
            && decays <= 1
            && !(0..count).any(alike)
    }
}

/// A decay stands beside the direction that it belongs to.
fn is_decay(factor: &Factor) -> bool {
    factor.shape == Shape::Decay
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::residuals::quantity::Quantity::{OtherVelocity, Position, Velocity};

    fn term(factors: &[(Quantity, Shape)]) -> Term {
        let factors = factors.iter().map(|&(q, shape)| Factor::plain(q, shape));
        Term::of(factors.collect::<Vec<Factor>>())
    }

    #[test]
    fn friction_turns_over_with_its_own_speed_alone() {
        let direction = (Velocity, Shape::Direction);
        assert!(term(&[direction]).is_friction());
        assert!(term(&[direction, (Velocity, Shape::Decay)]).is_friction());
        assert!(term(&[direction, (Position, Shape::Magnitude)]).is_friction());
        assert!(!term(&[direction, (Velocity, Shape::Power(1))]).is_friction());
        assert!(!term(&[(Position, Shape::Power(1))]).is_friction());
        assert!(term(&[(Velocity, Shape::DeadZone)]).is_friction());
        let other = (OtherVelocity(1), Shape::Direction);
        assert!(!term(&[other]).is_friction() && !term(&[direction, other]).is_friction());
    }

    #[test]
    fn sound_terms_have_no_factor_twice() {
        let (direction, decay) = ((Velocity, Shape::Direction), (Velocity, Shape::Decay));
        assert!(term(&[direction, decay]).is_sound());
        assert!(!term(&[direction, (Velocity, Shape::Power(2))]).is_sound());
        assert!(!term(&[decay, decay]).is_sound());
        let waves = [(Position, Shape::Wave), (OtherVelocity(1), Shape::Sine)];
        assert!(term(&waves[..1]).is_sound() && !term(&waves).is_sound());
        let four = [
            (Position, Shape::Power(1)),
            direction,
            decay,
            (Quantity::Acceleration, Shape::Power(1)),
        ];
        assert!(term(&four[..3]).is_sound() && !term(&four).is_sound());
        assert!(!term(&[]).is_sound());
        let sums = [(Position, Shape::Wave), (OtherVelocity(1), Shape::Slopes)];
        assert!(term(&sums[1..]).is_sound() && !term(&sums).is_sound());
        let shifted = (Position, Shape::Shifted);
        assert!(term(&[shifted, direction]).is_sound() && !term(&[shifted]).is_sound());
    }
}
