//! The terms that a joint may have, and what each is charged for having been one of many.

use crate::diagnose::formula::factor::{Factor, Shape};
use crate::diagnose::formula::rows::{Extent, FittedRows};
use crate::diagnose::formula::term::Term;
use crate::diagnose::residuals::quantity::Quantity;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// Cycles over the range of positions between one order of a wave and the next: half of what tells two apart.
const CYCLES: f64 = 0.5;

/// Orders of the joint's own position, and of the positions of others, at most.
const OWN_ORDERS: usize = 240;
const OTHER_ORDERS: usize = 24;

/// Shares of the range of a position at which it may touch something.
const TOUCHES: [f64; 7] = [0.15, 0.3, 0.4, 0.5, 0.6, 0.7, 0.85];

/// Shares of the greatest speed over which something may decay.
const DECAYS: [f64; 4] = [0.03, 0.08, 0.2, 0.5];

/// Growth over the range of a variable.
const RATES: [f64; 6] = [-4.0, -1.5, -0.5, 0.5, 1.5, 4.0];

/// The fastest, by powers of e.
const FASTEST: f64 = 8.0;

/// Shares of the range of a position about which something may be one, and over which it changes.
const MIDDLES: [f64; 3] = [0.3, 0.5, 0.7];
const WIDTHS: [f64; 3] = [0.05, 0.15, 0.4];

/// Orders of the waves of speeds and of loads at most: eight cycles over the range.
const SPEED_ORDERS: usize = 16;

/// Shares of the range of a variable about its middle, or about none, in which nothing is.
const ZONES: [f64; 3] = [0.06, 0.12, 0.25];
const WIDEST_ZONE: f64 = 0.45;

/// Share of a limit within which a parameter is at it: golden section comes as near as some thousandths.
const NEAR: f64 = 1e-2;

/// Kinds of variables, of which a class of terms has some.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Kind {
    Position,
    Wave,
    Speed,
    SpeedWave,
    Acceleration,
    Load,
    LoadWave,
    Other,
    OtherWave,
    OtherSpeedWave,
}

/// The kinds of the factors of a term, in order.
type Class = Vec<Kind>;

/// All terms of a joint.
pub struct Grammar {
    pub terms: Vec<Term>,
    /// Factors of terms, each once.
    pub factors: Vec<Factor>,
    sizes: HashMap<Class, usize>,
    extents: HashMap<Quantity, Extent>,
}

impl Grammar {
    /// Of the motion of a joint over the fitted rows: of all its variables, or of few that a smooth correction has found, which may
    /// be of more shapes.
    pub fn of(rows: &FittedRows, few: Option<&[Quantity]>) -> Self {
        let terms = match few {
            Some(few) => terms_of(few, rows),
            None => Blocks::of(rows).terms(),
        };
        let mut sizes = HashMap::new();
        let mut factors: Vec<Factor> = Vec::new();
        for term in &terms {
            *sizes.entry(class(term)).or_default() += 1;
            for factor in &term.factors {
                if !factors.contains(factor) {
                    factors.push(*factor);
                }
            }
        }
        let quantities: Vec<Quantity> = factors.iter().map(|f| f.quantity).collect();
        let extents: HashMap<Quantity, Extent> = quantities
            .iter()
            .map(|&quantity| (quantity, rows.extent(quantity)))
            .collect();
        Self {
            extents,
            terms,
            factors,
            sizes,
        }
    }

    /// Twice the logarithm of the number of terms that a term was chosen from: those of its class, for each class.
    pub fn charge(&self, term: &Term) -> f64 {
        let largest = self.sizes.values().copied().max().unwrap_or(1);
        let own = self.sizes.get(&class(term)).copied().unwrap_or(largest);
        2.0 * ((own * self.sizes.len().max(1)) as f64).ln()
    }

    /// Where the parameter of a factor may lie between its neighbours in the search.
    pub fn around(&self, factor: &Factor) -> [f64; 2] {
        let range = self.extent(factor.quantity).range();
        let a = factor.inner;
        let [low, high] = match factor.shape {
            Shape::Decay | Shape::DeadZone => [0.5 * a, 2.0 * a],
            shape if shape.has_width() => [0.5 * a, 2.0 * a],
            Shape::Exponential => [a - 1.0 / range, a + 1.0 / range],
            Shape::Above(_) | Shape::Below(_) | Shape::Slopes => {
                [a - 0.15 * range, a + 0.15 * range]
            }
            Shape::Shifted => [a - 0.5 * range, a + 0.5 * range],
            _ => {
                let step = 0.5 * CYCLES * TAU / range;
                [(a - step).max(step), a + step]
            }
        };
        let [least, most] = self.limits(factor);
        [low.max(least), high.min(most)]
    }

    /// What the parameter of a factor may be: shapes over narrower ranges have too few rows, and over wider ones are powers; what is
    /// none far from where the joint is is a constant there.
    pub fn limits(&self, factor: &Factor) -> [f64; 2] {
        let extent = self.extent(factor.quantity);
        let range = extent.range();
        match factor.shape {
            Shape::Decay => [1e-3 * extent.largest(), extent.largest()],
            shape if shape.has_width() => [0.02 * range, 2.0 * range],
            Shape::Exponential => [-FASTEST / range, FASTEST / range],
            Shape::Above(_) | Shape::Below(_) | Shape::Slopes => self.inside(factor.quantity),
            Shape::DeadZone => [0.02 * range, WIDEST_ZONE * range],
            Shape::Shifted => [extent.least - range, extent.greatest + range],
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// Where the place about which a factor is one may lie between its neighbours in the search.
    pub fn around_centre(&self, factor: &Factor) -> [f64; 2] {
        let inside = self.inside(factor.quantity);
        let step = 0.15 * (inside[1] - inside[0]);
        let [low, high] = [factor.centre - step, factor.centre + step];
        [low.max(inside[0]), high.min(inside[1])]
    }

    /// Whether the parameters of a factor lie within their limits, so that a fit does not end there.
    pub fn is_inside(&self, factor: &Factor) -> bool {
        let is_within = |x: f64, limits: [f64; 2]| {
            limits
                .iter()
                .all(|limit| (x - limit).abs() > NEAR * limit.abs() || limit.is_infinite())
        };
        (!factor.shape.has_inner() || is_within(factor.inner, self.limits(factor)))
            && (!factor.has_centre() || is_within(factor.centre, self.inside(factor.quantity)))
    }

    /// The range of a variable without its outermost twentieths: what is touched beyond them has too few rows.
    pub fn inside(&self, quantity: Quantity) -> [f64; 2] {
        const OUTERMOST: f64 = 0.05;
        let extent = self.extent(quantity);
        let margin = OUTERMOST * extent.range();
        [extent.least + margin, extent.greatest - margin]
    }

    /// Of a variable that some term has; of any other none.
    fn extent(&self, quantity: Quantity) -> Extent {
        let known = self.extents.get(&quantity).copied();
        known.unwrap_or(Extent {
            least: 0.0,
            greatest: 0.0,
        })
    }
}

fn class(term: &Term) -> Class {
    let mut kinds: Class = term.factors.iter().map(kind).collect();
    kinds.sort_unstable();
    kinds
}

fn kind(factor: &Factor) -> Kind {
    match (factor.quantity, factor.shape.is_periodic()) {
        (Quantity::Position, true) => Kind::Wave,
        (Quantity::Position, false) => Kind::Position,
        (Quantity::Velocity, true) => Kind::SpeedWave,
        (Quantity::Velocity, false) => Kind::Speed,
        (Quantity::Acceleration, _) => Kind::Acceleration,
        (Quantity::Load, true) => Kind::LoadWave,
        (Quantity::Load, false) => Kind::Load,
        (Quantity::OtherPosition(_), true) => Kind::OtherWave,
        (Quantity::OtherVelocity(_), true) => Kind::OtherSpeedWave,
        (Quantity::OtherPosition(_) | Quantity::OtherVelocity(_), _) => Kind::Other,
    }
}

/// Factors by the kinds of their variables.
struct Blocks {
    /// Of the position, without waves.
    position: Vec<Factor>,
    powers: Vec<Factor>,
    waves: Vec<Factor>,
    /// Products of factors of the speed.
    speed: Vec<Vec<Factor>>,
    load: Vec<Factor>,
    acceleration: Factor,
    others: Vec<Factor>,
    other_waves: Vec<Factor>,
    speed_waves: Vec<Factor>,
    load_waves: Vec<Factor>,
    other_speed_waves: Vec<Factor>,
}

impl Blocks {
    fn of(rows: &FittedRows) -> Self {
        use Quantity::{Acceleration, Load, OtherPosition, OtherVelocity, Position, Velocity};
        let plain = Factor::plain;
        let powers = |q: Quantity, most: u8| (1..=most).map(move |n| plain(q, Shape::Power(n)));
        let v = |shape: Shape| plain(Velocity, shape);
        let mut speed: Vec<Vec<Factor>> = [
            Shape::Direction,
            Shape::Power(1),
            Shape::Magnitude,
            Shape::Power(2),
            Shape::SignedSquare,
            Shape::Power(3),
        ]
        .map(|shape| vec![v(shape)])
        .to_vec();
        let fastest = rows.extent(Velocity).largest();
        for share in DECAYS {
            let decay = v(Shape::Decay).with_inner(share * fastest);
            speed.push(vec![decay]);
            speed.push(vec![v(Shape::Direction), decay]);
        }
        let others = rows.others().flat_map(|k| {
            let of_speed = [
                Shape::Power(1),
                Shape::Magnitude,
                Shape::Power(2),
                Shape::SignedSquare,
            ];
            powers(OtherPosition(k), 2)
                .chain(touches(OtherPosition(k), rows))
                .chain(of_speed.map(|shape| plain(OtherVelocity(k), shape)))
        });
        let other_waves = rows.others().flat_map(|k| waves(OtherPosition(k), rows));
        let other_speed_waves = rows.others().flat_map(|k| waves(OtherVelocity(k), rows));
        let of_load = [
            Shape::Power(1),
            Shape::Magnitude,
            Shape::Power(2),
            Shape::SignedSquare,
        ];
        Self {
            powers: powers(Position, 3).collect(),
            position: powers(Position, 3).chain(touches(Position, rows)).collect(),
            waves: waves(Position, rows),
            speed,
            load: of_load.map(|shape| plain(Load, shape)).to_vec(),
            acceleration: plain(Acceleration, Shape::Power(1)),
            others: others.collect(),
            other_waves: other_waves.collect(),
            speed_waves: waves(Velocity, rows),
            load_waves: waves(Load, rows),
            other_speed_waves: other_speed_waves.collect(),
        }
    }

    /// All products that a formula may have.
    fn terms(&self) -> Vec<Term> {
        let (position, powers, load) = (
            each(&self.position),
            each(&self.powers),
            each(&self.load[..2]),
        );
        let (others, waves) = (each(&self.others), each(&self.waves));
        let other_waves = each(&self.other_waves);
        let [speed_waves, load_waves, other_speed_waves] =
            [&self.speed_waves, &self.load_waves, &self.other_speed_waves].map(|waves| each(waves));
        let plain_others = without_parameters(&others);
        let acceleration = vec![vec![self.acceleration]];
        // Direction, speed and its size go with waves and with what others do.
        let simple = self.speed[..3].to_vec();
        let mut all: Vec<Vec<Factor>> = [
            &position,
            &self.speed,
            &others,
            &waves,
            &other_waves,
            &speed_waves,
            &load_waves,
            &other_speed_waves,
        ]
        .into_iter()
        .flatten()
        .cloned()
        .collect();
        all.extend(each(&self.load));
        all.extend(acceleration.clone());
        for (left, right) in [
            (&position, &self.speed),
            (&position, &load),
            (&self.speed, &load),
            (&powers, &acceleration),
            (&waves, &simple),
            (&waves, &load),
            (&others, &simple),
            (&others, &load),
            (&others, &powers),
            (&others, &acceleration),
            (&other_waves, &simple[..2].to_vec()),
            (&other_waves, &load[..1].to_vec()),
            (&speed_waves, &powers),
            (&speed_waves, &load),
            (&speed_waves, &plain_others),
            (&load_waves, &powers),
            (&load_waves, &simple),
            (&load_waves, &plain_others),
            (&other_speed_waves, &powers),
            (&other_speed_waves, &simple),
            (&other_speed_waves, &load),
        ] {
            all.extend(products(left, right));
        }
        all.extend(products(&products(&powers, &simple), &load));
        all.extend(products(&products(&waves, &simple[..1]), &load[1..]));
        all.extend(products(&products(&others, &simple), &load[1..]));
        let terms = all.into_iter().map(Term::of);
        terms.filter(Term::is_sound).collect()
    }
}

/// Each alone.
fn each(factors: &[Factor]) -> Vec<Vec<Factor>> {
    factors.iter().map(|factor| vec![*factor]).collect()
}

/// Products of factors without a parameter of their own.
fn without_parameters(all: &[Vec<Factor>]) -> Vec<Vec<Factor>> {
    let is_plain = |product: &&Vec<Factor>| product.iter().all(|f| !f.shape.has_inner());
    all.iter().filter(is_plain).cloned().collect()
}

fn products(left: &[Vec<Factor>], right: &[Vec<Factor>]) -> Vec<Vec<Factor>> {
    let of = |a: &Vec<Factor>| {
        let a = a.clone();
        right.iter().map(move |b| [&a[..], &b[..]].concat())
    };
    left.iter().flat_map(of).collect()
}

/// Terms of few variables: every shape of each, and every product of two of them.
fn terms_of(few: &[Quantity], rows: &FittedRows) -> Vec<Term> {
    let shapes: Vec<Vec<Vec<Factor>>> = few.iter().map(|&q| each(&shapes(q, rows))).collect();
    let mut all: Vec<Vec<Factor>> = Vec::new();
    for (k, own) in shapes.iter().enumerate() {
        let waves = each(&waves(few[k], rows));
        all.extend(own.iter().chain(&waves).cloned());
        for other in &shapes[k + 1..] {
            all.extend(products(own, other));
        }
        for (l, other) in shapes.iter().enumerate() {
            if l != k {
                all.extend(products(&waves, &without_parameters(other)));
            }
        }
    }
    let terms = all.into_iter().map(Term::of);
    terms.filter(Term::is_sound).collect()
}

/// Functions of one variable that do not repeat.
fn shapes(quantity: Quantity, rows: &FittedRows) -> Vec<Factor> {
    let plain = |shape: Shape| Factor::plain(quantity, shape);
    let extent = rows.extent(quantity);
    let mut all: Vec<Factor> = (1..=3).map(|n| plain(Shape::Power(n))).collect();
    if quantity == Quantity::Acceleration {
        all.truncate(1);
        return all;
    }
    all.extend([Shape::Magnitude, Shape::SignedSquare].map(plain));
    let rate = 1.0 / extent.range();
    all.extend(RATES.map(|of| plain(Shape::Exponential).with_inner(of * rate)));
    let centres = match quantity.is_position() {
        true => MIDDLES
            .map(|share| extent.least + share * extent.range())
            .to_vec(),
        false => vec![0.0],
    };
    let of_widths = |shapes: [Shape; 2], centre: f64| {
        WIDTHS.into_iter().flat_map(move |width| {
            let width = width * extent.range();
            shapes.map(|shape| plain(shape).with_inner(width).about(centre))
        })
    };
    for centre in centres {
        all.extend(of_widths([Shape::Saturation, Shape::Bump], centre));
    }
    let middle = match quantity.is_position() {
        true => 0.5 * (extent.least + extent.greatest),
        false => 0.0,
    };
    if quantity.is_position() {
        all.push(plain(Shape::Shifted).with_inner(middle));
    }
    all.extend(touches(quantity, rows));
    all.extend(of_widths([Shape::Resonance, Shape::Breakdown], middle));
    all.extend(ZONES.map(|share| {
        let zone = plain(Shape::DeadZone).with_inner(share * extent.range());
        zone.about(middle)
    }));
    all.extend(
        MIDDLES.map(|share| plain(Shape::Slopes).with_inner(extent.least + share * extent.range())),
    );
    if quantity == Quantity::Velocity {
        all.push(plain(Shape::Direction));
        let fastest = extent.largest();
        all.extend(DECAYS.map(|share| plain(Shape::Decay).with_inner(share * fastest)));
    }
    all
}

/// What acts on one side of a position.
fn touches(quantity: Quantity, rows: &FittedRows) -> Vec<Factor> {
    let extent = rows.extent(quantity);
    let of = |share: f64| {
        let at = extent.least + share * extent.range();
        [
            Shape::Above(1),
            Shape::Below(1),
            Shape::Above(2),
            Shape::Below(2),
        ]
        .map(|shape| Factor::plain(quantity, shape).with_inner(at))
    };
    TOUCHES.into_iter().flat_map(of).collect()
}

/// Orders from one cycle over the range of a variable to what the rows resolve; none of what is constant.
fn waves(quantity: Quantity, rows: &FittedRows) -> Vec<Factor> {
    let most = match quantity {
        Quantity::Position => OWN_ORDERS,
        Quantity::OtherPosition(_) => OTHER_ORDERS,
        Quantity::Acceleration => 0,
        Quantity::Velocity | Quantity::Load | Quantity::OtherVelocity(_) => SPEED_ORDERS,
    };
    let range = rows.extent(quantity).range();
    if range <= 0.0 {
        return Vec::new();
    }
    let step = TAU * CYCLES / range;
    let resolved = match quantity {
        Quantity::Position => ((PI / rows.longest_step) / step) as usize,
        _ => most,
    };
    let count = resolved.min(most);
    let of = |k: usize| Factor::plain(quantity, Shape::Wave).with_inner(k as f64 * step);
    (2..=count).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::formula::factor::Shape;

    /// A term is one of those of its class, and its class one of all; one of no class is charged as the most common are.
    #[test]
    fn a_term_is_charged_for_those_that_it_was_chosen_from() {
        let of = |quantity: Quantity| Term::of(vec![Factor::plain(quantity, Shape::Power(1))]);
        let [position, speed, load] =
            [Quantity::Position, Quantity::Velocity, Quantity::Load].map(of);
        let grammar = Grammar {
            terms: Vec::new(),
            factors: Vec::new(),
            sizes: HashMap::from([(class(&position), 10), (class(&speed), 30)]),
            extents: HashMap::new(),
        };
        assert_eq!(grammar.charge(&position), 2.0 * 20.0_f64.ln());
        assert_eq!(grammar.charge(&speed), 2.0 * 60.0_f64.ln());
        assert_eq!(grammar.charge(&load), 2.0 * 60.0_f64.ln());
    }

    /// Wherever a search begins, what it tries of a factor stays where a fit may have it.
    #[test]
    fn parameters_of_factors_stay_within_their_bounds() {
        let rows = FittedRows::drawn(400);
        let quantity = Quantity::OtherPosition(1);
        let grammar = Grammar::of(&rows, Some(&[quantity]));
        let range = rows.extent(quantity).range();
        let plain = |shape: Shape, inner: f64| Factor::plain(quantity, shape).with_inner(inner);
        for width in [0.02, 0.1, 1.9].map(|share| share * range) {
            let [low, high] = grammar.around(&plain(Shape::Bump, width));
            assert!(low < high && low >= 0.02 * range && high <= 2.0 * range);
        }
        for rate in [-8.0, 0.0, 7.9].map(|rate| rate / range) {
            let [low, high] = grammar.around(&plain(Shape::Exponential, rate));
            assert!(low < high && [low, high].iter().all(|r| r.abs() <= 8.0 / range));
        }
        let inside = grammar.inside(quantity);
        let middle = 0.5 * (inside[0] + inside[1]);
        let is_inside = |share: f64, centre: f64| {
            grammar.is_inside(&plain(Shape::Bump, share * range).about(centre))
        };
        assert!(is_inside(0.1, middle));
        assert!(!is_inside(0.0201, middle) && !is_inside(1.999, middle));
        assert!(!is_inside(0.1, inside[0]) && !is_inside(0.1, inside[1]));
        for centre in inside {
            let [low, high] = grammar.around_centre(&plain(Shape::Bump, 0.1).about(centre));
            assert!(low < high && low >= inside[0] && high <= inside[1]);
        }
    }
}
