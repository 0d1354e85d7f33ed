//! Vectors and matrices of three rows over any [`Scalar`]: the algebra of the recursions.
//!
//! Entries are written out and closures avoided: a closure is a function of its own, without the
//! instruction set of the kernel around it, and lanes that cross it leave their registers.

use crate::linalg::lanes::scalar::Scalar;
use std::ops::{Add, AddAssign, Neg, Sub};

/// A vector in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vec3<T>(pub [T; 3]);

impl<T: Scalar> Vec3<T> {
    #[inline(always)]
    pub fn constant(v: [f64; 3]) -> Self {
        Self([T::constant(v[0]), T::constant(v[1]), T::constant(v[2])])
    }

    #[inline(always)]
    pub fn zero() -> Self {
        Self::constant([0.0; 3])
    }

    #[inline(always)]
    pub fn dot(self, o: Self) -> T {
        let ([a, b, c], [x, y, z]) = (self.0, o.0);
        a.mul_add(x, b.mul_add(y, c * z))
    }

    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, o.0);
        Self([
            b.mul_add(z, -(c * y)),
            c.mul_add(x, -(a * z)),
            a.mul_add(y, -(b * x)),
        ])
    }

    #[inline(always)]
    pub fn scale(self, s: T) -> Self {
        let [x, y, z] = self.0;
        Self([x * s, y * s, z * s])
    }

    /// `self + s·direction`.
    #[inline(always)]
    pub fn plus_scaled(self, s: T, direction: Self) -> Self {
        let ([x, y, z], [a, b, c]) = (self.0, direction.0);
        Self([s.mul_add(a, x), s.mul_add(b, y), s.mul_add(c, z)])
    }
}

impl<T: Scalar> Add for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, o.0);
        Self([a + x, b + y, c + z])
    }
}

impl<T: Scalar> Sub for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, o.0);
        Self([a - x, b - y, c - z])
    }
}

impl<T: Scalar> Neg for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        let [x, y, z] = self.0;
        Self([-x, -y, -z])
    }
}

impl<T: Scalar> AddAssign for Vec3<T> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

/// A 3 x 3 matrix by rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mat3<T>(pub [[T; 3]; 3]);

impl<T: Scalar> Mat3<T> {
    #[inline(always)]
    pub fn constant(m: [[f64; 3]; 3]) -> Self {
        Self([
            Vec3::constant(m[0]).0,
            Vec3::constant(m[1]).0,
            Vec3::constant(m[2]).0,
        ])
    }

    /// `M v`.
    #[inline(always)]
    pub fn times(&self, v: Vec3<T>) -> Vec3<T> {
        let [a, b, c] = self.0;
        Vec3([Vec3(a).dot(v), Vec3(b).dot(v), Vec3(c).dot(v)])
    }

    /// `Mᵀ v`.
    #[inline(always)]
    pub fn transpose_times(&self, v: Vec3<T>) -> Vec3<T> {
        let [a, b, c] = self.0;
        let [x, y, z] = v.0;
        Vec3([
            a[0].mul_add(x, b[0].mul_add(y, c[0] * z)),
            a[1].mul_add(x, b[1].mul_add(y, c[1] * z)),
            a[2].mul_add(x, b[2].mul_add(y, c[2] * z)),
        ])
    }

    /// The symmetric matrix of the six entries xx, xy, yy, xz, yz, zz.
    #[inline(always)]
    pub fn symmetric([xx, xy, yy, xz, yz, zz]: [T; 6]) -> Self {
        Self([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    }
}
