//! Units of the parameters of formulas: sizes make torques of their terms.

use crate::diagnose::formula::factor::{Factor, Shape};
use crate::diagnose::formula::term::Term;
use crate::diagnose::residuals::quantity::Quantity;
use crate::robot::tree::JointKind;

/// Units of the parameters of a joint's terms.
pub struct Units<'a> {
    pub kinds: &'a [JointKind],
    pub joint: usize,
}

/// Symbols with their powers.
type Powers = Vec<(&'static str, i8)>;

impl Units<'_> {
    fn length(&self, joint: usize) -> &'static str {
        match self.kinds[joint] {
            JointKind::Revolute => "rad",
            JointKind::Prismatic => "m",
        }
    }

    fn torque(&self) -> Powers {
        match self.kinds[self.joint] {
            JointKind::Revolute => vec![("N", 1), ("m", 1)],
            JointKind::Prismatic => vec![("N", 1)],
        }
    }

    fn of(&self, quantity: Quantity) -> Powers {
        let joint = quantity.other().unwrap_or(self.joint);
        match quantity {
            Quantity::Position | Quantity::OtherPosition(_) => vec![(self.length(joint), 1)],
            Quantity::Velocity | Quantity::OtherVelocity(_) => {
                vec![(self.length(joint), 1), ("s", -1)]
            }
            Quantity::Acceleration => vec![(self.length(joint), 1), ("s", -2)],
            Quantity::Load => self.torque(),
        }
    }

    /// Of the size of a term.
    pub fn of_size(&self, term: &Term) -> String {
        let mut powers = self.torque();
        for factor in &term.factors {
            for (symbol, power) in self.of(factor.quantity) {
                times(&mut powers, symbol, -power * factor.shape.power());
            }
        }
        unit(&powers)
    }

    /// Of the place about which a factor is one.
    pub fn of_centre(&self, factor: &Factor) -> String {
        unit(&self.of(factor.quantity))
    }

    /// Of a factor's own parameter.
    pub fn of_inner(&self, factor: &Factor) -> String {
        let own = self.of(factor.quantity);
        let is_rate = factor.shape.is_periodic() || factor.shape == Shape::Exponential;
        match is_rate {
            true if own == [("rad", 1)] => "1".to_string(),
            true => unit(&own.iter().map(|(s, p)| (*s, -p)).collect::<Powers>()),
            false => unit(&own),
        }
    }
}

fn times(powers: &mut Powers, symbol: &'static str, power: i8) {
    match powers.iter_mut().find(|(own, _)| *own == symbol) {
        Some((_, own)) => *own += power,
        None => powers.push((symbol, power)),
    }
}

/// `N·m·s/rad^2`.
fn unit(powers: &Powers) -> String {
    let side = |sign: i8| {
        let of_side = powers.iter().filter(move |(_, p)| p.signum() == sign);
        let symbols = of_side.map(|(symbol, power)| match power.abs() {
            1 => (*symbol).to_string(),
            power => format!("{symbol}^{power}"),
        });
        symbols.collect::<Vec<String>>()
    };
    let (above, below) = (side(1), side(-1));
    let above = match above.is_empty() {
        true => "1".to_string(),
        false => above.join("·"),
    };
    match &below[..] {
        [] => above,
        [one] => format!("{above}/{one}"),
        several => format!("{above}/({})", several.join("·")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_sizes_make_torques() {
        let kinds = [JointKind::Revolute, JointKind::Prismatic];
        let of = |joint: usize, factors: &[(Quantity, Shape)]| {
            let units = Units {
                kinds: &kinds,
                joint,
            };
            let factors: Vec<Factor> = factors.iter().map(|(q, s)| Factor::plain(*q, *s)).collect();
            units.of_size(&Term::of(factors))
        };
        let cube = (Quantity::Position, Shape::Power(3));
        let speed = (Quantity::Velocity, Shape::Power(1));
        let load = (Quantity::Load, Shape::Magnitude);
        let neighbour = (Quantity::OtherPosition(1), Shape::Power(1));
        for (joint, factors, unit) in [
            (0, &[cube][..], "N·m/rad^3"),
            (1, &[cube], "N/m^3"),
            (0, &[speed], "N·m·s/rad"),
            (0, &[speed, load], "s/rad"),
            (1, &[(Quantity::Load, Shape::Power(2))], "1/N"),
            (0, &[cube, speed], "N·m·s/rad^4"),
            (0, &[speed, neighbour], "N·s/rad"),
            (0, &[(Quantity::Velocity, Shape::Direction)], "N·m"),
        ] {
            assert_eq!(of(joint, factors), unit);
        }
    }
}
