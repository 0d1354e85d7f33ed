//! Zero-phase low-pass: a 4th-order Butterworth filter run forward and backward, so that the gain is
//!
//! |H(f)|² = 1 / (1 + (tan(π f / f_s) / tan(π f_c / f_s))⁸)   and the phase is zero.
//!
//! Bilinear transform with prewarping, in second-order sections; ends extended by odd reflection
//! and started in steady state, as SciPy's `sosfiltfilt` does (Gustafsson, 1996, on the problem).

use std::f64::consts::PI;

use crate::recording::series::spectrum::{coefficients, synthesis};

/// The filter for one cut-off and one rate.
#[derive(Debug, Clone, PartialEq)]
pub struct ZeroPhase {
    sections: [Section; 2],
    cutoff_hz: f64,
    rate_hz: f64,
}

/// A cut-off that is not strictly between 0 and half the rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutoffOutOfRange {
    /// The cut-off that was asked for, Hz.
    pub cutoff_hz: f64,
    /// Samples per second, Hz: a cut-off lies below half of it.
    pub rate_hz: f64,
}

/// Least samples of odd reflection at each end: three times the taps of two sections, SciPy's
/// default. At a high rate that is shorter than the filter's memory, and the constant beyond it would
/// act as a kink of the motion; so the reflection is as long as the edge where that is longer.
const LEAST_PADDING: usize = 15;

/// Half-width of the filter's memory in units of 1 / cut-off. The slowest pole of the 4th-order
/// Butterworth filter decays as exp(-2π sin(π/8) f_c t): to 0.8 % after 2 / f_c, so that what the
/// reflection at the ends invents has died out.
const EDGE_CYCLES: f64 = 2.0;

/// y = b0 x + z1;  z1 = b1 x - a1 y + z2;  z2 = b2 x - a2 y (transposed direct form II), with unit
/// gain at standstill, b1 = 2 b0 and b2 = b0.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Section {
    b0: f64,
    a1: f64,
    a2: f64,
}

impl ZeroPhase {
    /// Designs the filter. Error: unless 0 < cutoff < rate / 2.
    pub fn new(cutoff_hz: f64, rate_hz: f64) -> Result<Self, CutoffOutOfRange> {
        if !(cutoff_hz > 0.0 && cutoff_hz < 0.5 * rate_hz && rate_hz.is_finite()) {
            return Err(CutoffOutOfRange { cutoff_hz, rate_hz });
        }
        let warped = (PI * cutoff_hz / rate_hz).tan();
        // Damping of the two pole pairs: 2 cos(π/8) and 2 cos(3π/8).
        let section = |pair: f64| Section::new(warped, 2.0 * (pair * PI / 8.0).cos());
        Ok(Self {
            sections: [section(1.0), section(3.0)],
            cutoff_hz,
            rate_hz,
        })
    }

    /// f_c, Hz, at which the gain is one half.
    pub fn cutoff_hz(&self) -> f64 {
        self.cutoff_hz
    }

    /// Seconds at each end of a series in which the result depends on what lies outside.
    pub fn edge_s(&self) -> f64 {
        edge_s(self.cutoff_hz)
    }

    /// Gain at a frequency in Hz, both directions together.
    pub fn gain(&self, frequency_hz: f64) -> f64 {
        gain(frequency_hz, self.cutoff_hz, self.rate_hz)
    }

    /// What it leaves of the standard deviation of white noise: the RMS of its gain over all frequencies.
    pub fn gain_of_white_noise(&self) -> f64 {
        /// Frequencies at which the gain is taken, evenly apart: a cut-off is many times their distance.
        const FREQUENCIES: usize = 4096;
        let at = |k: usize| (k as f64 + 0.5) * 0.5 * self.rate_hz / FREQUENCIES as f64;
        let squares: f64 = (0..FREQUENCIES).map(|k| self.gain(at(k)).powi(2)).sum();
        (squares / FREQUENCIES as f64).sqrt()
    }

    /// Filters a series in place.
    pub fn apply(&self, series: &mut [f64]) {
        let n = series.len();
        if n < 2 {
            return;
        }
        let edge = (self.edge_s() * self.rate_hz).ceil() as usize;
        let pad = edge.max(LEAST_PADDING).min(n - 1);
        let mut padded = Vec::with_capacity(n + 2 * pad);
        padded.extend((1..=pad).rev().map(|k| 2.0 * series[0] - series[k]));
        padded.extend_from_slice(series);
        padded.extend((1..=pad).map(|k| 2.0 * series[n - 1] - series[n - 1 - k]));
        self.pass(&mut padded);
        padded.reverse();
        self.pass(&mut padded);
        padded.reverse();
        series.copy_from_slice(&padded[pad..pad + n]);
    }

    /// Filters one period of a periodic series in place, without ends.
    pub fn apply_periodic(&self, series: &mut [f64]) {
        let n = series.len();
        if n < 2 {
            return;
        }
        let mut spectrum = coefficients(series);
        for (h, c) in spectrum.iter_mut().enumerate() {
            *c *= self.gain(h as f64 * self.rate_hz / n as f64);
        }
        series.copy_from_slice(&synthesis(spectrum, n));
    }

    fn pass(&self, series: &mut [f64]) {
        for section in &self.sections {
            section.pass(series);
        }
    }
}

impl Section {
    /// 1 / (s² + damping s + 1) with s = (1 - z⁻¹) / (warped (1 + z⁻¹)).
    fn new(warped: f64, damping: f64) -> Self {
        let scale = 1.0 / (1.0 + damping * warped + warped * warped);
        Self {
            b0: warped * warped * scale,
            a1: 2.0 * (warped * warped - 1.0) * scale,
            a2: (1.0 - damping * warped + warped * warped) * scale,
        }
    }

    /// Runs once over the series, starting in the steady state of its first value.
    fn pass(&self, series: &mut [f64]) {
        let Section { b0, a1, a2 } = *self;
        let mut z1 = (1.0 - b0) * series[0];
        let mut z2 = (b0 - a2) * series[0];
        for value in series {
            let x = *value;
            let y = b0 * x + z1;
            z1 = 2.0 * b0 * x - a1 * y + z2;
            z2 = b0 * x - a2 * y;
            *value = y;
        }
    }
}

/// Seconds lost at each end of a filtered series: 2 / cut-off.
pub fn edge_s(cutoff_hz: f64) -> f64 {
    EDGE_CYCLES / cutoff_hz
}

/// Gain of the filter at a frequency in Hz, both directions together.
pub(in crate::recording) fn gain(frequency_hz: f64, cutoff_hz: f64, rate_hz: f64) -> f64 {
    let ratio = (PI * frequency_hz / rate_hz).tan() / (PI * cutoff_hz / rate_hz).tan();
    1.0 / (1.0 + ratio.powi(8))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Written by tests/reference/zero_phase.py with SciPy 1.17.1.
    const REFERENCE: &str = include_str!("../../../tests/reference/zero_phase.csv");

    #[test]
    fn matches_scipy_sosfiltfilt() {
        let mut lines = REFERENCE.lines().filter(|line| !line.starts_with('#'));
        lines.next();
        let rows: Vec<Vec<f64>> = lines
            .map(|line| {
                line.split(',')
                    .map(|field| field.parse().unwrap())
                    .collect()
            })
            .collect();
        for (column, cutoff) in [(1, 1.0), (2, 7.0), (3, 40.0)] {
            let mut series: Vec<f64> = rows.iter().map(|row| row[0]).collect();
            ZeroPhase::new(cutoff, 100.0).unwrap().apply(&mut series);
            for (row, value) in rows.iter().zip(&series) {
                // Rounding grows with (rate / cut-off)² of the section: 1e4 ulp at 1 Hz.
                assert!((row[column] - value).abs() < 1e-11, "{cutoff} Hz");
            }
        }
    }

    /// The energy of what one sample becomes is that of white noise of unit variance.
    #[test]
    fn matches_the_energy_of_the_impulse_response() {
        for cutoff in [1.0, 15.0, 40.0] {
            let filter = ZeroPhase::new(cutoff, 200.0).unwrap();
            let mut response = vec![0.0; 20_001];
            response[10_000] = 1.0;
            filter.apply(&mut response);
            let energy: f64 = response.iter().map(|x| x * x).sum();
            assert!(
                (filter.gain_of_white_noise() / energy.sqrt() - 1.0).abs() < 1e-6,
                "{cutoff} Hz"
            );
        }
    }

    #[test]
    fn matches_closed_form_gain_on_a_sine() {
        let filter = ZeroPhase::new(8.0, 200.0).unwrap();
        let n = 2000;
        let sine = |k: usize| (2.0 * PI * 10.0 * k as f64 / 200.0).sin();
        let mut series: Vec<f64> = (0..n).map(sine).collect();
        filter.apply(&mut series);
        for (k, value) in series.iter().enumerate().take(3 * n / 4).skip(n / 4) {
            assert!((value - filter.gain(10.0) * sine(k)).abs() < 1e-9);
        }
        let mut periodic: Vec<f64> = (0..n).map(sine).collect();
        filter.apply_periodic(&mut periodic);
        for (k, value) in periodic.iter().enumerate() {
            assert!((value - filter.gain(10.0) * sine(k)).abs() < 1e-12);
        }
    }

    #[test]
    fn refuses_a_cutoff_outside_the_band() {
        for cutoff in [0.0, -1.0, 50.0, f64::NAN] {
            assert!(ZeroPhase::new(cutoff, 100.0).is_err());
        }
    }
}
