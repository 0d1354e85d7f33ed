//! Random robots and states: for tests, benchmarks, the generic states of base parameters, and trials.

use crate::robot::inertia::Inertia;
use crate::robot::tree::{Joint, JointKind, Limits, Tree};
use nalgebra::{Matrix4, Rotation3, Vector3, Vector4};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The generator of the project: the same numbers for a seed on every machine.
pub fn generator(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// Uniform in [−half_range, half_range].
pub fn symmetric(rng: &mut ChaCha8Rng, half_range: f64) -> f64 {
    half_range * (2.0 * rng.random::<f64>() - 1.0)
}

/// Uniform in [low, high).
pub fn between(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.random::<f64>()
}

/// One of 0 to count − 1.
pub fn index(rng: &mut ChaCha8Rng, count: usize) -> usize {
    (rng.random::<f64>() * count as f64) as usize
}

/// A vector with components uniform in [−half_range, half_range].
pub fn vector(rng: &mut ChaCha8Rng, half_range: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| symmetric(rng, half_range))
}

/// A possible body: a handful of point masses within 0.3 m, 1 to 5 kg in all.
pub fn body(rng: &mut ChaCha8Rng) -> Inertia {
    let mass = 1.0 + 4.0 * rng.random::<f64>();
    body_about(rng, mass, Vector3::zeros(), 0.3)
}

/// A possible body: a handful of point masses within `half_range` (m) of a centre.
pub fn body_about(
    rng: &mut ChaCha8Rng,
    mass: f64,
    centre: Vector3<f64>,
    half_range: f64,
) -> Inertia {
    const POINTS: usize = 6;
    let mut pseudo = Matrix4::zeros();
    for _ in 0..POINTS {
        let p = centre + vector(rng, half_range);
        let homogeneous = Vector4::new(p.x, p.y, p.z, 1.0);
        pseudo += homogeneous * homogeneous.transpose() * (mass / POINTS as f64);
    }
    Inertia::from_pseudo_inertia(&pseudo)
}

/// A tree of n joints: one in five slides, one in four starts a branch, axes and placements tilted.
pub fn tree(rng: &mut ChaCha8Rng, n: usize) -> Tree {
    let mut joints = Vec::with_capacity(n);
    for k in 0..n {
        let parent = match k {
            0 => None,
            _ if rng.random::<f64>() < 0.25 => Some(index(rng, k)),
            _ => Some(k - 1),
        };
        let slides = rng.random::<f64>() < 0.2;
        let axis = loop {
            let candidate = vector(rng, 1.0);
            if candidate.norm() > 0.1 {
                break candidate;
            }
        };
        joints.push(Joint {
            name: format!("joint{}", k + 1),
            link: format!("link{}", k + 1),
            parent,
            kind: if slides {
                JointKind::Prismatic
            } else {
                JointKind::Revolute
            },
            axis,
            rotation: Rotation3::new(vector(rng, 2.0)),
            translation: vector(rng, 0.5),
            limits: Limits::default(),
            inertia: body(rng),
        });
    }
    Tree::new("random", "base", joints).with_gravity(vector(rng, 12.0).into())
}
