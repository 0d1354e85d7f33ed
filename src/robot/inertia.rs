//! The inertial parameters of a rigid body, in the one order that the whole project uses:
//!
//! `π = (m, m·cx, m·cy, m·cz, Ixx, Ixy, Iyy, Ixz, Iyz, Izz)`
//!
//! mass in kg, first moments in kg·m, inertia in kg·m² about the ORIGIN of the frame (not about the
//! centre of mass), axes of that frame. This is the order of Pinocchio's `toDynamicParameters`.

use nalgebra::{Matrix3, Matrix4, Rotation3, Vector3};

/// Parameters of one body.
pub const PER_LINK: usize = 10;

/// Position of each parameter in the order of the project.
pub const QUANTITIES: [&str; PER_LINK] = [
    "m", "mcx", "mcy", "mcz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz",
];

/// Units of the parameters, in the same order.
pub const UNITS: [&str; PER_LINK] = [
    "kg", "kg·m", "kg·m", "kg·m", "kg·m²", "kg·m²", "kg·m²", "kg·m²", "kg·m²", "kg·m²",
];

/// Axes of the entries of the tensor in the order of [`REPORTED`], and their positions among the parameters.
pub const TENSOR: [(usize, usize, usize); 6] = [
    (0, 0, 4),
    (0, 1, 5),
    (0, 2, 7),
    (1, 1, 6),
    (1, 2, 8),
    (2, 2, 9),
];

/// What a body is reported by, with units: mass, centre of mass, tensor about it.
pub const REPORTED: [(&str, &str); PER_LINK] = [
    ("mass", "kg"),
    ("com_x", "m"),
    ("com_y", "m"),
    ("com_z", "m"),
    ("inertia_xx", "kg·m²"),
    ("inertia_xy", "kg·m²"),
    ("inertia_xz", "kg·m²"),
    ("inertia_yy", "kg·m²"),
    ("inertia_yz", "kg·m²"),
    ("inertia_zz", "kg·m²"),
];

/// Rows and columns of the six inertia entries within π, from position 4 on.
const INERTIA_ENTRIES: [(usize, usize); 6] = [(0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)];

/// The ten inertial parameters of a body about the origin of its frame.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Inertia(pub [f64; PER_LINK]);

/// The same body as engineers write it: mass, centre of mass, inertia about the centre of mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CentralInertia {
    /// kg
    pub mass: f64,
    /// m, in the frame of the body
    pub centre: Vector3<f64>,
    /// kg·m², about the centre of mass, axes of the frame of the body
    pub tensor: Matrix3<f64>,
}

impl Inertia {
    /// Mass, kg.
    pub fn mass(&self) -> f64 {
        self.0[0]
    }

    /// First moment m·c, kg·m.
    pub fn first_moment(&self) -> Vector3<f64> {
        Vector3::new(self.0[1], self.0[2], self.0[3])
    }

    /// Inertia tensor about the origin, kg·m².
    pub fn tensor(&self) -> Matrix3<f64> {
        let mut tensor = Matrix3::zeros();
        for (value, (row, column)) in self.0[4..].iter().zip(INERTIA_ENTRIES) {
            tensor[(row, column)] = *value;
            tensor[(column, row)] = *value;
        }
        tensor
    }

    /// From mass, first moment and inertia about the origin.
    pub fn from_moments(mass: f64, first: Vector3<f64>, tensor: &Matrix3<f64>) -> Self {
        let mut p = [
            mass, first.x, first.y, first.z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
        ];
        for (slot, (row, column)) in p[4..].iter_mut().zip(INERTIA_ENTRIES) {
            *slot = tensor[(row, column)];
        }
        Self(p)
    }

    /// Steiner: `I_origin = I_centre + m (cᵀc·1 − c cᵀ)`.
    pub fn from_central(body: &CentralInertia) -> Self {
        let c = body.centre;
        let steiner = (Matrix3::identity() * c.norm_squared() - c * c.transpose()) * body.mass;
        Self::from_moments(body.mass, c * body.mass, &(body.tensor + steiner))
    }

    /// Mass, centre of mass and central tensor; `None` where the mass is zero.
    pub fn central(&self) -> Option<CentralInertia> {
        let mass = self.mass();
        if mass == 0.0 {
            return None;
        }
        let centre = self.first_moment() / mass;
        let steiner =
            (Matrix3::identity() * centre.norm_squared() - centre * centre.transpose()) * mass;
        Some(CentralInertia {
            mass,
            centre,
            tensor: self.tensor() - steiner,
        })
    }

    /// The same body in a frame A, where the body's own frame B stands at `translation` with
    /// `rotation` (vectors of B turned into A).
    pub fn seen_from(&self, rotation: &Rotation3<f64>, translation: &Vector3<f64>) -> Self {
        let r = rotation.matrix();
        let (t, h) = (translation, r * self.first_moment());
        let mass = self.mass();
        let cross = (h * t.transpose() + t * h.transpose()) + t * t.transpose() * mass;
        let shift = Matrix3::identity() * cross.trace() - cross;
        let tensor = r * self.tensor() * r.transpose() + shift;
        Self::from_moments(mass, h + t * mass, &tensor)
    }

    /// The pseudo-inertia `J = [Σ h; hᵀ m]`, Σ = ½ tr(I)·1 − I (Wensing, Kim and Slotine 2018,
    /// eq. 12). A body is physically possible exactly if J is positive semidefinite.
    pub fn pseudo_inertia(&self) -> Matrix4<f64> {
        let tensor = self.tensor();
        let second = Matrix3::identity() * (0.5 * tensor.trace()) - tensor;
        let first = self.first_moment();
        let mut j = Matrix4::zeros();
        j.fixed_view_mut::<3, 3>(0, 0).copy_from(&second);
        j.fixed_view_mut::<3, 1>(0, 3).copy_from(&first);
        j.fixed_view_mut::<1, 3>(3, 0).copy_from(&first.transpose());
        j[(3, 3)] = self.mass();
        j
    }

    /// Inverse of [`Inertia::pseudo_inertia`]: `I = tr(Σ)·1 − Σ`.
    pub fn from_pseudo_inertia(j: &Matrix4<f64>) -> Self {
        let second = j.fixed_view::<3, 3>(0, 0).into_owned();
        let tensor = Matrix3::identity() * second.trace() - second;
        Self::from_moments(j[(3, 3)], j.fixed_view::<3, 1>(0, 3).into_owned(), &tensor)
    }

    /// The body made of both.
    pub fn plus(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] + other.0[k]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body() -> CentralInertia {
        CentralInertia {
            mass: 3.5,
            centre: Vector3::new(0.1, -0.2, 0.3),
            tensor: Matrix3::new(0.4, 0.01, -0.02, 0.01, 0.5, 0.03, -0.02, 0.03, 0.6),
        }
    }

    #[test]
    fn invariant_round_trip_through_central_and_pseudo_inertia() {
        let origin = Inertia::from_central(&body());
        let back = origin.central().unwrap();
        assert!((back.tensor - body().tensor).norm() < 1e-14);
        assert!((back.centre - body().centre).norm() < 1e-15);
        let again = Inertia::from_pseudo_inertia(&origin.pseudo_inertia());
        for (k, quantity) in QUANTITIES.iter().enumerate() {
            assert!((again.0[k] - origin.0[k]).abs() < 1e-14, "{quantity}");
        }
    }

    #[test]
    fn matches_closed_form_of_two_point_masses() {
        // Two masses of 1 kg at (±1, 0, 2): Ixx = 8, Iyy = 2·(1 + 4), Izz = 2, mcz = 4.
        let mut sum = Inertia::default();
        for x in [-1.0, 1.0] {
            sum = sum.plus(&Inertia::from_central(&CentralInertia {
                mass: 1.0,
                centre: Vector3::new(x, 0.0, 2.0),
                tensor: Matrix3::zeros(),
            }));
        }
        assert_eq!(sum.0, [2.0, 0.0, 0.0, 4.0, 8.0, 0.0, 10.0, 0.0, 0.0, 2.0]);
    }

    #[test]
    fn invariant_a_moved_frame_keeps_the_central_body() {
        let rotation = Rotation3::from_euler_angles(0.3, -0.7, 1.1);
        let shift = Vector3::new(-0.4, 0.25, 0.9);
        let moved = Inertia::from_central(&body()).seen_from(&rotation, &shift);
        let central = moved.central().unwrap();
        assert!((central.centre - (rotation * body().centre + shift)).norm() < 1e-14);
        let turned = rotation.matrix() * body().tensor * rotation.matrix().transpose();
        assert!((central.tensor - turned).norm() < 1e-13);
    }
}
