//! The outward recursion that every algorithm of this module shares.
//!
//! For link j with parent p, `E` from parent to link coordinates, `r` the link's origin in the parent
//! and `z` the joint's axis (Luh, Walker and Paul 1980; all vectors in the link's own frame):
//!
//! ```text
//! revolute    ω = E ω_p + z q̇      ω̇ = E ω̇_p + z q̈ + (E ω_p) × z q̇     d = E x
//! prismatic   ω = E ω_p            ω̇ = E ω̇_p                            d = E x + 2 (E ω_p) × z q̇ + z q̈
//!             x = d_p + ω̇_p × r + ω_p × (ω_p × r),    d of the base = −gravity
//! ```
//!
//! `d` is the acceleration of the link's origin, gravity taken away.

use crate::linalg::lanes::scalar::Scalar;
use crate::robot::tree::{Link, Tree};
use crate::robot::vector::{Mat3, Vec3};

/// What a link does at one instant (or at eight, in lanes).
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinkMotion<T> {
    /// From parent to link coordinates.
    pub turn: Mat3<T>,
    /// Origin of the link in its parent's frame.
    pub offset: Vec3<T>,
    /// ω
    pub spin: Vec3<T>,
    /// ω̇
    pub spin_rate: Vec3<T>,
    /// d
    pub acceleration: Vec3<T>,
    /// E ω_p
    pub carried_spin: Vec3<T>,
    /// E ω̇_p
    pub carried_spin_rate: Vec3<T>,
}

impl<T: Scalar> LinkMotion<T> {
    pub fn rest() -> Self {
        let zero = Vec3::zero();
        Self {
            turn: Mat3::constant([[0.0; 3]; 3]),
            offset: zero,
            spin: zero,
            spin_rate: zero,
            acceleration: zero,
            carried_spin: zero,
            carried_spin_rate: zero,
        }
    }
}

/// Position, velocity and acceleration of one joint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointState<T> {
    pub q: T,
    /// Sine and cosine of q; not looked at for a sliding joint.
    pub turn: (T, T),
    pub dq: T,
    pub ddq: T,
}

impl<T: Scalar> JointState<T> {
    #[inline(always)]
    pub fn of(link: &Link, q: T, dq: T, ddq: T) -> Self {
        let turn = if link.revolute { q.sin_cos() } else { (q, q) };
        Self { q, turn, dq, ddq }
    }
}

/// Turn and offset of a link at the joint's position.
#[inline(always)]
pub(crate) fn placement<T: Scalar>(link: &Link, state: &JointState<T>) -> (Mat3<T>, Vec3<T>) {
    let offset = Vec3::constant(link.translation);
    if !link.revolute {
        let slid = offset.plus_scaled(state.q, Vec3::constant(link.parent_axis));
        return (Mat3::constant(link.constant), slid);
    }
    let (sine, cosine) = state.turn;
    let mut turn = Mat3::constant(link.constant);
    for r in 0..3 {
        for c in 0..3 {
            let even = cosine.mul_add(T::constant(link.cosine[r][c]), turn.0[r][c]);
            turn.0[r][c] = sine.mul_add(T::constant(link.sine[r][c]), even);
        }
    }
    (turn, offset)
}

/// `ω × (ω × x)`.
#[inline(always)]
pub(crate) fn centripetal<T: Scalar>(spin: Vec3<T>, x: Vec3<T>) -> Vec3<T> {
    spin.cross(spin.cross(x))
}

/// One step of the outward recursion; `parent` is `None` on the base.
#[inline(always)]
pub(crate) fn advance<T: Scalar>(
    link: &Link,
    parent: Option<&LinkMotion<T>>,
    base_acceleration: Vec3<T>,
    state: JointState<T>,
) -> LinkMotion<T> {
    let (turn, offset) = placement(link, &state);
    let axis = Vec3::constant(link.axis);
    let (carried_spin, carried_spin_rate, at_offset) = match parent {
        None => (Vec3::zero(), Vec3::zero(), base_acceleration),
        Some(p) => (
            turn.times(p.spin),
            turn.times(p.spin_rate),
            p.acceleration + p.spin_rate.cross(offset) + centripetal(p.spin, offset),
        ),
    };
    let mut motion = LinkMotion {
        turn,
        offset,
        spin: carried_spin,
        spin_rate: carried_spin_rate,
        acceleration: turn.times(at_offset),
        carried_spin,
        carried_spin_rate,
    };
    let across = carried_spin.cross(axis);
    if link.revolute {
        motion.spin = carried_spin.plus_scaled(state.dq, axis);
        motion.spin_rate = carried_spin_rate
            .plus_scaled(state.ddq, axis)
            .plus_scaled(state.dq, across);
    } else {
        motion.acceleration = motion
            .acceleration
            .plus_scaled(state.ddq, axis)
            .plus_scaled(state.dq + state.dq, across);
    }
    motion
}

/// Acceleration that stands for gravity at the base.
#[inline(always)]
pub(crate) fn base_acceleration<T: Scalar>(tree: &Tree) -> Vec3<T> {
    Vec3::constant((-tree.gravity()).into())
}
