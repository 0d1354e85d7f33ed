//! Vectors and matrices of three rows over any [`Scalar`]: the algebra of the recursions.

use crate::robot::scalar::Scalar;
use std::ops::{Add, AddAssign, Neg, Sub};

/// A vector in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vec3<T>(pub [T; 3]);

impl<T: Scalar> Vec3<T> {
    #[inline(always)]
    pub fn constant(v: [f64; 3]) -> Self {
        Self(v.map(T::constant))
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
        Self(self.0.map(|x| x * s))
    }

    /// `self + s·direction`.
    #[inline(always)]
    pub fn plus_scaled(self, s: T, direction: Self) -> Self {
        Self(std::array::from_fn(|k| {
            s.mul_add(direction.0[k], self.0[k])
        }))
    }
}

impl<T: Scalar> Add for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] + o.0[k]))
    }
}

impl<T: Scalar> Sub for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] - o.0[k]))
    }
}

impl<T: Scalar> Neg for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
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
        Self(m.map(|row| row.map(T::constant)))
    }

    /// `M v`.
    #[inline(always)]
    pub fn times(&self, v: Vec3<T>) -> Vec3<T> {
        Vec3(self.0.map(|row| Vec3(row).dot(v)))
    }

    /// `Mᵀ v`.
    #[inline(always)]
    pub fn transpose_times(&self, v: Vec3<T>) -> Vec3<T> {
        let [a, b, c] = self.0;
        let [x, y, z] = v.0;
        Vec3(std::array::from_fn(|k| {
            a[k].mul_add(x, b[k].mul_add(y, c[k] * z))
        }))
    }

    /// The symmetric matrix of the six entries xx, xy, yy, xz, yz, zz.
    #[inline(always)]
    pub fn symmetric([xx, xy, yy, xz, yz, zz]: [T; 6]) -> Self {
        Self([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    }
}
