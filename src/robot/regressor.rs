//! The regressors: torque and base reaction are linear in the inertial parameters.
//!
//! `τ = Y(q, q̇, q̈) π` (n x 10n) and `w = Y_b(q, q̇, q̈) π` (6 x 10n; force and moment of the base on
//! the first link, about the origin of the base frame and in its axes).
//!
//! A row is a linear functional (w, v) of a body's load, `w·n + v·f` about the body's origin: the
//! joint's axis for a torque, a unit vector for a base reaction. It travels outward with the links,
//! `v ← E (v + w × r)`, `w ← E w`, and on link j with ω, ω̇, d it meets the body's ten columns:
//!
//! ```text
//! m    v·d
//! m c  Bᵀ v + d × w,           B = [ω̇×] + [ω×]²
//! I    w·(I ω̇) + (w × ω)·(I ω), entry by entry
//! ```
//!
//! (the linear form of Atkeson, An and Hollerbach 1986, eqs 6 to 9, projected before it is propagated).

use crate::linalg::lanes::scalar::Scalar;
use crate::robot::motion::{JointState, LinkMotion, advance, base_acceleration};
use crate::robot::tree::Tree;
use crate::robot::vector::{Mat3, Vec3};

/// What is measured, and so which rows the regressor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rows {
    /// Joint torques: n rows.
    Torque,
    /// Base reaction: 6 rows, force then moment.
    Base,
    /// Joint torques, then base reaction: n + 6 rows.
    Both,
}

impl Rows {
    /// Number of rows for a robot of n joints.
    pub fn count(self, n: usize) -> usize {
        match self {
            Self::Torque => n,
            Self::Base => 6,
            Self::Both => n + 6,
        }
    }

    pub(crate) fn torque(self) -> bool {
        self != Self::Base
    }

    pub(crate) fn base(self) -> bool {
        self != Self::Torque
    }

    /// Row of the first component of the base reaction.
    pub(crate) fn base_row(self, n: usize) -> usize {
        if self == Self::Both { n } else { 0 }
    }
}

/// A linear functional of a load: `angular·moment + linear·force`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Functional<T> {
    pub angular: Vec3<T>,
    pub linear: Vec3<T>,
}

impl<T: Scalar> Functional<T> {
    pub fn zero() -> Self {
        Self {
            angular: Vec3::zero(),
            linear: Vec3::zero(),
        }
    }

    /// The torque of the joint itself, in its link's frame.
    #[inline(always)]
    pub fn of_joint(revolute: bool, axis: [f64; 3]) -> Self {
        let axis = Vec3::constant(axis);
        if revolute {
            Self {
                angular: axis,
                linear: Vec3::zero(),
            }
        } else {
            Self {
                angular: Vec3::zero(),
                linear: axis,
            }
        }
    }

    /// Component k of the base reaction, in the base frame: forces 0 to 2, moments 3 to 5.
    pub fn of_base(k: usize) -> Self {
        let mut unit = [0.0; 3];
        unit[k % 3] = 1.0;
        Self::of_joint(k >= 3, unit)
    }

    /// The same functional about the origin of the next link.
    #[inline(always)]
    pub fn carried(&self, turn: &Mat3<T>, offset: Vec3<T>) -> Self {
        Self {
            angular: turn.times(self.angular),
            linear: turn.times(self.linear + self.angular.cross(offset)),
        }
    }
}

/// Columns of one body: the parts of its load that do not depend on the functional.
pub(crate) struct BodyColumns<T> {
    /// Bᵀ, from first moment to force, transposed.
    force_of_moment: Mat3<T>,
    /// Rows: the six inertia entries; columns: components of the moment.
    moment_of_inertia: [Vec3<T>; 6],
    acceleration: Vec3<T>,
}

impl BodyColumns<f64> {
    /// The same body in every lane.
    #[inline(always)]
    pub fn spread<T: Scalar>(&self) -> BodyColumns<T> {
        let m = &self.moment_of_inertia;
        BodyColumns {
            force_of_moment: Mat3::constant(self.force_of_moment.0),
            moment_of_inertia: [
                Vec3::constant(m[0].0),
                Vec3::constant(m[1].0),
                Vec3::constant(m[2].0),
                Vec3::constant(m[3].0),
                Vec3::constant(m[4].0),
                Vec3::constant(m[5].0),
            ],
            acceleration: Vec3::constant(self.acceleration.0),
        }
    }
}

impl<T: Scalar> BodyColumns<T> {
    #[inline(always)]
    pub fn new(motion: &LinkMotion<T>) -> Self {
        let [x, y, z] = motion.spin.0;
        let [ax, ay, az] = motion.spin_rate.0;
        let (xx, yy, zz) = (x * x, y * y, z * z);
        let (xy, xz, yz) = (x * y, x * z, y * z);
        let force_of_moment = Mat3([
            [-(yy + zz), xy + az, xz - ay],
            [xy - az, -(xx + zz), yz + ax],
            [xz + ay, yz - ax, -(xx + yy)],
        ]);
        let moment_of_inertia = [
            Vec3([ax, xz, -xy]),
            Vec3([ay - xz, ax + yz, xx - yy]),
            Vec3([-yz, ay, xy]),
            Vec3([az + xy, zz - xx, ax - yz]),
            Vec3([yy - zz, az - xy, ay + xz]),
            Vec3([yz, -xz, az]),
        ];
        Self {
            force_of_moment,
            moment_of_inertia,
            acceleration: motion.acceleration,
        }
    }

    #[inline(always)]
    pub fn row(&self, f: &Functional<T>) -> [T; 10] {
        let (w, v, d) = (f.angular, f.linear, self.acceleration);
        let Vec3([hx, hy, hz]) = self.force_of_moment.times(v) + d.cross(w);
        let [xx, xy, yy, xz, yz, zz] = self.moment_of_inertia;
        [
            v.dot(d),
            hx,
            hy,
            hz,
            xx.dot(w),
            xy.dot(w),
            yy.dot(w),
            xz.dot(w),
            yz.dot(w),
            zz.dot(w),
        ]
    }
}

/// Takes the blocks of a regressor; `put` should be `#[inline(always)]`.
pub trait BlockSink<T> {
    /// Whether the columns of `link` are wanted.
    #[inline(always)]
    fn wants(&self, _link: usize) -> bool {
        true
    }

    /// Whether the row of the torque of `joint` is wanted.
    #[inline(always)]
    fn wants_torque(&self, _joint: usize) -> bool {
        true
    }

    /// The ten columns of `link` in `row`.
    fn put(&mut self, row: usize, link: usize, columns: &[T; 10]);
}

/// Memory of the recursion, reused from sample to sample.
#[derive(Clone, Debug)]
pub struct Regressor<T> {
    rows: Rows,
    motions: Vec<LinkMotion<T>>,
    /// Functionals of each link's ancestors, packed link after link.
    joints: Vec<Functional<T>>,
    /// Functionals of the base reaction on each link.
    base: Vec<[Functional<T>; 6]>,
}

impl<T: Scalar> Regressor<T> {
    /// Memory for the recursion over a tree, for the chosen rows; computes nothing yet.
    pub fn new(tree: &Tree, rows: Rows) -> Self {
        let n = tree.len();
        Self {
            rows,
            motions: vec![LinkMotion::rest(); n],
            joints: vec![Functional::zero(); if rows.torque() { tree.pairs() } else { 0 }],
            base: vec![[Functional::zero(); 6]; if rows.base() { n } else { 0 }],
        }
    }

    /// Gives every block that can be other than zero to `sink`.
    #[inline(always)]
    pub fn blocks(&mut self, tree: &Tree, [q, dq, ddq]: [&[T]; 3], sink: &mut impl BlockSink<T>) {
        let gravity = base_acceleration(tree);
        let first_base_row = self.rows.base_row(tree.len());
        for (j, link) in tree.links().iter().enumerate() {
            let state = JointState::of(link, q[j], dq[j], ddq[j]);
            let parent = link.parent.map(|p| &self.motions[p]);
            let motion = advance(link, parent, gravity, state);
            let columns = sink.wants(j).then(|| BodyColumns::new(&motion));
            if self.rows.torque() {
                let first = link.own + 1 - link.ancestors.len();
                if let Some(p) = link.parent {
                    let inherited = tree.links()[p].own + 1 - (link.ancestors.len() - 1);
                    let passed_on = 0..link.ancestors.len() - 1;
                    for k in passed_on.filter(|&k| sink.wants_torque(link.ancestors[k])) {
                        self.joints[first + k] =
                            self.joints[inherited + k].carried(&motion.turn, motion.offset);
                    }
                }
                self.joints[link.own] = Functional::of_joint(link.revolute, link.axis);
                if let Some(columns) = &columns {
                    for (k, &row) in link.ancestors.iter().enumerate() {
                        if sink.wants_torque(row) {
                            sink.put(row, j, &columns.row(&self.joints[first + k]));
                        }
                    }
                }
            }
            if self.rows.base() {
                for k in 0..6 {
                    let at_parent = match link.parent {
                        Some(p) => self.base[p][k],
                        None => Functional::of_base(k),
                    };
                    self.base[j][k] = at_parent.carried(&motion.turn, motion.offset);
                    if let Some(columns) = &columns {
                        sink.put(first_base_row + k, j, &columns.row(&self.base[j][k]));
                    }
                }
            }
            self.motions[j] = motion;
        }
    }
}
