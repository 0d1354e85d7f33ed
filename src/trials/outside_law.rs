//! Laws outside the vocabulary, drawn from a grammar of their own, written apart from that of the formulas that a diagnosis seeks:
//! powers that are no integers are in this alone, the other functions of one variable in both.
//!
//! ```text
//! τ = s (f(x) g(y) + c h(z) k(w)),   x, y, z, w of q, v, tau of the joint, q and v of another
//! f of u|u|^(p−1), |u|^p, u/(1 + u²/a²), 1/(1 + u²/a²), exp(ku), tanh(u/a), u beyond ±a, sin(nu + φ), two slopes that meet at a
//! u = (q − middle)/half range, v/fastest, tau over twice the usual torque
//! ```
//!
//! A function of the joint's own position, speed or load alone, or of speed and load together, is a spring, a contact, a ripple or a
//! friction: it has a name, and is not drawn.

use crate::robot::random::{between, index, symmetric};
use crate::stats::deviation::rms;
use crate::trials::robot::RandomRobot;
use crate::trials::unmodelled_physics::Neighbours;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::{PI, TAU};
use std::fmt::Write;

/// Identifier of a drawn law in the truth of its trial.
pub const LAW: &str = "outside_law";

/// Share of the laws that have two terms, and of the terms that have two factors.
const SUMS: f64 = 0.3;
const PRODUCTS: f64 = 0.7;

/// Variables that a law may have.
const VARIABLES: usize = 5;

/// States over which the torque of a law is the size that is asked for.
const STATES: usize = 512;

/// A variable of the motion, of the law's joint or of another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Argument {
    /// q.
    Position,
    /// v.
    Speed,
    /// What the gear transmits.
    Load,
    /// q of another joint.
    PositionOf(usize),
    /// v of another joint.
    SpeedOf(usize),
}

/// A function of a variable that is scaled to about one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Function {
    /// u |u|^(p − 1).
    OddPower {
        /// p.
        exponent: f64,
    },
    /// |u|^p.
    EvenPower {
        /// p.
        exponent: f64,
    },
    /// u/(1 + u²/a²).
    OddRational {
        /// a.
        width: f64,
    },
    /// 1/(1 + u²/a²).
    EvenRational {
        /// a.
        width: f64,
    },
    /// exp(k u).
    Exponential {
        /// k.
        rate: f64,
    },
    /// tanh(u/a).
    Saturation {
        /// a.
        width: f64,
    },
    /// What of u lies beyond −a and a.
    DeadZone {
        /// a.
        width: f64,
    },
    /// sin(n u + φ).
    Periodic {
        /// n.
        order: f64,
        /// φ.
        phase: f64,
    },
    /// b (u − a) below a, c (u − a) above.
    TwoSlopes {
        /// a.
        at: f64,
        /// b and c.
        slopes: [f64; 2],
    },
}

/// A function of a variable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// The variable.
    pub argument: Argument,
    /// The function.
    pub function: Function,
}

/// A product of functions with its share in the law.
#[derive(Debug, Clone, PartialEq)]
pub struct Product {
    /// Its size in the law.
    pub share: f64,
    /// One or two, of different variables.
    pub parts: Vec<Part>,
}

/// A law on a joint of a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct OutsideLaw {
    /// Its joint.
    pub joint: usize,
    /// One or two.
    pub products: Vec<Product>,
    /// N·m (N).
    pub size: f64,
}

impl Function {
    /// Kinds that are drawn.
    pub const KINDS: usize = 9;

    fn draw(rng: &mut ChaCha8Rng) -> Self {
        let kind = index(rng, Self::KINDS);
        let exponent = between(rng, 1.4, 3.6);
        match kind {
            0 => Self::OddPower { exponent },
            1 => Self::EvenPower { exponent },
            2 => Self::OddRational {
                width: between(rng, 0.15, 0.6),
            },
            3 => Self::EvenRational {
                width: between(rng, 0.15, 0.6),
            },
            4 => Self::Exponential {
                rate: between(rng, 0.7, 2.0).copysign(symmetric(rng, 1.0)),
            },
            5 => Self::Saturation {
                width: between(rng, 0.05, 0.5),
            },
            6 => Self::DeadZone {
                width: between(rng, 0.1, 0.4),
            },
            7 => Self::Periodic {
                order: PI * between(rng, 0.7, 8.0),
                phase: between(rng, 0.0, TAU),
            },
            _ => Self::TwoSlopes {
                at: symmetric(rng, 0.4),
                slopes: [symmetric(rng, 1.0), symmetric(rng, 1.0)],
            },
        }
    }

    /// Its number among the kinds.
    pub fn kind(self) -> usize {
        match self {
            Self::OddPower { .. } => 0,
            Self::EvenPower { .. } => 1,
            Self::OddRational { .. } => 2,
            Self::EvenRational { .. } => 3,
            Self::Exponential { .. } => 4,
            Self::Saturation { .. } => 5,
            Self::DeadZone { .. } => 6,
            Self::Periodic { .. } => 7,
            Self::TwoSlopes { .. } => 8,
        }
    }

    /// At u.
    pub fn at(self, u: f64) -> f64 {
        match self {
            Self::OddPower { exponent } => u * u.abs().powf(exponent - 1.0),
            Self::EvenPower { exponent } => u.abs().powf(exponent),
            Self::OddRational { width } => u / (1.0 + (u / width).powi(2)),
            Self::EvenRational { width } => 1.0 / (1.0 + (u / width).powi(2)),
            Self::Exponential { rate } => (rate * u).exp(),
            Self::Saturation { width } => (u / width).tanh(),
            Self::DeadZone { width } => (u - width).max(0.0) + (u + width).min(0.0),
            Self::Periodic { order, phase } => (order * u + phase).sin(),
            Self::TwoSlopes { at, slopes } => slopes[usize::from(u >= at)] * (u - at),
        }
    }

    /// As formulas of laws write it.
    fn of(self, u: &str) -> String {
        match self {
            Self::OddPower { exponent } => format!("{u}*abs({u})^({:?})", exponent - 1.0),
            Self::EvenPower { exponent } => format!("abs({u})^({exponent:?})"),
            Self::OddRational { width } => format!("{u}/(1 + ({u}/{width:?})^2)"),
            Self::EvenRational { width } => format!("1/(1 + ({u}/{width:?})^2)"),
            Self::Exponential { rate } => format!("exp({rate:?}*{u})"),
            Self::Saturation { width } => format!("tanh({u}/{width:?})"),
            Self::DeadZone { width } => {
                format!("(max({u} - {width:?}, 0) + min({u} + {width:?}, 0))")
            }
            Self::Periodic { order, phase } => format!("sin({order:?}*{u} + {phase:?})"),
            Self::TwoSlopes {
                at,
                slopes: [below, above],
            } => format!(
                "if({u} < {at:?}, ({below:?})*({u} - ({at:?})), ({above:?})*({u} - ({at:?})))"
            ),
        }
    }
}

impl Argument {
    /// Its place among the variables of a law.
    fn number(self) -> usize {
        match self {
            Self::Position => 0,
            Self::Speed => 1,
            Self::Load => 2,
            Self::PositionOf(_) => 3,
            Self::SpeedOf(_) => 4,
        }
    }

    /// Those of a law that knows another joint, in their order.
    fn all(other: usize) -> [Self; VARIABLES] {
        [
            Self::Position,
            Self::Speed,
            Self::Load,
            Self::PositionOf(other),
            Self::SpeedOf(other),
        ]
    }

    /// As formulas of laws name it.
    pub fn name(self, robot: &RandomRobot) -> String {
        match self {
            Self::Position => "q".to_string(),
            Self::Speed => "v".to_string(),
            Self::Load => "tau".to_string(),
            Self::PositionOf(other) => format!("q[{}]", robot.name(other)),
            Self::SpeedOf(other) => format!("v[{}]", robot.name(other)),
        }
    }

    /// A usual value of u: positions anywhere in the range, speeds and loads as random motion has them.
    fn usual(self, rng: &mut ChaCha8Rng) -> f64 {
        const OF_FASTEST: f64 = 0.35;
        const OF_GREATEST: f64 = 0.5;
        let normal: f64 = StandardNormal.sample(rng);
        match self {
            Self::Position | Self::PositionOf(_) => symmetric(rng, 1.0),
            Self::Speed | Self::SpeedOf(_) => OF_FASTEST * normal,
            Self::Load => OF_GREATEST * normal,
        }
    }
}

impl Product {
    fn draw(rng: &mut ChaCha8Rng, other: usize) -> Self {
        loop {
            let mut open = Argument::all(other).to_vec();
            let count = 1 + usize::from(rng.random::<f64>() < PRODUCTS);
            let part = |_| Part {
                argument: open.remove(index(rng, open.len())),
                function: Function::draw(rng),
            };
            let drawn = Self {
                share: 1.0,
                parts: (0..count).map(part).collect(),
            };
            if !drawn.has_name() {
                return drawn;
            }
        }
    }

    /// Whether a law of the vocabulary may be the same, or nearly.
    fn has_name(&self) -> bool {
        use Argument::{Load, Position, Speed};
        let of = |argument: Argument| self.parts.iter().find(|p| p.argument == argument);
        match &self.parts[..] {
            [one] => matches!(one.argument, Position | Speed | Load),
            _ => match (of(Position), of(Speed), of(Load)) {
                (None, Some(_), Some(_)) => true,
                // Friction about a position.
                (Some(place), Some(friction), None) => {
                    matches!(place.function, Function::EvenRational { .. })
                        && matches!(friction.function, Function::Saturation { .. })
                }
                _ => false,
            },
        }
    }

    fn at(&self, state: &[f64; VARIABLES]) -> f64 {
        let parts = self.parts.iter();
        let values = parts.map(|part| part.function.at(state[part.argument.number()]));
        self.share * values.product::<f64>()
    }
}

impl OutsideLaw {
    /// A law on a joint of a robot, which may know another, of a torque that is a share of what the joint usually bears.
    pub fn draw(rng: &mut ChaCha8Rng, robot: &RandomRobot, at: Neighbours, share: f64) -> Self {
        let (joint, other) = (at.joint, at.neighbour);
        let mut products = vec![Product::draw(rng, other)];
        if rng.random::<f64>() < SUMS {
            products.push(Product::draw(rng, other));
        }
        let state = |_| Argument::all(other).map(|argument| argument.usual(rng));
        let states: Vec<[f64; VARIABLES]> = (0..STATES).map(state).collect();
        let size = |of: &dyn Fn(&[f64; VARIABLES]) -> f64| -> f64 {
            let series: Vec<f64> = states.iter().map(of).collect();
            rms(&series).max(f64::MIN_POSITIVE)
        };
        // Terms are of one size, and the law of the size that is asked for.
        for product in &mut products {
            product.share /= size(&|state| product.at(state));
        }
        let whole = size(&|state| products.iter().map(|product| product.at(state)).sum());
        Self {
            joint,
            size: share * robot.torque[joint] / whole,
            products,
        }
    }

    /// The variables that it has, each once.
    pub fn variables(&self) -> Vec<Argument> {
        let mut found: Vec<Argument> = Vec::new();
        for part in self.products.iter().flat_map(|product| &product.parts) {
            if !found.contains(&part.argument) {
                found.push(part.argument);
            }
        }
        found
    }

    /// What results call laws like it.
    pub fn name(&self) -> &'static str {
        let factors = self.products.iter().map(|product| product.parts.len());
        match (self.products.len(), factors.max()) {
            (1, Some(1)) => "outside: a function of another joint",
            (1, _) => "outside: a product",
            (_, Some(1)) => "outside: a sum of functions of another joint",
            _ => "outside: a sum with a product",
        }
    }

    /// The torque as formulas of laws write it.
    pub fn torque(&self, robot: &RandomRobot) -> String {
        let scaled = |argument: Argument| {
            let (name, k) = (argument.name(robot), argument.number());
            match argument {
                Argument::Position | Argument::PositionOf(_) => format!("(({name} - c{k})/s{k})"),
                _ => format!("({name}/s{k})"),
            }
        };
        let product = |product: &Product| {
            let parts = product.parts.iter();
            let parts = parts.map(|part| part.function.of(&scaled(part.argument)));
            let parts: Vec<String> = parts.collect();
            format!("({:?})*{}", product.share, parts.join("*"))
        };
        let products: Vec<String> = self.products.iter().map(product).collect();
        format!("size*({})", products.join(" + "))
    }

    /// Its parameters on a robot.
    pub fn parameters(&self, robot: &RandomRobot) -> Vec<(String, f64)> {
        let mut all = vec![("size".to_string(), self.size)];
        for argument in self.variables() {
            let k = argument.number();
            let joint = match argument {
                Argument::PositionOf(other) | Argument::SpeedOf(other) => other,
                _ => self.joint,
            };
            let scale = match argument {
                Argument::Position | Argument::PositionOf(_) => {
                    let (middle, half_range) = robot.range(joint);
                    all.push((format!("c{k}"), middle));
                    half_range
                }
                Argument::Speed | Argument::SpeedOf(_) => robot.speed(joint),
                Argument::Load => 2.0 * robot.torque[joint],
            };
            all.push((format!("s{k}"), scale));
        }
        all
    }

    /// The table `[[law]]` of a problem file.
    pub fn table(&self, robot: &RandomRobot) -> String {
        let mut table = format!(
            "[[law]]\nid = \"{LAW}\"\nsentence = \"A law outside the vocabulary.\"\nacts_on = \"motor\"\n\
             torque = \"{}\"\n[law.parameters]\n",
            self.torque(robot)
        );
        for (name, value) in self.parameters(robot) {
            // Writing to a string does not fail.
            let _ = writeln!(table, "{name} = {{ typical = {value:?} }}");
        }
        table
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::effect::user_law::{self, ActsOn, LawText, ParameterText, SearchText};
    use crate::chain::effect::{Law, Samples, Surroundings};
    use crate::robot::random::generator;
    use crate::trials::robot::KINDS;

    fn drawn(number: u64) -> (RandomRobot, OutsideLaw) {
        let mut rng = generator(8);
        rng.set_stream(number);
        let robot = RandomRobot::draw(&mut rng, KINDS[number as usize % KINDS.len()]);
        let at = Neighbours {
            joint: 1,
            neighbour: 0,
        };
        let law = OutsideLaw::draw(&mut rng, &robot, at, 0.1);
        (robot, law)
    }

    /// Of 300 laws, every kind of function, of variable and of law is some.
    #[test]
    fn the_grammar_draws_every_kind() {
        let mut functions = [false; Function::KINDS];
        let mut variables = [false; VARIABLES];
        let mut names: Vec<&str> = Vec::new();
        for (_, law) in (0..300).map(drawn) {
            names.push(law.name());
            assert!(law.products.iter().all(|product| !product.has_name()));
            for part in law.products.iter().flat_map(|product| &product.parts) {
                functions[part.function.kind()] = true;
                variables[part.argument.number()] = true;
            }
        }
        names.sort_unstable();
        names.dedup();
        assert_eq!(functions, [true; Function::KINDS]);
        assert_eq!(variables, [true; VARIABLES]);
        assert_eq!(names.len(), 4, "{names:?}");
    }

    /// The text of a law, compiled, is its torque; those that know the load are left out, which has no series here.
    #[test]
    fn a_law_is_written_as_it_is_drawn() {
        let mut compared = 0;
        for (robot, law) in (0..60).map(drawn) {
            let parameters = law.parameters(&robot);
            let text = LawText {
                id: LAW.to_string(),
                sentence: "A law.".to_string(),
                source: String::new(),
                acts_on: ActsOn::Motor,
                torque: law.torque(&robot),
                states: Vec::new(),
                parameters: parameters
                    .iter()
                    .map(|(name, value)| ParameterText {
                        name: name.clone(),
                        unit: None,
                        meaning: String::new(),
                        lower: f64::NEG_INFINITY,
                        upper: f64::INFINITY,
                        typical: *value,
                        search: SearchText::Typical,
                    })
                    .collect(),
                refines: Vec::new(),
            };
            let effect = user_law::effect(&text).unwrap();
            let Law::Motor(compiled) = effect.law else {
                assert!(law.variables().contains(&Argument::Load));
                continue;
            };
            compared += 1;
            let u = [-0.7, -0.2, 0.05, 0.4, 0.9];
            let scaled = |by: f64, about: f64| u.map(|u| about + by * u);
            let motion = |joint: usize| {
                let (middle, half_range) = robot.range(joint);
                [scaled(half_range, middle), scaled(robot.speed(joint), 0.0)]
            };
            let [position, velocity] = motion(1);
            let [other_position, other_velocity] = motion(0);
            let others: [[&[f64]; 2]; 1] = [[&other_position, &other_velocity]];
            let values: Vec<f64> = parameters.iter().map(|(_, value)| *value).collect();
            let torque = compiled.torques(
                Samples {
                    position: &position,
                    velocity: &velocity,
                    acceleration: &[0.0; 5],
                    sign: &velocity.map(f64::signum),
                    time: &[],
                    cyclic: false,
                    surroundings: Surroundings {
                        others: &others,
                        ..Surroundings::default()
                    },
                },
                &values,
            );
            for (u, found) in u.iter().zip(torque) {
                let products = law.products.iter().map(|p| p.at(&[*u; VARIABLES]));
                let expected = law.size * products.sum::<f64>();
                let scale = law.size * law.products.iter().map(|p| p.share).sum::<f64>();
                assert!(
                    (found - expected).abs() < 1e-9 * scale,
                    "{found} {expected}"
                );
            }
        }
        assert!(compared > 20);
    }

    /// The RMS torque over random states of its own, of which so many differ by a tenth.
    #[test]
    fn a_law_has_the_size_asked_for() {
        let mut rng = generator(9);
        for (robot, law) in (0..20).map(drawn) {
            let torques: Vec<f64> = (0..20_000)
                .map(|_| {
                    let state = Argument::all(0).map(|argument| argument.usual(&mut rng));
                    let products = law.products.iter().map(|product| product.at(&state));
                    law.size * products.sum::<f64>()
                })
                .collect();
            let share = rms(&torques) / robot.torque[1];
            assert!((share / 0.1 - 1.0).abs() < 0.6, "{share} {law:?}");
        }
    }
}
