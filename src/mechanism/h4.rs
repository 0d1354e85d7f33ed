//! The parallel robot H4: four levers on a fixed base, four rods, a platform ("nacelle") that moves along x, y, z
//! and turns about z (Vivas, Poignet, Marquet, Pierrot and Gautier 2003, section 2, eqs 1 to 8).
//!
//! ```text
//! O A_i = (x, y, z) + (±h cos θ, ±h sin θ ± d, 0)          ends of the rods on the platform
//! O P_i = (±h + R cos α_i, ±d + R sin α_i, 0)              axes of the motors
//! P_i B_i = l (cos q_i cos α_i, cos q_i sin α_i, −sin q_i)  levers;   |A_i B_i| = L
//! ```
//!
//! As a tree: the levers on their motors, and the platform behind three slides and a hinge. The side bars of
//! the "H" turn about the points (0, ±d), so that each is a massless link of its own that turns by θ. Levers
//! weigh nothing: what they add to a motor's inertia is part of that motor's.

use crate::mechanism::condition::{Anchor, Condition};
use crate::mechanism::error::MechanismError;
use crate::mechanism::loops::Mechanism;
use crate::robot::inertia::Inertia;
use crate::robot::tree::{Joint, JointKind, Limits, Tree};
use nalgebra::{Rotation3, Vector3, Vector4};
use std::f64::consts::{FRAC_PI_2, PI};

/// Chains, and coordinates of the platform.
pub const CHAINS: usize = 4;

/// Directions α_i of the levers, rad.
pub const ANGLES: [f64; CHAINS] = [0.0, PI, 3.0 * FRAC_PI_2, 3.0 * FRAC_PI_2];

/// Signs of h and d at the ends of the chains.
const CORNERS: [(f64, f64); CHAINS] = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];

/// Joints of the platform in the tree: three slides, then the hinge.
pub const PLATFORM: [usize; 4] = [4, 5, 6, 7];

/// Position of the motors from which searches begin, rad: levers a little below the horizontal.
const HOME: f64 = 0.5;

/// Side bars in the tree.
const BARS: [usize; 2] = [8, 9];

/// Lengths of an H4, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct H4 {
    /// l, of the levers.
    pub lever: f64,
    /// L, of the rods.
    pub rod: f64,
    /// h, half the length of the side bars.
    pub half_bar: f64,
    /// d, half the distance between the side bars.
    pub half_width: f64,
    /// R, from where the levers would meet the platform at rest to the motors.
    pub radius: f64,
}

impl H4 {
    /// Every length is positive, except that side bars may lie on top of each other (`half_width` = 0).
    ///
    /// # Errors
    /// Names the length that is none.
    pub fn checked(self) -> Result<Self, MechanismError> {
        let lengths = [
            ("lever", self.lever),
            ("rod", self.rod),
            ("half_bar", self.half_bar),
            ("radius", self.radius),
        ];
        let wrong = lengths
            .into_iter()
            .find(|(_, value)| !(*value > 0.0 && value.is_finite()));
        let width = ("half_width", self.half_width);
        let narrow = (!(width.1 >= 0.0 && width.1.is_finite())).then_some(width);
        match wrong.or(narrow) {
            Some((name, value)) => Err(MechanismError::NotALength { name, value }),
            None => Ok(self),
        }
    }

    /// P_i, m.
    fn motor(&self, chain: usize) -> Vector3<f64> {
        let (side, end) = CORNERS[chain];
        let (sin, cos) = ANGLES[chain].sin_cos();
        Vector3::new(
            side * self.half_bar + self.radius * cos,
            end * self.half_width + self.radius * sin,
            0.0,
        )
    }

    /// Motor positions (rad) at a pose (x, y, z in m, θ in rad) of the platform, levers outside of the rods.
    ///
    /// # Errors
    /// A pose that a rod is too short or too long for.
    pub fn inverse(&self, pose: &Vector4<f64>) -> Result<[f64; CHAINS], MechanismError> {
        let mut q = [0.0; CHAINS];
        for (chain, q) in q.iter_mut().enumerate() {
            let (side, end) = CORNERS[chain];
            let (sin, cos) = pose[3].sin_cos();
            let bar = Vector3::new(cos, sin, 0.0) * (side * self.half_bar);
            let platform = pose.xyz() + Vector3::y() * (end * self.half_width) + bar;
            let reach = platform - self.motor(chain);
            let outwards = Vector3::new(ANGLES[chain].cos(), ANGLES[chain].sin(), 0.0);
            // |reach|² + l² − 2 l (u cos q + w sin q) = L²
            let (u, w) = (reach.dot(&outwards), -reach.z);
            let wanted =
                (reach.norm_squared() + self.lever.powi(2) - self.rod.powi(2)) / (2.0 * self.lever);
            let most = u.hypot(w);
            if wanted.abs() > most {
                return Err(MechanismError::OutOfReach {
                    chain: chain + 1,
                    needed: wanted.abs() - most,
                });
            }
            *q = w.atan2(u) - (wanted / most).acos();
        }
        Ok(q)
    }

    /// The pose (x, y, z in m, θ in rad) of the platform at motor positions (rad), from a pose nearby, by
    /// Newton's iteration (Vivas, Poignet, Marquet, Pierrot and Gautier 2003, eq. 9).
    ///
    /// # Errors
    /// Outside of the workspace, and at a singularity.
    pub fn forward(
        &self,
        motors: &[f64; CHAINS],
        near: &Vector4<f64>,
    ) -> Result<Vector4<f64>, MechanismError> {
        let mechanism = self.mechanism()?;
        let mut q = mechanism.home().to_vec();
        q[..CHAINS].copy_from_slice(motors);
        for (&joint, value) in PLATFORM.iter().zip(near.iter()) {
            q[joint] = *value;
        }
        BARS.iter().for_each(|&bar| q[bar] = near[3]);
        mechanism.close(&mut q)?;
        Ok(Vector4::from_fn(|k, _| q[PLATFORM[k]]))
    }

    /// The tree with its loops. The platform is the link `nacelle`; searches begin a rod's length below the
    /// motors.
    ///
    /// # Errors
    /// A length that is none, and lengths with which the platform hangs on no four rods.
    pub fn mechanism(&self) -> Result<Mechanism, MechanismError> {
        self.checked()?;
        let bar_of = |chain: usize| BARS[usize::from(CORNERS[chain].1 < 0.0)];
        let mut conditions: Vec<Condition> = (0..CHAINS)
            .map(|chain| Condition::Rod {
                ends: [
                    Anchor {
                        link: Some(bar_of(chain)),
                        point: Vector3::x() * (CORNERS[chain].0 * self.half_bar),
                    },
                    Anchor {
                        link: Some(chain),
                        point: Vector3::x() * self.lever,
                    },
                ],
                length: self.rod,
            })
            .collect();
        conditions.extend(BARS.map(|bar| Condition::Equal {
            joints: [PLATFORM[3], bar],
        }));
        let passive: Vec<usize> = (PLATFORM[0]..=BARS[1]).collect();
        let mut home = vec![0.0; BARS[1] + 1];
        home[..CHAINS].fill(HOME);
        home[PLATFORM[2]] = -self.rod;
        let weightless: Vec<usize> = (0..=BARS[1]).filter(|&k| k != PLATFORM[3]).collect();
        let mechanism = Mechanism::new(self.tree(), &passive, conditions, home)?;
        Ok(mechanism.with_massless(&weightless))
    }

    fn tree(&self) -> Tree {
        let mut joints: Vec<Joint> = (0..CHAINS).map(|chain| self.lever_joint(chain)).collect();
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let parent = (axis > 0).then(|| PLATFORM[axis - 1]);
            joints.push(Joint {
                name: format!("nacelle_{name}"),
                link: format!("slide_{name}"),
                kind: JointKind::Prismatic,
                axis: Vector3::ith(axis, 1.0),
                ..about_z(parent, Vector3::zeros())
            });
        }
        joints.push(Joint {
            name: "nacelle_theta".to_string(),
            link: "nacelle".to_string(),
            ..about_z(Some(PLATFORM[2]), Vector3::zeros())
        });
        for (bar, end) in [1.0, -1.0].into_iter().enumerate() {
            let at = Vector3::y() * (end * self.half_width);
            joints.push(Joint {
                name: format!("bar{}_theta", bar + 1),
                link: format!("bar{}", bar + 1),
                ..about_z(Some(PLATFORM[2]), at)
            });
        }
        Tree::new("h4", "base", joints)
    }

    /// A lever: x along it, turning from the horizontal down.
    fn lever_joint(&self, chain: usize) -> Joint {
        Joint {
            name: format!("motor{}", chain + 1),
            link: format!("lever{}", chain + 1),
            axis: Vector3::y(),
            rotation: Rotation3::from_axis_angle(&Vector3::z_axis(), ANGLES[chain]),
            ..about_z(None, self.motor(chain))
        }
    }
}

/// A hinge about z without a name.
fn about_z(parent: Option<usize>, translation: Vector3<f64>) -> Joint {
    Joint {
        name: String::new(),
        link: String::new(),
        parent,
        kind: JointKind::Revolute,
        axis: Vector3::z(),
        rotation: Rotation3::identity(),
        translation,
        limits: Limits::default(),
        inertia: Inertia::default(),
    }
}
