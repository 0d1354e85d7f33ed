//! A tree with closed loops: positions, velocities and accelerations of the joints without a motor, and the
//! way of torques to the motors.

use crate::mechanism::condition::Condition;
use crate::mechanism::error::{MechanismError, OpenLoop};
use crate::mechanism::motion::Links;
use crate::robot::random::symmetric;
use crate::robot::tree::Tree;
use nalgebra::{DMatrix, DVector, Dyn, QR};
use rand_chacha::ChaCha8Rng;
use std::ops::Range;

/// Step of the motors on the way to a position far from home, rad or m: small against the angles between links at which two
/// assemblies meet.
const ON_THE_WAY: f64 = 0.02;

/// Steps of Newton's iteration after which the loops count as open.
const MOST_STEPS: usize = 60;

/// Halvings of a step that does not bring the loops nearer to closing.
const MOST_HALVINGS: usize = 30;

/// Largest gap of a closed loop, m or rad: rounding of metres in some tens of operations.
const CLOSED: f64 = 1e-14;

/// Gap that rounding may leave where no step is better.
const NEARLY_CLOSED: f64 = 1e-9;

/// Least share of the least singular value of G_p in the largest. A lever of 0.3 m is then within 0.02° of
/// lining up with its rod.
const SINGULAR: f64 = 3e-4;

/// Least share of the least singular value of G_p in the largest at which the motors hold the joints without one well: forces
/// in the loops, and errors of positions that follow from the motors, grow by its inverse, so that at most two digits are lost.
pub const WELL_HELD: f64 = 0.01;

/// How far random positions of motors lie from home, rad or m.
const AROUND: f64 = 0.5;

/// A tree of links with the conditions that close its loops.
#[derive(Debug, Clone)]
pub struct Mechanism {
    tree: Tree,
    passive: Vec<usize>,
    actuated: Vec<usize>,
    /// All positions: where searches begin, which chooses the assembly.
    home: Vec<f64>,
    conditions: Vec<Condition>,
    massless: Vec<bool>,
    rows: usize,
}

/// g's derivatives at one position, and the solution of `G_p x = b` by least squares.
struct Linear {
    passive: QR<f64, Dyn, Dyn>,
    actuated: DMatrix<f64>,
}

impl Mechanism {
    /// A mechanism whose joints are those of `tree`, `passive` those without a motor. `home` (n, rad or m) is
    /// where searches begin; its passive entries need not close the loops, only lie near.
    ///
    /// # Errors
    /// A joint that the tree does not have, fewer conditions than passive joints, and a home whose loops
    /// cannot be closed.
    pub fn new(
        tree: Tree,
        passive: &[usize],
        conditions: Vec<Condition>,
        mut home: Vec<f64>,
    ) -> Result<Self, MechanismError> {
        let joints = tree.len();
        let mut passive = passive.to_vec();
        passive.sort_unstable();
        let twice = passive.windows(2).find(|pair| pair[0] == pair[1]);
        let beyond = passive.iter().find(|joint| **joint >= joints);
        if let Some(&joint) = twice.map(|pair| &pair[0]).or(beyond) {
            return Err(MechanismError::NoSuchJoint { joint, joints });
        }
        let rows = conditions.iter().map(Condition::rows).sum();
        if rows < passive.len() {
            return Err(MechanismError::Loose {
                conditions: rows,
                passive: passive.len(),
            });
        }
        home.resize(joints, 0.0);
        let mut mechanism = Self {
            actuated: (0..joints).filter(|j| !passive.contains(j)).collect(),
            massless: vec![false; joints],
            home: home.clone(),
            passive,
            conditions,
            rows,
            tree,
        };
        mechanism.close(&mut home)?;
        mechanism.home = home;
        Ok(mechanism)
    }

    /// The same mechanism with links that weigh nothing: their inertial parameters are zero and no unknowns.
    pub fn with_massless(mut self, links: &[usize]) -> Self {
        links.iter().for_each(|&link| self.massless[link] = true);
        self
    }

    /// The tree that is left where the loops are cut.
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// Joints without a motor, ascending.
    pub fn passive(&self) -> &[usize] {
        &self.passive
    }

    /// Joints with a motor, ascending.
    pub fn actuated(&self) -> &[usize] {
        &self.actuated
    }

    /// What closes the loops.
    pub fn conditions(&self) -> &[Condition] {
        &self.conditions
    }

    /// Whether a link weighs nothing by construction.
    pub fn is_massless(&self, link: usize) -> bool {
        self.massless[link]
    }

    /// Positions (n, rad or m) at which the loops are closed.
    pub fn home(&self) -> &[f64] {
        &self.home
    }

    /// A state of random motors about home: positions within `AROUND` as far as the loops close and are held well there,
    /// velocities and accelerations of the motors within the given ranges. Gives q, q̇, q̈ (n each).
    pub fn draw(&self, rng: &mut ChaCha8Rng, [speed, rate]: [f64; 2]) -> [Vec<f64>; 3] {
        let away: Vec<f64> = self
            .actuated
            .iter()
            .map(|_| symmetric(rng, AROUND))
            .collect();
        let mut share = 1.0;
        let mut q = self.home.clone();
        for _ in 0..MOST_HALVINGS {
            let mut trial = self.home.clone();
            for (&joint, away) in self.actuated.iter().zip(&away) {
                trial[joint] += share * away;
            }
            if self.close_from_home(&mut trial).is_ok() && self.determination(&trial) >= WELL_HELD {
                q = trial;
                break;
            }
            share *= 0.5;
        }
        let (mut dq, mut ddq) = (vec![0.0; q.len()], vec![0.0; q.len()]);
        for &joint in &self.actuated {
            dq[joint] = symmetric(rng, speed);
            ddq[joint] = symmetric(rng, rate);
        }
        self.follow(&q, [&mut dq, &mut ddq]);
        [q, dq, ddq]
    }

    /// Closes the loops at motors' positions that may lie far from home: on the straight way there in small steps, so that the
    /// assembly stays that of home.
    ///
    /// # Errors
    /// As of [`close`](Self::close), anywhere on the way.
    pub fn close_from_home(&self, q: &mut [f64]) -> Result<(), MechanismError> {
        let way = |&joint: &usize| q[joint] - self.home[joint];
        let ways: Vec<f64> = self.actuated.iter().map(way).collect();
        let longest = ways.iter().fold(0.0_f64, |most, way| most.max(way.abs()));
        let steps = (longest / ON_THE_WAY).ceil().max(1.0);
        q.copy_from_slice(&self.home);
        for step in 1..=steps as usize {
            for (&joint, way) in self.actuated.iter().zip(&ways) {
                q[joint] = self.home[joint] + step as f64 / steps * way;
            }
            self.close(q)?;
        }
        Ok(())
    }

    /// Closes the loops: moves the passive entries of q (n, rad or m) so that g(q) = 0, by Newton's iteration
    /// from where they are. The actuated entries stay.
    ///
    /// # Errors
    /// Outside of the workspace; at a singularity, where the motors do not hold the passive joints.
    pub fn close(&self, q: &mut [f64]) -> Result<(), MechanismError> {
        let mut gap = self.gap(q);
        for _ in 0..MOST_STEPS {
            if gap.amax() <= CLOSED {
                break;
            }
            let step = self.linear(q).solve(&as_matrix(&gap));
            let Some((better, left)) = self.nearer(q, &step, gap.norm()) else {
                break;
            };
            q.copy_from_slice(&better);
            gap = left;
        }
        if gap.amax() > NEARLY_CLOSED {
            return Err(MechanismError::OutsideWorkspace {
                motors: self.motors(q),
                gap: gap.amax(),
            });
        }
        let ratio = self.determination(q);
        if ratio < SINGULAR {
            let motors = self.motors(q);
            return Err(MechanismError::Singular { motors, ratio });
        }
        Ok(())
    }

    /// The longest of the halved steps that leaves a smaller gap.
    fn nearer(&self, q: &[f64], step: &DMatrix<f64>, gap: f64) -> Option<(Vec<f64>, DVector<f64>)> {
        let mut share = 1.0;
        for _ in 0..MOST_HALVINGS {
            let mut trial = q.to_vec();
            for (&joint, change) in self.passive.iter().zip(step.iter()) {
                trial[joint] -= share * change;
            }
            let left = self.gap(&trial);
            if left.norm() < gap {
                return Some((trial, left));
            }
            share *= 0.5;
        }
        None
    }

    /// P (passive x actuated) with `q̇_p = P q̇_a`, at closed positions q (n).
    pub fn velocity_map(&self, q: &[f64]) -> DMatrix<f64> {
        let linear = self.linear(q);
        -linear.solve(&linear.actuated)
    }

    /// Sets the passive entries of q̇ and q̈ (n each) to what the actuated ones give at closed positions q (n), and gives P.
    pub fn follow(&self, q: &[f64], [dq, ddq]: [&mut [f64]; 2]) -> DMatrix<f64> {
        let linear = self.linear(q);
        let map = -linear.solve(&linear.actuated);
        let of_motors = |values: &[f64]| {
            let own = self.actuated.iter().map(|&j| values[j]);
            DVector::from_iterator(self.actuated.len(), own)
        };
        let moved = &map * of_motors(dq);
        for (&joint, speed) in self.passive.iter().zip(moved.iter()) {
            dq[joint] = *speed;
        }
        let links = Links::at(&self.tree, q, dq);
        let mut bias = DVector::zeros(self.rows);
        self.each(|condition, rows| condition.bias(&links, &mut bias.as_mut_slice()[rows]));
        let moved = linear.solve(&as_matrix(&(bias + &linear.actuated * of_motors(ddq))));
        for (&joint, acceleration) in self.passive.iter().zip(moved.iter()) {
            ddq[joint] = -acceleration;
        }
        map
    }

    /// Sets the passive entries of a state (q, q̇, q̈ of n each) to what the actuated ones give, and gives P; the passive
    /// entries of q are where the search begins.
    ///
    /// # Errors
    /// As of [`close`](Self::close).
    pub fn complete(&self, [q, dq, ddq]: [&mut [f64]; 3]) -> Result<DMatrix<f64>, MechanismError> {
        self.close(q)?;
        Ok(self.follow(q, [dq, ddq]))
    }

    /// Sets the passive joints over some samples of a motion (position, velocity and acceleration, `[joint][sample]`) to what
    /// the actuated ones give, and gives P of each; the search at a sample begins where the one before ended, that at the
    /// first at home.
    ///
    /// # Errors
    /// The first sample at which the loops stay open or the passive joints are not held.
    pub fn complete_motion(
        &self,
        mut motion: [&mut [Vec<f64>]; 3],
        samples: Range<usize>,
    ) -> Result<Vec<DMatrix<f64>>, OpenLoop> {
        let mut state = [
            self.home.clone(),
            vec![0.0; self.home.len()],
            vec![0.0; self.home.len()],
        ];
        let mut maps = Vec::with_capacity(samples.len());
        for sample in samples {
            for (values, series) in state.iter_mut().zip(&motion) {
                for &joint in &self.actuated {
                    values[joint] = series[joint][sample];
                }
            }
            let [q, dq, ddq] = &mut state;
            let near = match maps.is_empty() {
                true => self.close_from_home(q),
                false => Ok(()),
            };
            let map = near.and_then(|()| self.complete([q, dq, ddq]));
            maps.push(map.map_err(|error| OpenLoop { sample, error })?);
            for (values, series) in state.iter().zip(motion.iter_mut()) {
                for &joint in &self.passive {
                    series[joint][sample] = values[joint];
                }
            }
        }
        Ok(maps)
    }

    /// g(q), m and rad.
    pub fn gap(&self, q: &[f64]) -> DVector<f64> {
        let links = Links::at(&self.tree, q, &vec![0.0; q.len()]);
        let mut gap = DVector::zeros(self.rows);
        self.each(|condition, rows| condition.gap(&links, &mut gap.as_mut_slice()[rows]));
        gap
    }

    /// G (rows of g x n).
    pub fn derivatives(&self, q: &[f64]) -> DMatrix<f64> {
        let links = Links::at(&self.tree, q, &vec![0.0; q.len()]);
        let mut out = DMatrix::zeros(self.rows, q.len());
        for joint in 0..q.len() {
            let mut column = out.column_mut(joint);
            let column = column.as_mut_slice();
            self.each(|condition, rows| condition.column(&links, joint, &mut column[rows]));
        }
        out
    }

    fn each(&self, mut visit: impl FnMut(&Condition, std::ops::Range<usize>)) {
        let mut first = 0;
        for condition in &self.conditions {
            let end = first + condition.rows();
            visit(condition, first..end);
            first = end;
        }
    }

    fn linear(&self, q: &[f64]) -> Linear {
        let derivatives = self.derivatives(q);
        Linear {
            passive: derivatives.select_columns(&self.passive).qr(),
            actuated: derivatives.select_columns(&self.actuated),
        }
    }

    /// Least singular value of G_p as a share of the largest: how well the motors hold the joints without one.
    pub fn determination(&self, q: &[f64]) -> f64 {
        let passive = self.derivatives(q).select_columns(&self.passive);
        let values = passive.singular_values();
        match values.amax() {
            0.0 => 0.0,
            largest => values.min() / largest,
        }
    }

    fn motors(&self, q: &[f64]) -> String {
        let entries = self.actuated.iter();
        let named = entries.map(|&j| format!("{} = {:.4}", self.tree.joints()[j].name, q[j]));
        named.collect::<Vec<_>>().join(", ")
    }
}

fn as_matrix(vector: &DVector<f64>) -> DMatrix<f64> {
    DMatrix::from_column_slice(vector.len(), 1, vector.as_slice())
}

impl Linear {
    /// The solution; zero where G_p has not full rank, so that a search stays where it is.
    fn solve(&self, right: &DMatrix<f64>) -> DMatrix<f64> {
        let triangle = self.passive.r();
        let turned = self.passive.q().transpose() * right;
        let solution = triangle.solve_upper_triangular(&turned);
        solution.unwrap_or_else(|| DMatrix::zeros(triangle.ncols(), right.ncols()))
    }
}
