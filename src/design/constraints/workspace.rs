//! Workspace constraints along a motion: half-spaces for points, speeds of points, clearances between bodies.
//!
//! ```text
//! n·p(q) − offset                    half-space, m
//! 1 − |J(q) q̇|² / v_max²             speed of a point
//! |a(q) − b(q)| − r_a − r_b − d      clearance of two capsules with nearest axis points a, b, m
//! ```
//!
//! Each has its gradient from the point Jacobian `∂p/∂q_j = z_j × (p − o_j)` (z_j for a sliding joint).

use nalgebra::{Isometry3, Matrix3xX, Point3, Vector3};

use crate::design::trajectory::motion::Motion;
use crate::robot::tree::{JointKind, Tree};

/// The axis of a joint in the base frame.
struct Axis {
    direction: Vector3<f64>,
    /// m.
    origin: Vector3<f64>,
}

/// A point that is fixed to a link, or to the base.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// Name of the link or frame.
    pub name: String,
    /// Joint that carries the link; `None` for the base.
    pub link: Option<usize>,
    /// m, in the link's frame.
    pub point: Point3<f64>,
}

/// A segment with a radius, fixed to a link; a sphere where its ends coincide.
#[derive(Debug, Clone, PartialEq)]
pub struct Capsule {
    /// Joint that carries the link; `None` for the base.
    pub link: Option<usize>,
    /// Both ends of the segment in the link's frame, m.
    pub ends: [Point3<f64>; 2],
    /// m.
    pub radius: f64,
}

/// A Cartesian limit; every one has one row per sample, nonnegative where it holds.
#[derive(Debug, Clone, PartialEq)]
pub enum Rule {
    /// normal·p >= offset.
    Halfspace {
        /// What it is part of.
        label: String,
        /// The point p.
        place: Place,
        /// Unit vector in the base frame.
        normal: Vector3<f64>,
        /// m.
        offset: f64,
    },
    /// The speed of a point in the base frame is limited.
    Speed {
        /// The point.
        place: Place,
        /// m/s.
        limit: f64,
    },
    /// Bodies of two links keep a distance.
    Clearance {
        /// Names of the links.
        names: [String; 2],
        /// Shapes of either link.
        shapes: [Vec<Capsule>; 2],
        /// m.
        distance: f64,
    },
}

impl Rule {
    /// The name of its rows.
    pub fn name(&self) -> String {
        match self {
            Self::Halfspace { label, place, .. } => format!("{label} of {}", place.name),
            Self::Speed { place, .. } => format!("speed of {}", place.name),
            Self::Clearance { names, .. } => format!("clearance of {} and {}", names[0], names[1]),
        }
    }

    /// What the value is measured against: an offset, a speed, a distance.
    pub fn limit(&self) -> f64 {
        match self {
            Self::Halfspace { offset, .. } => *offset,
            Self::Speed { limit, .. } => *limit,
            Self::Clearance { distance, .. } => *distance,
        }
    }

    /// Unit of its margin; speeds are measured as a share of their limit.
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Speed { .. } => "1",
            _ => "m",
        }
    }

    /// Value at one sample, and its gradient with respect to q and q̇ where `slopes` is given.
    fn evaluate(&self, pose: &Pose<'_>, slopes: Option<[&mut [f64]; 2]>) -> f64 {
        match self {
            Self::Halfspace {
                place,
                normal,
                offset,
                ..
            } => {
                let p = pose.point(place.link, &place.point);
                if let Some([by_q, _]) = slopes {
                    pose.add_slopes(place.link, &p, normal, by_q);
                }
                normal.dot(&p.coords) - offset
            }
            Self::Speed { place, limit } => pose.speed(place, *limit, slopes),
            Self::Clearance {
                shapes, distance, ..
            } => pose.clearance(shapes, slopes) - distance,
        }
    }
}

/// The robot at one sample.
struct Pose<'a> {
    tree: &'a Tree,
    links: Vec<Isometry3<f64>>,
    dq: Vec<f64>,
}

impl Pose<'_> {
    fn point(&self, link: Option<usize>, local: &Point3<f64>) -> Point3<f64> {
        link.map_or(*local, |k| self.links[k] * local)
    }

    /// Axis of joint j and a point on it, in the base frame.
    fn axis(&self, j: usize) -> Axis {
        let pose = &self.links[j];
        Axis {
            direction: pose.rotation * self.tree.joints()[j].axis,
            origin: pose.translation.vector,
        }
    }

    /// ∂p/∂q_j.
    fn column(&self, j: usize, p: &Point3<f64>) -> Vector3<f64> {
        let axis = self.axis(j);
        match self.tree.joints()[j].kind {
            JointKind::Revolute => axis.direction.cross(&(p.coords - axis.origin)),
            JointKind::Prismatic => axis.direction,
        }
    }

    fn moved_by(&self, link: Option<usize>) -> impl Iterator<Item = usize> + '_ {
        (0..self.tree.len()).filter(move |&j| link.is_some_and(|k| self.tree.moves(j, k)))
    }

    /// Adds `∂(direction·p)/∂q`.
    fn add_slopes(
        &self,
        link: Option<usize>,
        p: &Point3<f64>,
        direction: &Vector3<f64>,
        by_q: &mut [f64],
    ) {
        for j in self.moved_by(link) {
            by_q[j] += direction.dot(&self.column(j, p));
        }
    }

    fn speed(&self, place: &Place, limit: f64, slopes: Option<[&mut [f64]; 2]>) -> f64 {
        let p = self.point(place.link, &place.point);
        let n = self.tree.len();
        let mut jacobian = Matrix3xX::zeros(n);
        for j in self.moved_by(place.link) {
            jacobian.set_column(j, &self.column(j, &p));
        }
        let velocity = (0..n).fold(Vector3::zeros(), |v, j| v + jacobian.column(j) * self.dq[j]);
        if let Some([by_q, by_dq]) = slopes {
            let factor = -2.0 / (limit * limit);
            for j in self.moved_by(place.link) {
                by_dq[j] += factor * velocity.dot(&jacobian.column(j));
                let change = self.velocity_change(place, &p, &jacobian, j);
                by_q[j] += factor * velocity.dot(&change);
            }
        }
        1.0 - velocity.norm_squared() / (limit * limit)
    }

    /// `∂(J q̇)/∂q_j`: a turn about joint j carries axes and lever arms of the joints behind it, and the
    /// point itself.
    fn velocity_change(
        &self,
        place: &Place,
        p: &Point3<f64>,
        jacobian: &Matrix3xX<f64>,
        j: usize,
    ) -> Vector3<f64> {
        let axis = self.axis(j).direction;
        let turns = |k: usize| self.tree.joints()[k].kind == JointKind::Revolute;
        let mut change = Vector3::zeros();
        for k in self.moved_by(place.link) {
            let rate = self.dq[k];
            if self.tree.moves(j, k) {
                // Joint k and the point turn together about joint j, or slide together.
                if turns(j) {
                    change += axis.cross(&jacobian.column(k)) * rate;
                }
            } else if turns(k) {
                // Joint k comes before j: only the point moves.
                change += self.axis(k).direction.cross(&self.column(j, p)) * rate;
            }
        }
        change
    }

    fn clearance(&self, shapes: &[Vec<Capsule>; 2], slopes: Option<[&mut [f64]; 2]>) -> f64 {
        let mut least = (f64::INFINITY, None);
        for a in &shapes[0] {
            for b in &shapes[1] {
                let of = |c: &Capsule| c.ends.map(|end| self.point(c.link, &end));
                let [p, q] = nearest(of(a), of(b));
                let gap = (p - q).norm() - a.radius - b.radius;
                if gap < least.0 {
                    least = (gap, Some((a.link, b.link, p, q)));
                }
            }
        }
        if let (Some([by_q, _]), Some((on_a, on_b, p, q))) = (slopes, least.1) {
            let apart = p - q;
            let distance = apart.norm();
            if distance > 0.0 {
                let direction = apart / distance;
                self.add_slopes(on_a, &p, &direction, by_q);
                self.add_slopes(on_b, &q, &-direction, by_q);
            }
        }
        least.0
    }
}

/// The nearest points of two segments (Ericson 2005, section 5.1.9).
fn nearest(a: [Point3<f64>; 2], b: [Point3<f64>; 2]) -> [Point3<f64>; 2] {
    let (u, v, w) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let (uu, vv, uv) = (u.norm_squared(), v.norm_squared(), u.dot(&v));
    let (uw, vw) = (u.dot(&w), v.dot(&w));
    let share = |numerator: f64, denominator: f64| {
        if denominator > 0.0 {
            (numerator / denominator).clamp(0.0, 1.0)
        } else {
            0.0
        }
    };
    let determinant = uu * vv - uv * uv;
    let parallel = determinant <= f64::EPSILON * uu * vv;
    let mut s = if parallel {
        0.0
    } else {
        share(uv * vw - uw * vv, determinant)
    };
    let t = share(uv * s + vw, vv);
    s = share(uv * t - uw, uu);
    [a[0] + u * s, b[0] + v * t]
}

/// The Cartesian rows of a design.
#[derive(Debug)]
pub struct Workspace<'m> {
    /// The robot whose points they are of.
    pub tree: &'m Tree,
    /// In the order of their rows.
    pub rules: Vec<Rule>,
}

impl Workspace<'_> {
    fn pose(&self, motion: &Motion, sample: usize) -> Pose<'_> {
        let of = |order: usize| motion.values[order].iter().map(|s| s[sample]).collect();
        let q: Vec<f64> = of(0);
        Pose {
            tree: self.tree,
            links: self.tree.forward_kinematics(&q),
            dq: of(1),
        }
    }

    /// Values `[rule][sample]`.
    pub fn values(&self, motion: &Motion) -> Vec<Vec<f64>> {
        let mut values = vec![Vec::with_capacity(motion.len()); self.rules.len()];
        if self.rules.is_empty() {
            return values;
        }
        for k in 0..motion.len() {
            let pose = self.pose(motion, k);
            for (series, rule) in values.iter_mut().zip(&self.rules) {
                series.push(rule.evaluate(&pose, None));
            }
        }
        values
    }

    /// Gradients with respect to q and q̇: `[rule][order][joint][sample]`.
    pub fn slopes(&self, motion: &Motion) -> Vec<[Vec<Vec<f64>>; 2]> {
        let (n, samples) = (self.tree.len(), motion.len());
        let empty = || std::array::from_fn(|_| vec![vec![0.0; samples]; n]);
        let mut all: Vec<[Vec<Vec<f64>>; 2]> = self.rules.iter().map(|_| empty()).collect();
        if self.rules.is_empty() {
            return all;
        }
        for k in 0..samples {
            let pose = self.pose(motion, k);
            for (slopes, rule) in all.iter_mut().zip(&self.rules) {
                let (mut by_q, mut by_dq) = (vec![0.0; n], vec![0.0; n]);
                rule.evaluate(&pose, Some([&mut by_q, &mut by_dq]));
                for j in 0..n {
                    slopes[0][j][k] = by_q[j];
                    slopes[1][j][k] = by_dq[j];
                }
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::random::{generator, symmetric, tree, vector};
    use rand_chacha::ChaCha8Rng;

    fn capsule(rng: &mut ChaCha8Rng, link: Option<usize>) -> Capsule {
        Capsule {
            link,
            ends: [0, 1].map(|_| Point3::from(vector(rng, 0.3))),
            radius: 0.02,
        }
    }

    #[test]
    fn invariant_slopes_agree_with_central_differences() {
        let mut rng = generator(11);
        let tree = tree(&mut rng, 5);
        let place = Place {
            name: "tip".into(),
            link: Some(4),
            point: Point3::from(vector(&mut rng, 0.4)),
        };
        let shapes = [
            vec![capsule(&mut rng, None), capsule(&mut rng, Some(0))],
            vec![capsule(&mut rng, Some(4)), capsule(&mut rng, Some(3))],
        ];
        let rules = vec![
            Rule::Halfspace {
                label: "half-space".into(),
                place: place.clone(),
                normal: vector(&mut rng, 1.0).normalize(),
                offset: 0.1,
            },
            Rule::Speed { place, limit: 1.5 },
            Rule::Clearance {
                names: ["a".into(), "b".into()],
                shapes,
                distance: 0.05,
            },
        ];
        let workspace = Workspace { tree: &tree, rules };
        let at = |rng: &mut ChaCha8Rng| (0..5).map(|_| vec![symmetric(rng, 2.0)]).collect();
        let motion = Motion::of_values([at(&mut rng), at(&mut rng), at(&mut rng)]);
        let slopes = workspace.slopes(&motion);
        let h = 1e-6;
        for order in 0..2 {
            for j in 0..5 {
                let mut moved = [motion.clone(), motion.clone()];
                moved[0].values[order][j][0] += h;
                moved[1].values[order][j][0] -= h;
                let [after, before] = moved.map(|m| workspace.values(&m));
                for r in 0..3 {
                    let difference = (after[r][0] - before[r][0]) / (2.0 * h);
                    // Rounding 1e-16 / h, and h² times third derivatives of size ten.
                    let exact = slopes[r][order][j][0];
                    assert!((difference - exact).abs() < 1e-8, "{r} {order} {j}");
                }
            }
        }
    }

    #[test]
    fn nearest_points_of_segments_are_those_of_a_fine_search() {
        let mut rng = generator(2);
        for _ in 0..50 {
            let mut segment = || [0, 1].map(|_| Point3::from(vector(&mut rng, 1.0)));
            let (a, b) = (segment(), segment());
            let [p, q] = nearest(a, b);
            let count = 200;
            let along =
                |s: [Point3<f64>; 2], k: usize| s[0] + (s[1] - s[0]) * (k as f64 / count as f64);
            let mut least = f64::INFINITY;
            for i in 0..=count {
                for j in 0..=count {
                    least = least.min((along(a, i) - along(b, j)).norm());
                }
            }
            // Half a step of each segment, of length 3.5 at most, to both sides.
            let found = (p - q).norm();
            assert!(found <= least + 1e-12 && least - found < 3.5 / count as f64);
        }
    }
}
