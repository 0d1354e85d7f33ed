//! From the side on which a recording was made to motor coordinates at joint scale, for all joints of the tree.
//!
//! ```text
//! position_side = "joint"   m = V⁻¹ (q_enc − offset)                  signal "motor_torque"   τ = ratio · τ_rec
//! position_side = "motor"   m = q_enc / ratio
//! position_side = "link"    m = V⁻¹ (q_enc − offset)
//! ```

use crate::chain::controller::Commands;
use crate::chain::model::Model;
use crate::problem_file::RecordingsTable;
use crate::problem_file::choices::{PositionSide, Signal};
use crate::recording::experiment::{Bandwidth, Experiment, Noise};
use crate::recording::samples::Commanded;
use crate::setup::error::{Mismatch, SetupError};
use crate::setup::recording_file::RecordedRobot;
use nalgebra::{DMatrix, DVector};

/// Factors from recorded positions and signals to joint scale.
struct Scale {
    position: Vec<f64>,
    signal: Vec<f64>,
}

fn scale(table: &RecordingsTable, ratio: Option<Vec<f64>>, n: usize) -> Result<Scale, SetupError> {
    let needs = |place| SetupError::mismatch(place, Mismatch::NeedsRatio);
    let motor = table.position_side.value == PositionSide::Motor;
    let torque = table.signal.value == Signal::MotorTorque;
    if ratio.is_none() && motor {
        return Err(needs(&table.position_side.place));
    }
    if ratio.is_none() && torque {
        return Err(needs(&table.signal.place));
    }
    let ratio = ratio.unwrap_or_else(|| vec![1.0; n]);
    let one = vec![1.0; n];
    Ok(Scale {
        position: if motor {
            ratio.iter().map(|r| 1.0 / r).collect()
        } else {
            one.clone()
        },
        signal: match (torque, table.signal.value) {
            (true, _) => ratio,
            (false, Signal::PositionCommand) if motor => ratio.iter().map(|r| 1.0 / r).collect(),
            _ => one,
        },
    })
}

/// Takes what controllers are told beside the position out of the signal of an experiment of the moving joints, for all
/// motors at joint scale.
pub fn take_commands(
    experiment: &mut Experiment,
    commanded: Commanded,
    recorded: RecordedRobot<'_>,
) -> Result<Option<Commands>, SetupError> {
    let RecordedRobot {
        table,
        robot,
        model,
    } = recorded;
    if table.signal.value != Signal::PositionCommand || commanded == Commanded::default() {
        return Ok(None);
    }
    let n = robot.tree.len();
    let moving: Vec<usize> = (0..n).filter(|&k| robot.locked[k].is_none()).collect();
    let rows = experiment.rows();
    let mut series = experiment.signal.split_off(moving.len()).into_iter();
    experiment.raw.signal.truncate(moving.len());
    experiment.white_noise.truncate(moving.len());
    if let Some(noise) = &mut experiment.noise {
        let covariance = &noise.signal_covariance;
        noise.signal_covariance = covariance.view((0, 0), (moving.len(), moving.len())).into();
        noise.autocovariance.truncate(moving.len());
    }
    let mut of_motors = |there: bool| {
        let mut all = vec![vec![0.0; rows]; if there { n } else { 0 }];
        if there {
            for (&k, series) in moving.iter().zip(&mut series) {
                all[k] = series;
            }
        }
        all
    };
    let mut commands = Commands {
        velocity: of_motors(commanded.velocity),
        feed_forward: of_motors(commanded.feed_forward),
    };
    let scale = scale(table, robot.ratio.clone(), n)?;
    for (series, factor) in commands.velocity.iter_mut().zip(&scale.position) {
        multiply(series, *factor);
    }
    if commanded.velocity
        && table.position_side.value != PositionSide::Motor
        && let Some(inverse) = to_motors_of(model)
    {
        mix(&mut commands.velocity, &inverse);
    }
    Ok(Some(commands))
}

/// Brings an experiment of the moving joints to all motors at joint scale; locked ones stand at zero.
pub fn to_motors(
    mut experiment: Experiment,
    recorded: RecordedRobot<'_>,
) -> Result<Experiment, SetupError> {
    let RecordedRobot {
        table,
        robot,
        model,
    } = recorded;
    let n = robot.tree.len();
    let scale = scale(table, robot.ratio.clone(), n)?;
    let moving: Vec<usize> = (0..n).filter(|&k| robot.locked[k].is_none()).collect();
    spread(&mut experiment, &moving, n);
    for k in 0..n {
        let motion = &mut experiment.motion;
        for series in [
            &mut motion.position,
            &mut motion.velocity,
            &mut motion.acceleration,
        ] {
            multiply(&mut series[k], scale.position[k]);
        }
        if table.signal.value != Signal::BaseWrench {
            multiply(&mut experiment.signal[k], scale.signal[k]);
            multiply(&mut experiment.raw.signal[k], scale.signal[k]);
            if let Some(Some(noise)) = experiment.white_noise.get_mut(k) {
                *noise *= scale.signal[k].abs();
            }
        }
    }
    for k in 0..n {
        if let Some(error) = &mut experiment.motion_error {
            for errors in error.orders_mut() {
                errors.scale(k, scale.position[k]);
            }
        }
        if let Some(noise) = &mut experiment.noise {
            noise.recorded_position_sd[k] *= scale.position[k].abs();
            if table.signal.value != Signal::BaseWrench {
                scale_channel(noise, k, scale.signal[k]);
            }
        }
    }
    if table.position_side.value != PositionSide::Motor {
        from_joints(&mut experiment, model);
        if table.signal.value == Signal::PositionCommand
            && let Some(inverse) = to_motors_of(model)
        {
            mix(&mut experiment.signal, &inverse);
            mix(&mut experiment.raw.signal, &inverse);
            experiment
                .white_noise
                .iter_mut()
                .for_each(|noise| *noise = None);
            if let Some(noise) = &mut experiment.noise {
                noise.signal_covariance = &inverse * &noise.signal_covariance * inverse.transpose();
            }
        }
    }
    Ok(experiment)
}

/// V⁻¹, where it is not the identity; joints that are locked stand still.
fn to_motors_of(model: &Model) -> Option<DMatrix<f64>> {
    let coupling = model.coupling(&model.values());
    let n = coupling.nrows();
    let inverse = coupling.try_inverse()?;
    (inverse != DMatrix::identity(n, n)).then_some(inverse)
}

/// Series of motors from those of joints.
fn mix(series: &mut [Vec<f64>], inverse: &DMatrix<f64>) {
    for row in 0..series.first().map_or(0, Vec::len) {
        let joints = DVector::from_iterator(series.len(), series.iter().map(|s| s[row]));
        let motors = inverse * joints;
        for (series, motor) in series.iter_mut().zip(motors.iter()) {
            series[row] = *motor;
        }
    }
}

fn multiply(series: &mut [f64], factor: f64) {
    if factor != 1.0 {
        series.iter_mut().for_each(|x| *x *= factor);
    }
}

fn scale_channel(noise: &mut Noise, channel: usize, factor: f64) {
    for k in 0..noise.signal_covariance.nrows() {
        noise.signal_covariance[(channel, k)] *= factor;
        noise.signal_covariance[(k, channel)] *= factor;
    }
    multiply(&mut noise.autocovariance[channel], factor * factor);
}

/// Puts the series of the moving joints at their places among all joints, zeros at the others.
fn spread(experiment: &mut Experiment, moving: &[usize], n: usize) {
    if moving.len() == n {
        return;
    }
    let rows = experiment.rows();
    let samples = experiment.raw.t.len();
    let place = |series: &mut Vec<Vec<f64>>, length: usize| {
        let extra = series.split_off(series.len().min(moving.len()));
        let mut all = vec![vec![0.0; length]; n];
        for (from, &k) in std::mem::take(series).into_iter().zip(moving) {
            all[k] = from;
        }
        all.extend(extra);
        *series = all;
    };
    let torques = experiment.signal.len() != 6 || moving.len() == 6;
    place(&mut experiment.motion.position, rows);
    place(&mut experiment.motion.velocity, rows);
    place(&mut experiment.motion.acceleration, rows);
    if torques {
        place(&mut experiment.signal, rows);
        place(&mut experiment.raw.signal, samples);
        spread_white_noise(&mut experiment.white_noise, moving, n);
    }
    let mut bandwidth: Vec<Bandwidth> = Vec::with_capacity(n);
    for k in 0..n {
        let at = moving.iter().position(|&m| m == k).unwrap_or(0);
        bandwidth.push(experiment.bandwidth[at]);
    }
    experiment.bandwidth = bandwidth;
    let all = |deviations: &mut Vec<f64>| {
        let mut all = vec![0.0; n];
        for (from, &k) in deviations.iter().zip(moving) {
            all[k] = *from;
        }
        *deviations = all;
    };
    if let Some(error) = &mut experiment.motion_error {
        for errors in error.orders_mut() {
            errors.spread(moving, n);
        }
    }
    if let Some(noise) = &mut experiment.noise {
        all(&mut noise.recorded_position_sd);
        if torques {
            spread_covariance(noise, moving, n);
        }
    }
}

fn spread_white_noise(white: &mut Vec<Option<f64>>, moving: &[usize], n: usize) {
    if white.is_empty() {
        return;
    }
    let extra = white.split_off(white.len().min(moving.len()));
    let mut all = vec![None; n];
    for (from, &k) in std::mem::take(white).into_iter().zip(moving) {
        all[k] = from;
    }
    all.extend(extra);
    *white = all;
}

fn spread_covariance(noise: &mut Noise, moving: &[usize], n: usize) {
    let old = &noise.signal_covariance;
    let extra = old.nrows() - moving.len();
    let places: Vec<usize> = moving.iter().copied().chain(n..n + extra).collect();
    let mut all = DMatrix::zeros(n + extra, n + extra);
    for (i, &to_i) in places.iter().enumerate() {
        for (j, &to_j) in places.iter().enumerate() {
            all[(to_i, to_j)] = old[(i, j)];
        }
    }
    let mut autocovariance = vec![Vec::new(); n + extra];
    for (from, &to) in std::mem::take(&mut noise.autocovariance)
        .into_iter()
        .zip(&places)
    {
        autocovariance[to] = from;
    }
    noise.signal_covariance = all;
    noise.autocovariance = autocovariance;
}

/// `m = V⁻¹ (q − offset)` for positions of the joints.
fn from_joints(experiment: &mut Experiment, model: &Model) {
    let n = model.tree().len();
    let coupling = model.coupling_of_motions(&model.values());
    let identity = DMatrix::<f64>::identity(n, n);
    if coupling == identity && model.offset().iter().all(|o| *o == 0.0) {
        return;
    }
    // The model refuses a coupling that cannot be inverted.
    let inverse = coupling.try_inverse().unwrap_or(identity);
    let motion = &mut experiment.motion;
    let shift = model.offset().clone();
    let none = DVector::zeros(n);
    let series = [
        &mut motion.position,
        &mut motion.velocity,
        &mut motion.acceleration,
    ];
    for (series, shift) in series.into_iter().zip([&shift, &none, &none]) {
        for row in 0..series.first().map_or(0, Vec::len) {
            // The motor of a locked joint stands at zero; its offset is where the joint is held.
            let joints = DVector::from_fn(n, |j, _| match model.joints()[j].locked {
                true => 0.0,
                false => series[j][row] - shift[j],
            });
            let motors = &inverse * joints;
            for j in 0..n {
                series[j][row] = match model.joints()[j].locked {
                    true => 0.0,
                    false => motors[j],
                };
            }
        }
    }
}
