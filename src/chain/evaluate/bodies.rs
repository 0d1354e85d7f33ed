//! Torques of the rigid bodies along a motion and their derivatives by it, kept for evaluations in which
//! neither bodies nor motion change.

use crate::chain::evaluate::known_bodies::{KnownBodies, Slopes};
use crate::chain::evaluate::{BLOCK, Evaluator, Segment};
use crate::chain::model::Model;
use crate::robot::derivative_batch::DerivativeBatch;
use nalgebra::DVector;
use rayon::prelude::*;
use std::ops::Range;
use std::rc::Rc;

/// Samples that a thread takes up.
const PART: usize = 512;

impl KnownBodies {
    /// What the bodies do along a motion as a function of some inertial parameters, `τ = τ₀ + Σ Y_k φ_k`.
    ///
    /// `None` where that changes with another parameter of `columns`, an entry of V or an offset that moves the joints or the
    /// tilt of the base that turns gravity, and for a mechanism with loops.
    pub fn linear(
        model: &Model,
        values: &DVector<f64>,
        columns: &[usize],
        segment: Segment<'_>,
    ) -> Option<Self> {
        let role = |p: &usize| model.parameters()[*p].role;
        if columns.iter().any(|&p| model.moves_bodies(p)) || model.mechanism().is_some() {
            return None;
        }
        let inertial: Vec<usize> = columns
            .iter()
            .copied()
            .filter(|p| role(p).is_inertial())
            .collect();
        let mut rest = values.clone();
        for &p in &inertial {
            rest[p] = 0.0;
        }
        let segment = Segment {
            bodies: None,
            ..segment
        };
        let samples = segment.motors.len();
        let parts: Vec<Range<usize>> = (0..samples)
            .step_by(PART)
            .map(|start| start..samples.min(start + PART))
            .collect();
        let of = |part: Range<usize>| {
            let mut evaluator = Evaluator::along(model, &rest, &inertial, BLOCK);
            let mut bodies = Self::empty(model, &inertial, part.len());
            for start in part.clone().step_by(BLOCK) {
                let range = start..part.end.min(start + BLOCK);
                evaluator.append_linear(&mut bodies, segment, range);
            }
            bodies
        };
        let parts: Vec<Self> = parts.into_par_iter().map(of).collect();
        Self::joined(&parts)
    }

    /// No samples yet, and room for some.
    fn empty(model: &Model, inertial: &[usize], room: usize) -> Self {
        let rows = model.signal().rows().count(model.tree().len());
        let channels = model.channels().len();
        Self {
            torque: vec![Vec::with_capacity(room); rows],
            columns: inertial
                .iter()
                .map(|&p| (p, vec![Vec::new(); channels]))
                .collect(),
            slopes: Slopes::default(),
            joints: None,
        }
    }

    /// The samples of parts, one after the other; `None` of none.
    fn joined(parts: &[Self]) -> Option<Self> {
        let first = parts.first()?;
        let join = |pick: &dyn Fn(&Self) -> &Vec<f64>| {
            let series: Vec<&[f64]> = parts.iter().map(|part| pick(part).as_slice()).collect();
            series.concat()
        };
        let torque = (0..first.torque.len()).map(|row| join(&|part| &part.torque[row]));
        let columns = first.columns.iter().enumerate().map(|(k, (p, channels))| {
            let channels = 0..channels.len();
            let of = |c: usize| join(&|part| &part.columns[k].1[c]);
            (*p, channels.map(of).collect())
        });
        Some(Self {
            torque: torque.collect(),
            columns: columns.collect(),
            slopes: Slopes::default(),
            joints: None,
        })
    }

    /// The torques, columns and joints at every `stride`-th sample.
    pub fn thinned(&self, stride: usize) -> Self {
        let thin = |s: &Vec<f64>| s.iter().step_by(stride).copied().collect();
        let thin_all = |of: &Vec<Vec<f64>>| of.iter().map(thin).collect();
        let of_column = |(p, rows): &(usize, Vec<Vec<f64>>)| (*p, rows.iter().map(thin).collect());
        Self {
            torque: self.torque.iter().map(thin).collect(),
            columns: self.columns.iter().map(of_column).collect(),
            slopes: Slopes::default(),
            joints: self.joints.as_ref().map(|of| of.each_ref().map(thin_all)),
        }
    }
}

impl Evaluator<'_> {
    /// What the bodies do along a whole recording, without lags.
    pub fn known_bodies(&mut self, segment: Segment<'_>) -> KnownBodies {
        let range = 0..segment.motors.len();
        self.rigid.clear(range.len());
        self.move_joints(segment.motors, range.clone());
        self.rigid_body(segment, range.clone());
        let all: Vec<usize> = (0..self.model.joints().len()).collect();
        let (_, slopes) = self.slopes(segment.loaded, range.len(), &all);
        KnownBodies {
            torque: self.rigid.values.clone(),
            columns: Vec::new(),
            slopes,
            joints: None,
        }
    }

    /// What the bodies do along a whole recording where links lag their motors, for models with further laws that do not
    /// move the links.
    pub fn settled_bodies(&mut self, segment: Segment<'_>) -> KnownBodies {
        let range = 0..segment.motors.len();
        self.rigid.clear(range.len());
        self.move_joints(segment.motors, range.clone());
        self.lag_of_links(segment, range.len());
        self.rigid_body(segment, range);
        KnownBodies {
            torque: self.rigid.values.clone(),
            columns: Vec::new(),
            slopes: Slopes::default(),
            joints: Some(self.joint_motion.clone()),
        }
    }

    /// Joints where they are known to be.
    pub(super) fn take_joints(&mut self, joints: &[Vec<Vec<f64>>; 3], range: Range<usize>) {
        for (to, from) in self.joint_motion.iter_mut().zip(joints) {
            for (to, from) in to.iter_mut().zip(from) {
                to[..range.len()].copy_from_slice(&from[range.clone()]);
            }
        }
    }

    /// Appends what the bodies do over some samples, [`BLOCK`] at most.
    fn append_linear(&mut self, to: &mut KnownBodies, segment: Segment<'_>, range: Range<usize>) {
        let samples = range.len();
        self.rigid.clear(samples);
        self.block.clear(samples);
        self.move_joints(segment.motors, range.clone());
        self.rigid_body(segment, range);
        self.carry_to_motors();
        self.block.settle();
        for (to, torque) in to.torque.iter_mut().zip(&self.rigid.values) {
            to.extend_from_slice(&torque[..samples]);
        }
        for (column, (_, channels)) in to.columns.iter_mut().enumerate() {
            for (channel, to) in channels.iter_mut().enumerate() {
                to.extend_from_slice(self.block.derivative(channel, column).unwrap_or(&[]));
            }
        }
    }

    /// Whether all inertial parameters that have a column here have one there.
    pub(super) fn are_known(&self, known: &KnownBodies) -> bool {
        let has = |p: usize| known.columns.iter().any(|(q, _)| *q == p);
        let parameters = self.model.parameters().iter().enumerate();
        parameters
            .filter(|(p, parameter)| self.column[*p].is_some() && parameter.role.is_inertial())
            .all(|(p, _)| has(p))
    }

    /// What is known of the motors' torques beside what came from the joints, and its columns.
    pub(super) fn take_columns(&mut self, known: &KnownBodies, range: Range<usize>) {
        for (parameter, channels) in &known.columns {
            let (value, column) = (self.values[*parameter], self.column[*parameter]);
            for (channel, series) in channels.iter().enumerate().filter(|(_, s)| !s.is_empty()) {
                let series = &series[range.clone()];
                let torques = self.block.values[channel].iter_mut().zip(series);
                torques.for_each(|(to, y)| *to += value * y);
                if let Some(column) = column {
                    self.block.add_scaled(channel, column, 1.0, series);
                }
            }
        }
    }

    /// Whether a channel that is asked for depends on a row of the rigid body.
    pub(super) fn reaches_signal(&self, row: usize) -> bool {
        // What acts on a link that lags moves it, and with it the others.
        if row >= self.torque_rows()
            || self.model.mechanism().is_some()
            || self.model.joints()[row].has_lag()
        {
            return true;
        }
        let mut wanted = (0..self.wanted.len()).filter(|&c| self.is_needed(c));
        match &self.coupling {
            Some(v) => wanted.any(|c| c >= v.ncols() || v[(row, c)] != 0.0),
            None => wanted.any(|c| c == row),
        }
    }

    /// Whether a row is a sum over all bodies, as those of a base wrench are.
    pub(super) fn has_sums(&self) -> bool {
        self.torque_rows() < self.rigid.values.len()
    }

    /// Joints whose torques are asked for: by a channel, in a sum of all, or by the derivative by an entry of V.
    pub(super) fn joints_asked_for(&self) -> Vec<bool> {
        let all = self.has_sums() || !self.coupling_entries().is_empty();
        (0..self.tree.len())
            .map(|joint| all || self.reaches_signal(joint))
            .collect()
    }

    /// Torques at some joints and derivatives of all rows by their motion, where the joints are now.
    pub(super) fn slopes(
        &mut self,
        loaded: bool,
        samples: usize,
        joints: &[usize],
    ) -> (Vec<Vec<f64>>, Slopes) {
        let bodies = Rc::clone(&self.bodies[usize::from(loaded)]);
        let rows = self.rigid.values.len();
        let mut torque = vec![vec![0.0; samples]; joints.len()];
        let mut slopes = Slopes::zeros(rows, joints.len(), samples);
        let mut derivatives = self.lend_derivatives();
        for start in (0..samples).step_by(BLOCK) {
            let part = start..samples.min(start + BLOCK);
            derivatives.evaluate(&self.tree, &bodies, self.trajectory(), part.clone());
            for (f, &joint) in joints.iter().enumerate() {
                let of_joint = &derivatives.torque(joint)[..part.len()];
                torque[f][part.clone()].copy_from_slice(of_joint);
                for row in 0..rows {
                    let by = self.by_motion(&derivatives, row, joint);
                    slopes.put(row, f, part.clone(), by);
                }
            }
        }
        self.derivatives = Some(derivatives);
        (torque, slopes)
    }

    /// The batch for derivatives, which goes back to `self.derivatives` after use.
    pub(super) fn lend_derivatives(&mut self) -> DerivativeBatch {
        let anew = || DerivativeBatch::new(&self.tree, BLOCK);
        self.derivatives.take().unwrap_or_else(anew)
    }

    /// Derivatives of a row of the rigid body with respect to q_i, q̇_i and q̈_i over the samples that were evaluated last.
    pub(super) fn by_motion<'d>(
        &self,
        derivatives: &'d DerivativeBatch,
        row: usize,
        i: usize,
    ) -> [&'d [f64]; 3] {
        let n = self.model.joints().len();
        let row = match row.checked_sub(self.torque_rows()) {
            None => row,
            Some(component) => n + component,
        };
        [0, 1, 2].map(|order| derivatives.slope(order, row, i))
    }
}
