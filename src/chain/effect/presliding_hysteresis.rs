//! Presliding hysteresis (LuGre): bristles bend before the surfaces slide.
//!
//! ```text
//! ż = v − sigma0·|v|·z/g(v),   g = Fc + Fs·exp(−(v/vs)²)
//! torque = sigma0·z + sigma1·ż     in the place of Coulomb friction, beside viscous friction
//! ```
//!
//! Between samples v is linear. Over a part of a step, with v at its middle, the equation is solved
//! exactly, `z⁺ = z e^(−a h) + v h φ(a h)`, `a = sigma0·|v|/g`, `φ(x) = (1 − e^(−x))/x`, and the same
//! recursion is differentiated for the sensitivities. A motion that repeats is run through twice: the
//! bristles forget where they started within a few times their deflection g/sigma0.
//!
//! Gilbert, Maina and Byiringiro 2024 eq. 12 has a linear filter for z, which does not bound it by g;
//! its eqs 16 and 21 have the wrong signs. The law here is the one of Canudas de Wit, Olsson, Åström and Lischinsky.

use crate::chain::effect::expression::{Expression, Function, StateLaw, Variable};
use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Change, Drawn, Knowledge, Sizes, Trial, drawn};
use crate::chain::effect::law::signum;
use crate::chain::effect::site::Site;
use crate::chain::effect::{
    Confounder, Contribution, Dependence, Effect, Flow, Law, LawDynamics, Memory, Needs,
    ParameterInfo, Power, Samples, Search, Span, TorqueLaw, Unit,
};
use crate::robot::random::between;
use rand_chacha::ChaCha8Rng;

/// From a wrist whose bristles bend by tenths of a radian to the first axis of a large arm; half a decade apart where
/// most joints lie.
const STIFFNESSES: &[f64] = &[1.0, 3.0, 10.0, 30.0, 1e2, 3e2, 1e3, 3e3, 1e4, 1e5];

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "presliding_hysteresis",
    sentence: "Before it slides, dry friction acts like a spring with memory (LuGre).",
    equation: "dz/dt = v − sigma0·|v|·z/g, g = Fc + Fs·exp(−(v/vs)²); sigma0·z + sigma1·dz/dt instead of Coulomb friction",
    source: "Canudas de Wit, Olsson, Åström and Lischinsky 1995, eqs 2 to 4",
    parameters: &[
        ParameterInfo::nonlinear(
            "sigma0",
            Unit::TorquePerPosition,
            "stiffness of the bristles",
            Span {
                lower: 1e-3,
                typical: 300.0,
                upper: 1e9,
            },
            Search::Values(STIFFNESSES),
        ),
        ParameterInfo::nonlinear(
            "sigma1",
            Unit::TorquePerSpeed,
            "damping of the bristles",
            Span {
                lower: 0.0,
                typical: 0.1,
                upper: 1e6,
            },
            Search::Typical,
        ),
        ParameterInfo::nonlinear(
            "Fs",
            Unit::Torque,
            "friction at standstill beyond Coulomb friction",
            Span {
                lower: -1e6,
                typical: 0.2,
                upper: 1e6,
            },
            Search::Typical,
        ),
        ParameterInfo::nonlinear(
            "vs",
            Unit::Speed,
            "speed at which that excess has fallen to 37 %",
            Span {
                lower: 1e-5,
                typical: 0.1,
                upper: 100.0,
            },
            Search::Speed(&[0.03, 0.1]),
        ),
    ],
    depends_on: &[
        Dependence::Speed,
        Dependence::Direction,
        Dependence::Position,
    ],
    confounded_with: &[
        Confounder {
            with: "stribeck_friction",
            separated_by: "reversals of small amplitude",
        },
        Confounder {
            with: "coulomb_friction with a wide transition w",
            separated_by: "reversals at several accelerations: w is a speed, g/sigma0 a distance",
        },
    ],
    law: Law::Motor(&Bristles),
    needs: Needs {
        memory: Memory::WholeMotion,
        borrows: &[("coulomb_friction", "Fc")],
        replaces: Some("coulomb_friction"),
        ..Needs::NOTHING
    },
    knowledge: Knowledge {
        finding: Some(finding),
        change: Some(Change::FRICTION),
        sizes: Sizes::First,
        trial: Trial::Drawn(sized),
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    found.with(
        "does not break loose at once: before it slides, its friction acts like a spring of",
        "sigma0",
        "the model switched friction with the sign of the speed",
    )
}

fn sized(site: &Site, rng: &mut ChaCha8Rng) -> Vec<Drawn> {
    let dry = site.dry_friction;
    let stiffness = dry / (between(rng, 0.05, 0.5) * site.share * site.half_range);
    vec![
        drawn("sigma0", stiffness),
        drawn("sigma1", 0.002 * stiffness),
        drawn("Fs", between(rng, 0.1, 0.5) * dry),
        drawn("vs", between(rng, 0.02, 0.15) * site.fastest),
    ]
}

#[derive(Debug)]
struct Bristles;

/// Parts of a step between two samples.
pub(super) const PARTS: usize = 4;

/// Number of parameters: the law's own and Fc.
const COUNT: usize = 5;

/// Least g, as a share of |Fc| + |Fs|: a trial step may make it vanish.
const LEAST_LEVEL: f64 = 1e-3;

/// g of a law without any friction, N·m (N), less than any friction: a search that begins there sees where it grows.
const SMALLEST: f64 = 1e-9;

#[derive(Clone, Copy)]
struct State {
    z: f64,
    by: [f64; COUNT],
}

/// `a/sigma0 = |v|/g` and g with its derivatives.
struct Level {
    g: f64,
    by: [f64; COUNT],
}

fn level(p: &[f64; COUNT], v: f64) -> Level {
    let [_, _, fs, vs, fc] = *p;
    let x = (v / vs).powi(2);
    let excess = (-x).exp();
    let g = fc + fs * excess;
    let friction = fc.abs() + fs.abs();
    let least = LEAST_LEVEL * friction + SMALLEST;
    let by = match g < least && friction > 0.0 {
        true => [0.0; COUNT],
        false => [0.0, 0.0, excess, fs * excess * 2.0 * x / vs, 1.0],
    };
    Level {
        g: g.max(least),
        by,
    }
}

/// `φ(x) = (1 − e^(−x))/x` and its derivative.
fn phi(x: f64) -> (f64, f64) {
    if x < 1e-4 {
        return (1.0 - 0.5 * x + x * x / 6.0, -0.5 + x / 3.0);
    }
    let e = (-x).exp();
    let value = (1.0 - e) / x;
    (value, (e - value) / x)
}

impl State {
    /// One part of a step of length h with speed v.
    fn advance(&mut self, p: &[f64; COUNT], v: f64, h: f64) {
        let level = level(p, v);
        let rate = p[0] * v.abs() / level.g;
        let (decay, (fill, fill_slope)) = ((-rate * h).exp(), phi(rate * h));
        // ∂z⁺/∂a of the exact solution.
        let by_rate = -h * self.z * decay + v * h * h * fill_slope;
        for k in 0..COUNT {
            let own = if k == 0 { v.abs() / level.g } else { 0.0 };
            let rate_by = own - rate / level.g * level.by[k];
            self.by[k] = self.by[k] * decay + by_rate * rate_by;
        }
        self.z = self.z * decay + v * h * fill;
    }

    /// The sliding state at speed v: `z = g·sgn(v)/sigma0`.
    fn sliding(p: &[f64; COUNT], v: f64) -> Self {
        if v == 0.0 {
            return Self {
                z: 0.0,
                by: [0.0; COUNT],
            };
        }
        let level = level(p, v);
        let sign = v.signum();
        let mut by = level.by.map(|g| sign * g / p[0]);
        by[0] -= sign * level.g / (p[0] * p[0]);
        Self {
            z: sign * level.g / p[0],
            by,
        }
    }

    /// Advances from one sample to the next, from one speed to the other.
    fn step(&mut self, p: &[f64; COUNT], [from, to]: [f64; 2], duration: f64) {
        let h = duration / PARTS as f64;
        for part in 0..PARTS {
            let share = (part as f64 + 0.5) / PARTS as f64;
            self.advance(p, from + share * (to - from), h);
        }
    }
}

impl TorqueLaw for Bristles {
    fn add(&self, samples: Samples<'_>, parameters: &[f64], out: &mut Contribution<'_>) {
        let Ok(p) = <&[f64; COUNT]>::try_from(parameters) else {
            return;
        };
        let (v, t) = (samples.velocity, samples.time);
        if v.len() < 2 || t.len() < v.len() {
            return;
        }
        let usual = t[1] - t[0];
        let mut state = State::sliding(p, v[0]);
        if samples.cyclic {
            for k in 0..v.len() {
                let next = (k + 1) % v.len();
                state.step(p, [v[k], v[next]], usual);
            }
        }
        for k in 0..v.len() {
            if k > 0 {
                state.step(p, [v[k - 1], v[k]], t[k] - t[k - 1]);
            }
            put(p, &state, v[k], k, out);
        }
    }

    /// Passive only for sigma1 below a bound that depends on v (Barabanov and Ortega 2000).
    fn power(&self) -> Power {
        Power::Exchanges
    }

    fn torque(&self) -> Expression {
        let [sigma0, sigma1] = [0, 1].map(Expression::parameter);
        let velocity = || Expression::from(Variable::Velocity);
        let rate = sigma0.clone() * velocity().magnitude() / level_formula();
        let bending = velocity() - rate * Variable::State(0);
        sigma0 * Variable::State(0) + sigma1 * bending
    }

    fn states(&self) -> Vec<StateLaw> {
        let sigma0 = || Expression::parameter(0);
        let velocity = || Expression::from(Variable::Velocity);
        let rate = sigma0() * velocity().magnitude() / level_formula();
        let bent = rate * Variable::Duration;
        let small = Expression::from(1.0) - bent.clone() * 0.5 + bent.clone().squared() / 6.0;
        let large = (Expression::from(1.0) - (-bent.clone()).exponential()) / bent.clone();
        let fill = bent.clone().if_less(1e-4, small, large);
        vec![StateLaw {
            start: velocity().call(Function::Signum) * level_formula() / sigma0(),
            advance: Expression::from(Variable::State(0)) * (-bent).exponential()
                + velocity() * Variable::Duration * fill,
            parts: PARTS,
        }]
    }

    fn dynamics(&self) -> Option<&dyn LawDynamics> {
        Some(self)
    }
}

impl LawDynamics for Bristles {
    fn settled(&self, parameters: &[f64], velocity: f64) -> f64 {
        let p = <&[f64; COUNT]>::try_from(parameters);
        p.map_or(0.0, |p| State::sliding(p, velocity).z)
    }

    fn flow(&self, parameters: &[f64], state: f64, velocity: f64) -> Flow {
        let Ok(p) = <&[f64; COUNT]>::try_from(parameters) else {
            return Flow::default();
        };
        let ([sigma0, sigma1, ..], z, v) = (*p, state, velocity);
        let level = level(p, v);
        // ∂g/∂v, by way of ∂g/∂vs: both enter as v/vs alone.
        let slope = -level.by[3] * p[3] / v;
        let slope = if slope.is_finite() { slope } else { 0.0 };
        let decay = sigma0 * v.abs() / level.g;
        let rate_by_velocity = 1.0 - sigma0 * z / level.g * (signum(v) - v.abs() * slope / level.g);
        let rate = v - decay * z;
        Flow {
            rate,
            rate_by_state: -decay,
            rate_by_velocity,
            torque: sigma0 * z + sigma1 * rate,
            torque_by_state: sigma0 - sigma1 * decay,
            torque_by_velocity: sigma1 * rate_by_velocity,
        }
    }
}

/// [`level`] as a formula.
fn level_formula() -> Expression {
    let [fs, vs, fc] = [2, 3, 4].map(Expression::parameter);
    let ratio = Expression::from(Variable::Velocity) / vs;
    let g = fc.clone() + fs.clone() * (-ratio.squared()).exponential();
    let least = (fc.magnitude() + fs.magnitude()) * LEAST_LEVEL + SMALLEST;
    g.call_with(Function::Larger, least)
}

/// Torque and derivatives of sample k, at speed v.
fn put(p: &[f64; COUNT], state: &State, v: f64, k: usize, out: &mut Contribution<'_>) {
    let level = level(p, v);
    let [sigma0, sigma1, ..] = *p;
    let rate = sigma0 * v.abs() / level.g;
    let bending = v - rate * state.z;
    out.torque[k] += sigma0 * state.z + sigma1 * bending;
    for i in 0..COUNT {
        let own = if i == 0 { v.abs() / level.g } else { 0.0 };
        let rate_by = own - rate / level.g * level.by[i];
        let mut by = (sigma0 - sigma1 * rate) * state.by[i] - sigma1 * rate_by * state.z;
        match i {
            0 => by += state.z,
            1 => by += bending,
            _ => {}
        }
        out.by_parameter[i][k] = by;
    }
}
