//! Fourier coefficients of a motion read from JSON: `coefficients.json` or `result.json` of a design, or a file of the same form.
//!
//! A joint states amplitudes of velocity, `a` and `b`, or of position, `sine = a/(lω)` and `cosine = −b/(lω)`;
//! short lists go on with zeros.

use std::f64::consts::TAU;
use std::fs;

use nalgebra::DVector;
use serde::Deserialize;
use serde_json::Value;

use crate::design::error::{DesignError, Unsuitable};
use crate::design::trajectory::fourier_series::Series;
use crate::design::trajectory::motion::Joints;
use crate::problem_file::{FilePath, Located};

/// Difference of periods that is rounding, as a share.
const ROUNDING: f64 = 1e-9;

/// The form of a file.
#[derive(Debug, Deserialize)]
struct Stated {
    period: f64,
    trajectories: Vec<Vec<StatedJoint>>,
}

#[derive(Debug, Deserialize)]
struct StatedJoint {
    joint: String,
    q0: f64,
    #[serde(default)]
    a: Vec<f64>,
    #[serde(default)]
    b: Vec<f64>,
    #[serde(default)]
    sine: Vec<f64>,
    #[serde(default)]
    cosine: Vec<f64>,
}

impl StatedJoint {
    fn harmonics(&self) -> usize {
        let lists = [&self.a, &self.b, &self.sine, &self.cosine];
        lists.into_iter().map(Vec::len).max().unwrap_or(0)
    }

    /// q0, a, b; amplitudes of position where those of velocity are not stated.
    fn coefficients(&self, series: Series) -> Vec<f64> {
        let of = |velocity: &[f64], position: &[f64], sign: f64| -> Vec<f64> {
            (0..series.harmonics)
                .map(|l| match (velocity.is_empty(), position.get(l)) {
                    (true, Some(amplitude)) => {
                        sign * amplitude * (l + 1) as f64 * TAU / series.period
                    }
                    _ => velocity.get(l).copied().unwrap_or(0.0),
                })
                .collect()
        };
        let mut own = vec![self.q0];
        own.extend(of(&self.a, &self.sine, 1.0));
        own.extend(of(&self.b, &self.cosine, -1.0));
        own
    }
}

/// A motion of its own period and number of harmonics.
#[derive(Debug, Clone)]
pub struct StatedMotion {
    /// The joints that move, in which series.
    pub joints: Joints,
    /// Its coefficients, in the order of [`Joints`].
    pub x: DVector<f64>,
}

impl StatedMotion {
    /// Reads the motion of the joints that move in a design.
    ///
    /// # Errors
    /// A file that cannot be read or has another form; a joint that it does not state.
    pub fn read(
        path: &Located<FilePath>,
        joints: &Joints,
        names: &[String],
    ) -> Result<Self, DesignError> {
        let fault =
            |why: String| DesignError::unsuitable(&path.place, Unsuitable::NotCoefficients { why });
        let file = &path.resolved;
        let text =
            fs::read_to_string(file).map_err(|e| fault(format!("{}: {e}", file.display())))?;
        let value: Value = serde_json::from_str(&text).map_err(|e| fault(e.to_string()))?;
        let own = value.get("coefficients").cloned().unwrap_or(value);
        let stated: Stated = serde_json::from_value(own).map_err(|e| fault(e.to_string()))?;
        let counts = stated
            .trajectories
            .iter()
            .flatten()
            .map(StatedJoint::harmonics);
        let series = Series {
            harmonics: counts.max().unwrap_or(0),
            period: stated.period,
        };
        if !(series.period > 0.0 && series.period.is_finite()) || series.harmonics == 0 {
            return Err(fault("it states no motion".to_string()));
        }
        let mut x = Vec::new();
        for trajectory in &stated.trajectories {
            for &j in &joints.moving {
                let found = trajectory.iter().find(|s| s.joint == names[j]);
                let found =
                    found.ok_or_else(|| fault(format!("joint `{}` is missing", names[j])))?;
                x.extend(found.coefficients(series));
            }
        }
        Ok(Self {
            joints: Joints {
                series,
                trajectories: stated.trajectories.len(),
                ..joints.clone()
            },
            x: DVector::from_vec(x),
        })
    }

    /// The same motion in the coefficients of a design; trajectories beyond those stated repeat them. `None`
    /// where the period differs or the design has fewer harmonics.
    pub fn within(&self, joints: &Joints) -> Option<DVector<f64>> {
        let (own, asked) = (self.joints.series, joints.series);
        let same = (own.period - asked.period).abs() <= ROUNDING * asked.period;
        if !same || own.harmonics > asked.harmonics || self.joints.trajectories == 0 {
            return None;
        }
        let mut x = DVector::zeros(joints.coefficients());
        for trajectory in 0..joints.trajectories {
            let stated = trajectory % self.joints.trajectories;
            for m in 0..joints.moving.len() {
                let (from, to) = (self.joints.first(stated, m), joints.first(trajectory, m));
                x[to] = self.x[from];
                for l in 0..own.harmonics {
                    x[to + 1 + l] = self.x[from + 1 + l];
                    x[to + 1 + asked.harmonics + l] = self.x[from + 1 + own.harmonics + l];
                }
            }
        }
        Some(x)
    }
}
