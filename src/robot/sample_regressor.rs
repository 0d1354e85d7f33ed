//! The regressor of one sample, fast: the functionals that meet a link sit in vector lanes.
//!
//! Every link has a list of rows, those of the base reaction first and then those of its ancestors, and
//! the list of its parent is the beginning of its own. Eight rows at a time travel to the link and meet
//! its ten columns; see [`crate::robot::regressor`] for the equations.

use crate::linalg::lanes::instructions::{self, InstructionSet, Kernel};
use crate::linalg::lanes::lane::{LANES, Lanes};
use crate::robot::motion::{JointState, LinkMotion, advance, base_acceleration};
use crate::robot::regressor::{BodyColumns, Functional, Rows};
use crate::robot::tree::Tree;
use crate::robot::vector::{Mat3, Vec3};
use nalgebra::DMatrix;

/// Components of eight functionals, angular then linear, each over the lanes.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Group([[f64; LANES]; 6]);

impl Group {
    const EMPTY: Self = Self([[0.0; LANES]; 6]);

    fn set(&mut self, lane: usize, functional: &Functional<f64>) {
        let Functional { angular, linear } = functional;
        for k in 0..3 {
            self.0[k][lane] = angular.0[k];
            self.0[k + 3][lane] = linear.0[k];
        }
    }

    #[inline(always)]
    fn load<L: Lanes>(&self) -> Functional<L> {
        let [a, b, c, x, y, z] = self.0;
        Functional {
            angular: Vec3([L::from_array(a), L::from_array(b), L::from_array(c)]),
            linear: Vec3([L::from_array(x), L::from_array(y), L::from_array(z)]),
        }
    }

    #[inline(always)]
    fn store<L: Lanes>(&mut self, functional: &Functional<L>) {
        let ([a, b, c], [x, y, z]) = (functional.angular.0, functional.linear.0);
        self.0 = [
            a.to_array(),
            b.to_array(),
            c.to_array(),
            x.to_array(),
            y.to_array(),
            z.to_array(),
        ];
    }
}

/// Regressor of one sample at a time; memory reused from sample to sample.
#[derive(Clone, Debug)]
pub struct SampleRegressor {
    set: InstructionSet,
    motions: Vec<LinkMotion<f64>>,
    /// Rows of the regressor that each link's list stands for.
    rows: Vec<Vec<usize>>,
    /// Every list is 0, 1, 2, ... and fits one group.
    consecutive: bool,
    /// The functionals of each link's list, eight to a group.
    groups: Vec<Vec<Group>>,
    /// The torque of each link's own joint in its lane of the last group, zero in the others.
    own: Vec<Group>,
    /// The functionals of the base itself.
    base: Vec<Group>,
    turns: Vec<(f64, f64)>,
}

impl SampleRegressor {
    /// Lays the chosen rows of a tree out in lanes; computes nothing yet.
    pub fn new(tree: &Tree, rows: Rows) -> Self {
        let n = tree.len();
        let first = rows.base_row(n);
        let base_rows: Vec<usize> = if rows.base() {
            (first..first + 6).collect()
        } else {
            vec![]
        };
        let mut base = vec![Group::EMPTY; base_rows.len().div_ceil(LANES)];
        for lane in 0..base_rows.len() {
            base[0].set(lane, &Functional::of_base(lane));
        }
        let lists = tree.links().iter().map(|link| {
            let own: &[usize] = if rows.torque() { &link.ancestors } else { &[] };
            base_rows.iter().chain(own).copied().collect::<Vec<_>>()
        });
        let rows_of_links: Vec<Vec<usize>> = lists.collect();
        let groups = rows_of_links
            .iter()
            .map(|list| vec![Group::EMPTY; list.len().div_ceil(LANES)])
            .collect();
        let mut own = vec![Group::EMPTY; n];
        if rows.torque() {
            for ((link, list), group) in tree.links().iter().zip(&rows_of_links).zip(&mut own) {
                let lane = (list.len() - 1) % LANES;
                group.set(lane, &Functional::of_joint(link.revolute, link.axis));
            }
        }
        let consecutive = rows.count(n) <= LANES
            && rows_of_links
                .iter()
                .all(|list| list.iter().enumerate().all(|(k, &row)| k == row));
        Self {
            set: InstructionSet::detect(),
            consecutive,
            own,
            motions: vec![LinkMotion::rest(); n],
            rows: rows_of_links,
            groups,
            base,
            turns: vec![(0.0, 1.0); n.next_multiple_of(LANES)],
        }
    }

    /// Regressor of one sample into `matrix` ([`Rows::count`] x 10n), every entry written; `state` is
    /// q, q̇, q̈ with n values each.
    ///
    /// Columns follow the project's parameter order link by link; rows are N·m (N for sliding joints
    /// and forces) per unit of the parameter.
    pub fn fill(&mut self, tree: &Tree, state: [&[f64]; 3], matrix: &mut DMatrix<f64>) {
        matrix.as_mut_slice().fill(0.0);
        let set = self.set;
        let kernel = SampleKernel {
            memory: self,
            tree,
            state,
            matrix,
        };
        instructions::run(kernel, set);
    }
}

struct SampleKernel<'a> {
    memory: &'a mut SampleRegressor,
    tree: &'a Tree,
    state: [&'a [f64]; 3],
    matrix: &'a mut DMatrix<f64>,
}

impl SampleKernel<'_> {
    #[inline(always)]
    fn turns<L: Lanes>(&mut self) {
        let q = self.state[0];
        for start in (0..q.len()).step_by(LANES) {
            let (sine, cosine) = L::load(q, start).sin_cos();
            let (sine, cosine) = (sine.to_array(), cosine.to_array());
            for lane in 0..LANES {
                self.memory.turns[start + lane] = (sine[lane], cosine[lane]);
            }
        }
    }

    #[inline(always)]
    fn write<L: Lanes>(&mut self, rows: &[usize], link: usize, block: &[L; 10]) {
        let height = self.matrix.nrows();
        let entries = &mut self.matrix.as_mut_slice()[10 * link * height..][..10 * height];
        for (k, lanes) in block.iter().enumerate() {
            let from = k * height;
            // Whole registers: lanes behind the list are zero, and what falls into the next column is
            // overwritten by it.
            if self.memory.consecutive && from + LANES <= entries.len() {
                lanes.store(entries, from);
                continue;
            }
            let column = &mut entries[from..from + height];
            for (value, &row) in lanes.to_array().iter().zip(rows) {
                column[row] = *value;
            }
        }
    }
}

impl Kernel for SampleKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self) {
        self.turns::<L>();
        let (tree, [q, dq, ddq]) = (self.tree, self.state);
        let gravity = base_acceleration(tree);
        for (j, link) in tree.links().iter().enumerate() {
            let state = JointState {
                q: q[j],
                turn: self.memory.turns[j],
                dq: dq[j],
                ddq: ddq[j],
            };
            let parent = link.parent.map(|p| &self.memory.motions[p]);
            let motion = advance(link, parent, gravity, state);
            self.memory.motions[j] = motion;
            let columns = BodyColumns::new(&motion).spread::<L>();
            let turn = Mat3::<L>::constant(motion.turn.0);
            let offset = Vec3::<L>::constant(motion.offset.0);
            let rows = std::mem::take(&mut self.memory.rows[j]);
            let mut groups = std::mem::take(&mut self.memory.groups[j]);
            for (g, group) in groups.iter_mut().enumerate() {
                let inherited = match link.parent {
                    Some(p) => self.memory.groups[p].get(g),
                    None => self.memory.base.get(g),
                };
                let mut functional = inherited
                    .unwrap_or(&Group::EMPTY)
                    .load::<L>()
                    .carried(&turn, offset);
                let end = rows.len().min((g + 1) * LANES);
                if end == rows.len() {
                    // The lane of the joint itself is empty so far: what it inherits is zero.
                    let own = self.memory.own[j].load::<L>();
                    functional.angular += own.angular;
                    functional.linear += own.linear;
                }
                group.store(&functional);
                self.write(&rows[g * LANES..end], j, &columns.row(&functional));
            }
            self.memory.rows[j] = rows;
            self.memory.groups[j] = groups;
        }
    }
}
