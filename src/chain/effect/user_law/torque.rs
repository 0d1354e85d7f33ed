//! The torque of a user-defined law with its derivatives, as the chain evaluates it.

use crate::chain::effect::expression::{Expression, Function, StateLaw, Variable};
use crate::chain::effect::formula::derivative::derivative;
use crate::chain::effect::formula::tape::{LANES, Run, States, Tape};
use crate::chain::effect::user_law::formulas::Formulas;
use crate::chain::effect::user_law::state_integration::{March, Slopes, StateTrajectory};
use crate::chain::effect::user_law::{ActsOn, LawText};
use crate::chain::effect::{
    Contribution, Flow, LawDynamics, Power, Samples, TorqueLaw, TransmissionLaw, Transmitted,
};
use crate::robot::random::{generator, symmetric};
use crate::stats::range::within;

/// A compiled law.
#[derive(Debug)]
pub struct UserLaw {
    /// What is added, in the motion and the parameters.
    torque: Expression,
    parameters: usize,
    states: Vec<StateLaw>,
    marches: Vec<March>,
    tape: Tape,
    /// Where the slopes by what is no parameter stand among the outputs of the tape, behind those by parameters.
    by_sign: Option<usize>,
    by_position: Option<usize>,
    by_velocity: Option<usize>,
    by_load: Option<usize>,
    by_state: Vec<usize>,
    dynamics: Option<Dynamics>,
    is_proportional: bool,
}

/// A law with one state as a differential equation.
#[derive(Debug)]
struct Dynamics {
    march: March,
    /// Rate, torque, and the slopes of both by state and velocity.
    tape: Tape,
}

/// Seconds after which a state has settled: bristles do within a few times their deflection.
const LONG: f64 = 30.0;

/// Places of what the chain knows behind a law's own parameters: the width over which |τ_M| is rounded off, and the torque
/// constant.
const ROUNDING: usize = 0;
const TORQUE_CONSTANT: usize = 1;

impl UserLaw {
    pub fn compile(text: &LawText, formulas: Formulas) -> Self {
        let count = text.parameters.len();
        let torque = match text.acts_on {
            // τ/g − τ is what the signal shows beyond the torque τ where the true constant is g times the declared one.
            ActsOn::Gain => {
                let load = || Expression::from(Variable::Load);
                load() / formulas.torque - load()
            }
            _ => formulas.torque,
        };
        let evaluated = with_knowledge(&torque, count);
        let mut outputs = vec![evaluated.clone()];
        outputs.extend((0..count).map(|k| derivative(&evaluated, &Expression::parameter(k))));
        let mut slope = |variable: Variable, is_wanted: bool| {
            let by = derivative(&evaluated, &variable.into());
            (is_wanted && by != Expression::Number(0.0)).then(|| {
                outputs.push(by);
                outputs.len() - 1
            })
        };
        let at_joint = text.acts_on == ActsOn::Joint;
        let by_sign = slope(Variable::Sign, true);
        let by_position = slope(Variable::Position, at_joint);
        let by_velocity = slope(Variable::Velocity, at_joint);
        let by_load = slope(Variable::Load, true);
        let by_state = (0..formulas.states.len())
            .filter_map(|k| slope(Variable::State(k), true))
            .collect();
        let states: Vec<StateLaw> = formulas.states.iter().map(|s| s.law.clone()).collect();
        let places = 0..states.len();
        let marches = places.map(|k| March::compile(&states[k], k, count));
        Self {
            is_proportional: is_proportional(&torque, text),
            tape: Tape::compile(&outputs, States::Known),
            marches: marches.collect(),
            dynamics: dynamics(
                &torque,
                &formulas.states.iter().map(|s| &s.rate).collect::<Vec<_>>(),
                &states,
                count,
            ),
            parameters: count,
            torque,
            states,
            by_sign,
            by_position,
            by_velocity,
            by_load,
            by_state,
        }
    }

    /// Registers with the values of the parameters and of what the chain knows.
    fn begin(&self, parameters: &[f64], knowledge: [f64; 2]) -> Run<'_> {
        let mut values = Vec::with_capacity(self.parameters + knowledge.len());
        values.extend_from_slice(&parameters[..self.parameters]);
        values.extend(knowledge);
        self.tape.run(&values)
    }

    /// Calls `visit` with the first sample and the number of samples of every part of a motion; not at all where something
    /// that the law depends on is not known.
    fn along(
        &self,
        run: &mut Run<'_>,
        given: &Given<'_>,
        mut visit: impl FnMut(&Run<'_>, std::ops::Range<usize>),
    ) {
        let inputs = self.tape.inputs();
        let Some(sources) = inputs
            .iter()
            .map(|v| given.source(*v))
            .collect::<Option<Vec<_>>>()
        else {
            return;
        };
        let samples = given.samples.velocity.len();
        for start in (0..samples).step_by(LANES) {
            let range = start..samples.min(start + LANES);
            for (place, source) in sources.iter().enumerate() {
                let register = run.input(place);
                match source {
                    Source::Same(value) => register.fill(*value),
                    Source::Series(series) => {
                        let part = &series[range.clone()];
                        register[..part.len()].copy_from_slice(part);
                        // Lanes without a sample repeat one: nothing of them is read.
                        register[part.len()..].fill(part[0]);
                    }
                }
            }
            run.samples();
            visit(run, range);
        }
    }
}

/// What a law is given.
struct Given<'a> {
    samples: Samples<'a>,
    load: &'a [f64],
    trajectories: &'a [StateTrajectory],
}

enum Source<'a> {
    Series(&'a [f64]),
    Same(f64),
}

impl<'a> Given<'a> {
    /// Where a variable's values are; `None` where they are not known.
    fn source(&self, variable: Variable) -> Option<Source<'a>> {
        let (samples, around) = (self.samples, self.samples.surroundings);
        let count = samples.velocity.len();
        let series = match variable {
            Variable::Position => samples.position,
            Variable::Velocity => samples.velocity,
            Variable::Acceleration => samples.acceleration,
            Variable::Sign => samples.sign,
            Variable::Time => samples.time,
            Variable::Load => self.load,
            Variable::Temperature => around.temperature,
            Variable::Period => return around.period.map(Source::Same),
            Variable::OtherPosition(k) => around.others.get(k)?[0],
            Variable::OtherVelocity(k) => around.others.get(k)?[1],
            Variable::State(k) => &self.trajectories.get(k)?.state,
            Variable::Current | Variable::Duration | Variable::Lag | Variable::LagRate => {
                return None;
            }
        };
        series.get(..count).map(Source::Series)
    }
}

/// Adds an output of the tape to a series.
fn add(run: &Run<'_>, output: Option<usize>, to: &mut [f64]) {
    if let Some(output) = output {
        let register = run.output(output);
        to.iter_mut().zip(register).for_each(|(to, x)| *to += x);
    }
}

impl TorqueLaw for UserLaw {
    fn add(&self, samples: Samples<'_>, parameters: &[f64], out: &mut Contribution<'_>) {
        let trajectories = self.marches.iter().map(|m| m.along(samples, parameters));
        let Some(trajectories) = trajectories.collect::<Option<Vec<_>>>() else {
            return;
        };
        let given = Given {
            samples,
            load: &[],
            trajectories: &trajectories,
        };
        let mut run = self.begin(parameters, [0.0, 1.0]);
        self.along(&mut run, &given, |run, range| {
            add(run, Some(0), &mut out.torque[range.clone()]);
            for k in 0..self.parameters {
                let slopes = &run.output(1 + k)[..range.len()];
                out.by_parameter[k][range.clone()].copy_from_slice(slopes);
            }
            for (trajectory, by_state) in trajectories.iter().zip(&self.by_state) {
                let by_state = run.output(*by_state);
                for Slopes { parameter, series } in &trajectory.slopes {
                    let to = out.by_parameter[*parameter][range.clone()].iter_mut();
                    let slopes = by_state.iter().zip(&series[range.clone()]);
                    to.zip(slopes).for_each(|(to, (a, b))| *to += a * b);
                }
            }
            add(run, self.by_sign, &mut out.by_sign[range.clone()]);
            if self.by_position.is_some() {
                add(run, self.by_position, &mut out.by_position[range.clone()]);
            }
            if self.by_velocity.is_some() {
                add(run, self.by_velocity, &mut out.by_velocity[range]);
            }
        });
    }

    /// Nothing is claimed of a formula.
    fn power(&self) -> Power {
        Power::Exchanges
    }

    fn torque(&self) -> Expression {
        self.torque.clone()
    }

    fn states(&self) -> Vec<StateLaw> {
        self.states.clone()
    }

    fn dynamics(&self) -> Option<&dyn LawDynamics> {
        self.dynamics.as_ref().map(|d| d as &dyn LawDynamics)
    }
}

impl TransmissionLaw for UserLaw {
    fn add(
        &self,
        samples: Samples<'_>,
        load: &[f64],
        parameters: &[f64],
        out: &mut Transmitted<'_>,
    ) {
        let given = Given {
            samples,
            load,
            trajectories: &[],
        };
        for series in out.by_parameter[..self.parameters].iter_mut() {
            series[..load.len()].fill(0.0);
        }
        let constant = samples.surroundings.torque_constant.unwrap_or(1.0);
        let mut run = self.begin(parameters, [out.rounding, constant]);
        self.along(&mut run, &given, |run, range| {
            add(run, Some(0), &mut out.torque[range.clone()]);
            for k in 0..self.parameters {
                let slopes = &run.output(1 + k)[..range.len()];
                out.by_parameter[k][range.clone()].copy_from_slice(slopes);
            }
            add(run, self.by_load, &mut out.by_load[range.clone()]);
            add(run, self.by_sign, &mut out.by_sign[range]);
        });
    }

    fn added(&self) -> Expression {
        self.torque.clone()
    }

    fn is_proportional(&self) -> bool {
        self.is_proportional
    }
}

/// The formula with the current as a share of the load, and the size of the load rounded off about zero, see
/// [`size`](crate::chain::effect::law::size).
fn with_knowledge(formula: &Expression, count: usize) -> Expression {
    let load = || Expression::from(Variable::Load);
    let rounding = || Expression::parameter(count + ROUNDING);
    let size = load().call(Function::Magnitude);
    formula.replaced(&|part| match part {
        Expression::Variable(Variable::Current) => {
            Some(load() / Expression::parameter(count + TORQUE_CONSTANT))
        }
        _ if *part == size => {
            let parabola = (load().squared() / rounding() + rounding()) * 0.5;
            Some(
                load()
                    .magnitude()
                    .if_less(rounding(), parabola, load().magnitude()),
            )
        }
        _ => None,
    })
}

fn dynamics(
    torque: &Expression,
    rates: &[&Expression],
    states: &[StateLaw],
    count: usize,
) -> Option<Dynamics> {
    let ([rate], [state]) = (rates, states) else {
        return None;
    };
    let (z, v) = (
        Expression::from(Variable::State(0)),
        Expression::from(Variable::Velocity),
    );
    let is_foreign =
        |part: &Expression| matches!(part, Expression::Variable(_)) && *part != z && *part != v;
    if torque.any(&is_foreign) {
        return None;
    }
    let formulas = [
        (*rate).clone(),
        derivative(rate, &z),
        derivative(rate, &v),
        torque.clone(),
        derivative(torque, &z),
        derivative(torque, &v),
    ];
    Some(Dynamics {
        march: March::compile(state, 0, count),
        tape: Tape::compile(&formulas, States::Known),
    })
}

impl LawDynamics for Dynamics {
    fn settled(&self, parameters: &[f64], velocity: f64) -> f64 {
        self.march.after(velocity, LONG, parameters)
    }

    fn flow(&self, parameters: &[f64], state: f64, velocity: f64) -> Flow {
        let mut run = self.tape.run(parameters);
        for (place, variable) in self.tape.inputs().iter().enumerate() {
            let value = match variable {
                Variable::State(_) => state,
                _ => velocity,
            };
            run.input(place).fill(value);
        }
        run.samples();
        let [
            rate,
            rate_by_state,
            rate_by_velocity,
            torque,
            torque_by_state,
            torque_by_velocity,
        ] = std::array::from_fn(|k| run.output(k)[0]);
        // The whole slope: that of the rate by velocity reaches the torque through the state.
        Flow {
            rate,
            rate_by_state,
            rate_by_velocity,
            torque,
            torque_by_state,
            torque_by_velocity,
        }
    }
}

/// Whether twice the load takes twice as much, on either side of zero, tried at random values of everything.
fn is_proportional(torque: &Expression, text: &LawText) -> bool {
    /// Rounding of a few dozen operations.
    const TOLERANCE: f64 = 1e-12;
    if !torque.depends_on(Variable::Load) {
        return false;
    }
    let tape = Tape::compile(std::slice::from_ref(torque), States::Known);
    let mut rng = generator(0);
    (0..16).all(|_| {
        let values = text.parameters.iter().map(|p| {
            let drawn = p.typical * (1.0 + symmetric(&mut rng, 0.5));
            within(drawn, [p.lower, p.upper])
        });
        let values: Vec<f64> = values.collect();
        let at: Vec<f64> = tape
            .inputs()
            .iter()
            .map(|_| symmetric(&mut rng, 3.0))
            .collect();
        let of = |factor: f64| {
            let mut run = tape.run(&values);
            for (place, variable) in tape.inputs().iter().enumerate() {
                let is_load = *variable == Variable::Load;
                let value = at[place] * if is_load { factor } else { 1.0 };
                run.input(place).fill(value);
            }
            run.samples();
            run.output(0)[0]
        };
        let (once, twice) = (of(1.0), of(2.0));
        (twice - 2.0 * once).abs() <= TOLERANCE * (twice.abs() + once.abs())
    })
}
