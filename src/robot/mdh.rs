//! Reads a robot from a table of modified Denavit-Hartenberg parameters (Khalil and Kleinfinger 1986;
//! Craig 1989): link i stands in link i−1 at `Rot_x(alpha) · Trans_x(a) · Rot_z(theta) · Trans_z(d)`.
//!
//! ```toml
//! name = "arm"
//! [[joint]]
//! name = "a1"            # link, parent: optional names; the default is a chain link1, link2, ...
//! type = "revolute"      # or "prismatic"
//! alpha = 0.0            # rad
//! a = 0.0                # m
//! d = 0.3                # m; a prismatic joint adds its position
//! theta = 0.0            # rad; a revolute joint adds its position
//! lower = -3.0           # lower, upper, velocity, effort: optional limits
//! mass = 12.0            # mass, com, inertia = [xx, xy, xz, yy, yz, zz] about the centre of mass: optional
//! com = [0.0, 0.1, 0.2]
//! inertia = [0.1, 0.0, 0.0, 0.1, 0.0, 0.1]
//! ```

use crate::fault::{Place, nearest};
use crate::robot::assemble::MOST_JOINTS;
use crate::robot::error::{LARGEST_NUMBER, RobotError, RobotErrorKind};
use crate::robot::file;
use crate::robot::inertia::{CentralInertia, Inertia};
use crate::robot::tree::{Joint, JointKind, Limits, Tree};
use nalgebra::{Matrix3, Rotation3, Vector3};
use serde::Deserialize;
use std::path::Path;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    #[serde(default)]
    name: Option<String>,
    joint: Vec<Row>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    name: String,
    link: Option<String>,
    parent: Option<String>,
    #[serde(rename = "type")]
    kind: Option<Kind>,
    #[serde(default)]
    alpha: f64,
    #[serde(default)]
    a: f64,
    #[serde(default)]
    d: f64,
    #[serde(default)]
    theta: f64,
    lower: Option<f64>,
    upper: Option<f64>,
    velocity: Option<f64>,
    effort: Option<f64>,
    #[serde(default)]
    mass: f64,
    #[serde(default)]
    com: [f64; 3],
    #[serde(default)]
    inertia: [f64; 6],
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "snake_case")]
enum Kind {
    Revolute,
    Prismatic,
}

/// Name of the base link of a robot that is given by a table.
const BASE: &str = "base";

/// Reads a table of modified Denavit-Hartenberg parameters into a tree.
pub fn read(path: &Path) -> Result<Tree, RobotError> {
    parse(&file::text(path)?, path)
}

/// Reads the text of a table; `path` is named in errors.
pub fn parse(text: &str, path: &Path) -> Result<Tree, RobotError> {
    let table: Table = toml::from_str(text).map_err(|e| unreadable(&e, text, path))?;
    let fail = |kind| RobotError::new(Place::file(path), kind);
    if table.joint.is_empty() {
        return Err(fail(RobotErrorKind::NoMovingJoint));
    }
    if table.joint.len() > MOST_JOINTS {
        return Err(fail(RobotErrorKind::TooManyJoints {
            found: table.joint.len(),
            limit: MOST_JOINTS,
        }));
    }
    let mut joints: Vec<Joint> = Vec::with_capacity(table.joint.len());
    for (k, row) in table.joint.iter().enumerate() {
        let place = || Place::file(path).key(format!("joint {}", row.name));
        let joint = row
            .joint(k, &joints)
            .map_err(|kind| RobotError::new(place(), kind))?;
        joints.push(joint);
    }
    Ok(Tree::new(
        table.name.unwrap_or_else(|| "robot".to_string()),
        BASE,
        joints,
    ))
}

fn unreadable(e: &toml::de::Error, text: &str, path: &Path) -> RobotError {
    let mut place = Place::file(path);
    if let Some(span) = e.span() {
        let before = &text[..span.start.min(text.len())];
        let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
        place = place.line(before.matches('\n').count() + 1).column(column);
    }
    let reason = e.message().to_string();
    RobotError::new(place, RobotErrorKind::NotMdh { reason })
}

impl Row {
    fn joint(&self, k: usize, before: &[Joint]) -> Result<Joint, RobotErrorKind> {
        let first_line = None;
        if before.iter().any(|j| j.name == self.name) {
            return Err(RobotErrorKind::DuplicateJoint { first_line });
        }
        let link = match &self.link {
            Some(name) => name.clone(),
            None => format!("link{}", k + 1),
        };
        if link == BASE || before.iter().any(|j| j.link == link) {
            return Err(RobotErrorKind::DuplicateLink { first_line });
        }
        self.check_numbers()?;
        let tilt = Rotation3::from_axis_angle(&Vector3::x_axis(), self.alpha);
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), self.theta);
        let rotation = tilt * turn;
        let [xx, xy, xz, yy, yz, zz] = self.inertia;
        Ok(Joint {
            name: self.name.clone(),
            link,
            parent: self.parent_index(before)?,
            kind: match self.kind.unwrap_or(Kind::Revolute) {
                Kind::Revolute => JointKind::Revolute,
                Kind::Prismatic => JointKind::Prismatic,
            },
            axis: Vector3::z(),
            rotation,
            translation: Vector3::x() * self.a + rotation * (Vector3::z() * self.d),
            limits: Limits {
                lower: self.lower,
                upper: self.upper,
                velocity: self.velocity,
                effort: self.effort,
            },
            inertia: Inertia::from_central(&CentralInertia {
                mass: self.mass,
                centre: Vector3::from(self.com),
                tensor: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
            }),
        })
    }

    fn check_numbers(&self) -> Result<(), RobotErrorKind> {
        let geometry = [self.alpha, self.a, self.d, self.theta, self.mass];
        let limits = [self.lower, self.upper, self.velocity, self.effort];
        let bounded = geometry.into_iter().chain(self.com).chain(self.inertia);
        let mut all = bounded.clone().chain(limits.into_iter().flatten());
        if let Some(bad) = all.find(|x| !x.is_finite()) {
            return Err(RobotErrorKind::NotFinite {
                found: bad.to_string(),
            });
        }
        if let Some(bad) = bounded.into_iter().find(|x| x.abs() > LARGEST_NUMBER) {
            return Err(RobotErrorKind::TooLargeNumber {
                found: bad.to_string(),
                limit: LARGEST_NUMBER,
            });
        }
        if self.mass < 0.0 {
            return Err(RobotErrorKind::NegativeMass { found: self.mass });
        }
        match (self.lower, self.upper) {
            (Some(lower), Some(upper)) if lower > upper => {
                Err(RobotErrorKind::LimitsReversed { lower, upper })
            }
            _ => Ok(()),
        }
    }

    fn parent_index(&self, before: &[Joint]) -> Result<Option<usize>, RobotErrorKind> {
        match self.parent.as_deref() {
            None => Ok(before.len().checked_sub(1)),
            Some(BASE) => Ok(None),
            Some(link) => match before.iter().position(|j| j.link == link) {
                Some(p) => Ok(Some(p)),
                None => Err(RobotErrorKind::UnknownLink {
                    found: link.to_string(),
                    nearest: nearest(link, before.iter().map(|j| j.link.as_str())),
                }),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::urdf;

    #[test]
    fn matches_the_same_arm_written_as_urdf() {
        let table = r#"
            [[joint]]
            name = "a"
            d = 0.3
            mass = 2.0
            com = [0.1, 0.0, 0.0]
            inertia = [0.1, 0.0, 0.01, 0.2, 0.0, 0.3]
            [[joint]]
            name = "b"
            type = "prismatic"
            alpha = -1.5707963267948966
            a = 0.4
            theta = 0.5
            mass = 1.0
        "#;
        let (s, c) = (0.5_f64).sin_cos();
        // Rot_x(−90°)·Rot_z(0.5) in roll, pitch, yaw: x axis (c, 0, −s), z axis (0, 1, 0).
        let pitch = s.atan2(c);
        let text = format!(
            r#"<robot name="r"><link name="base"/>
            <link name="link1"><inertial><origin xyz="0.1 0 0"/><mass value="2"/>
            <inertia ixx="0.1" ixy="0" ixz="0.01" iyy="0.2" iyz="0" izz="0.3"/></inertial></link>
            <link name="link2"><inertial><mass value="1"/>
            <inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
            <joint name="a" type="revolute"><parent link="base"/><child link="link1"/>
            <origin xyz="0 0 0.3"/><axis xyz="0 0 1"/></joint>
            <joint name="b" type="prismatic"><parent link="link1"/><child link="link2"/>
            <origin xyz="0.4 0 0" rpy="-1.5707963267948966 {pitch} 0"/><axis xyz="0 0 1"/></joint></robot>"#
        );
        let from_table = parse(table, Path::new("arm.toml")).unwrap();
        let from_urdf = urdf::parse(&text, Path::new("arm.urdf")).unwrap();
        let (a, b) = (&from_table.joints()[1], &from_urdf.joints()[1]);
        assert!((a.translation - b.translation).norm() < 1e-15);
        assert_eq!(a.kind, b.kind);
        assert!((a.rotation.matrix() - b.rotation.matrix()).norm() < 1e-12);
        for (x, y) in from_table.parameters().iter().zip(from_urdf.parameters()) {
            assert!((x - y).abs() < 1e-15);
        }
    }

    #[test]
    fn a_wrong_key_names_its_line() {
        let fault =
            parse("[[joint]]\nname = \"a\"\nbeta = 1\n", Path::new("arm.toml")).unwrap_err();
        assert_eq!(fault.place.line, Some(3));
        assert!(fault.to_string().contains("beta"), "{fault}");
    }
}
