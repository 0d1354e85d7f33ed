//! Linear constraints on the Fourier coefficients: limits of position, velocity, acceleration and jerk.
//!
//! A series between even instants exceeds its samples by at most the factor of
//! [`crate::design::trajectory::fourier_series::Series::between_samples`], so bounds divided by that factor at the instants
//! are the stated bounds at every time.

use crate::design::trajectory::fourier_series::{Basis, ORDERS};
use crate::design::trajectory::motion::Joints;
use nalgebra::DVector;

use crate::problem::linear_rows::{LinearRow, LinearRows};
use crate::setup::limits::JointLimits;

/// Instants of the linear rows per cycle of the highest harmonic: the factor exceeds one by 1.2e-4.
pub const INSTANTS_PER_CYCLE: usize = 200;

/// What a derivative of position may be: `|x − centre| <= half_width`.
#[derive(Debug, Clone, Copy)]
pub struct Band {
    /// In the derivative's unit.
    pub centre: f64,
    /// In the derivative's unit.
    pub half_width: f64,
}

impl Band {
    /// The band of a derivative of position; `None` where it has no limit.
    pub fn of_order(limits: &JointLimits, order: usize) -> Option<Self> {
        let about_zero = |half_width: f64| Self {
            centre: 0.0,
            half_width,
        };
        match order {
            0 => Some(Self {
                centre: limits.middle(),
                half_width: limits.half_range(),
            }),
            1 => Some(about_zero(limits.velocity)),
            2 => Some(about_zero(limits.acceleration)),
            _ => limits.jerk.map(about_zero),
        }
    }

    /// Distance of a value from the nearer end, negative outside.
    pub fn margin(&self, value: f64) -> f64 {
        self.half_width - (value - self.centre).abs()
    }

    /// The end that is nearer to a value.
    pub fn nearer_end(&self, value: f64) -> f64 {
        self.centre + self.half_width.copysign(value - self.centre)
    }
}

/// What a trajectory starts with, beside its bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ends {
    /// Velocity and acceleration are zero at the start of a period.
    AtRest,
    /// Nothing: the motion repeats.
    Free,
}

/// The rows of all moving joints of all trajectories, instants beside each other.
pub fn rows(joints: &Joints, bounds: &[JointLimits], ends: Ends) -> LinearRows {
    let series = joints.series;
    let width = series.width();
    let samples = INSTANTS_PER_CYCLE * series.harmonics;
    let basis = Basis::new(series, samples);
    let mut rows = LinearRows::default();
    for order in 0..ORDERS {
        for sample in 0..samples {
            let numbers = (0..width).map(|c| basis.function(order, c)[sample]);
            rows.table.extend(numbers);
        }
    }
    // Single coefficients, behind the functions of time.
    let single = rows.table.len();
    for c in 0..width {
        rows.table
            .extend((0..width).map(|other| f64::from(u8::from(other == c))));
    }
    let mut inside = DVector::zeros(joints.coefficients());
    let within = 1.0 / series.between_samples(samples);
    for trajectory in 0..joints.trajectories {
        for (m, &j) in joints.moving.iter().enumerate() {
            let first = joints.first(trajectory, m);
            inside[first] = bounds[j].middle();
            let beyond = joints.harmonics[m]..series.harmonics;
            for c in beyond.flat_map(|l| [1 + l, 1 + series.harmonics + l]) {
                rows.rows.push(LinearRow {
                    offset: single + c * width,
                    first,
                    width,
                    lower: 0.0,
                    upper: 0.0,
                });
            }
            for order in 0..ORDERS {
                let row = |sample: usize, lower: f64, upper: f64| LinearRow {
                    offset: (order * samples + sample) * width,
                    first,
                    width,
                    lower,
                    upper,
                };
                if ends == Ends::AtRest && (order == 1 || order == 2) {
                    rows.rows.push(row(0, 0.0, 0.0));
                }
                if let Some(Band { centre, half_width }) = Band::of_order(&bounds[j], order) {
                    let half = half_width * within;
                    let all = (0..samples).map(|k| row(k, centre - half, centre + half));
                    rows.rows.extend(all);
                }
            }
        }
    }
    rows.inside = Some(inside);
    rows
}
