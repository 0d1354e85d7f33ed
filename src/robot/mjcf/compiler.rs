//! What holds for the whole model: `<compiler>` and `<option>`.

use crate::robot::error::RobotError;
use crate::robot::mjcf::document::{Document, Id};
use crate::robot::mjcf::settings::Settings;
use crate::robot::mjcf_fault::MjcfFault;
use crate::robot::tree::STANDARD_GRAVITY;
use std::path::PathBuf;

/// Which bodies get their inertia from their geoms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FromGeoms {
    /// None.
    Never,
    /// All that have geoms.
    Always,
    /// Those without `<inertial>`.
    Missing,
}

/// Settings of a model.
#[derive(Debug)]
pub struct Compiler {
    /// Radians per unit of angle.
    pub angle: f64,
    /// Axes of Euler angles; upper case stands.
    pub eulerseq: [char; 3],
    pub autolimits: bool,
    pub from_geoms: FromGeoms,
    /// Groups of geoms that inertias are made of.
    pub groups: [f64; 2],
    /// kg
    pub least_mass: f64,
    /// kg·m²
    pub least_moment: f64,
    pub balance: bool,
    /// kg of all bodies together.
    pub total_mass: Option<f64>,
    /// Where meshes are.
    pub mesh_folder: PathBuf,
    /// Paths in file names are dropped.
    pub strip_path: bool,
    /// m/s²
    pub gravity: [f64; 3],
    /// Whether equality constraints act.
    pub equality: bool,
    /// The option that puts the robot into a medium.
    pub fluid: Option<Id>,
}

impl Compiler {
    /// The settings of all sections; later ones take the place of earlier ones.
    pub fn of(document: &Document) -> Result<Self, RobotError> {
        let mut compiler = Self {
            angle: std::f64::consts::PI / 180.0,
            eulerseq: ['x', 'y', 'z'],
            autolimits: true,
            from_geoms: FromGeoms::Missing,
            groups: [0.0, 5.0],
            least_mass: 0.0,
            least_moment: 0.0,
            balance: false,
            total_mass: None,
            mesh_folder: PathBuf::new(),
            strip_path: false,
            gravity: STANDARD_GRAVITY,
            equality: true,
            fluid: None,
        };
        let root = document.root();
        for id in document.within(root, "compiler") {
            compiler.set(&Settings::alone(document, id))?;
        }
        for id in document.within(root, "option") {
            compiler.act(&Settings::alone(document, id))?;
            for flag in document.within(id, "flag") {
                compiler.switch(&Settings::alone(document, flag))?;
            }
        }
        let main = document.files()[0].parent();
        compiler.mesh_folder =
            main.map_or(PathBuf::new(), |folder| folder.join(&compiler.mesh_folder));
        Ok(compiler)
    }

    fn set(&mut self, settings: &Settings<'_>) -> Result<(), RobotError> {
        settings.only(KNOWN)?;
        if settings.word("coordinate", &["local", "global"])? == Some("global") {
            return settings.fail(MjcfFault::GlobalCoordinates);
        }
        match settings.word("angle", &["radian", "degree"])? {
            Some("radian") => self.angle = 1.0,
            Some(_) => self.angle = std::f64::consts::PI / 180.0,
            None => {}
        }
        if let Some(found) = settings.text("eulerseq") {
            let axes: Vec<char> = found.chars().collect();
            match axes[..] {
                [a, b, c] if axes.iter().all(|axis| "xyzXYZ".contains(*axis)) => {
                    self.eulerseq = [a, b, c];
                }
                _ => {
                    let found = found.to_string();
                    return settings.fail(MjcfFault::Eulerseq { found });
                }
            }
        }
        match settings.word("inertiafromgeom", &["false", "true", "auto"])? {
            Some("false") => self.from_geoms = FromGeoms::Never,
            Some("true") => self.from_geoms = FromGeoms::Always,
            Some(_) => self.from_geoms = FromGeoms::Missing,
            None => {}
        }
        if let Some(groups) = settings.range("inertiagrouprange")? {
            self.groups = groups;
        }
        if let Some(total) = settings.number("settotalmass")? {
            self.total_mass = (total > 0.0).then_some(total);
        }
        for (name, slot) in [
            ("boundmass", &mut self.least_mass),
            ("boundinertia", &mut self.least_moment),
        ] {
            *slot = settings.not_negative(name)?.unwrap_or(*slot);
        }
        for (name, slot) in [
            ("autolimits", &mut self.autolimits),
            ("balanceinertia", &mut self.balance),
            ("strippath", &mut self.strip_path),
        ] {
            *slot = settings.is_true(name)?.unwrap_or(*slot);
        }
        if let Some(folder) = settings.text("meshdir").or(settings.text("assetdir")) {
            self.mesh_folder = PathBuf::from(folder);
        }
        Ok(())
    }

    fn act(&mut self, settings: &Settings<'_>) -> Result<(), RobotError> {
        if let Some(gravity) = settings.vector("gravity")? {
            self.gravity = gravity.into();
        }
        for name in ["density", "viscosity"] {
            if settings.number(name)?.is_some_and(|value| value != 0.0) {
                self.fluid = Some(settings.id());
            }
        }
        Ok(())
    }

    fn switch(&mut self, flag: &Settings<'_>) -> Result<(), RobotError> {
        let is_off = |name| Ok(flag.word(name, &["disable", "enable"])? == Some("disable"));
        if is_off("gravity")? {
            self.gravity = [0.0; 3];
        }
        self.equality &= !is_off("equality")?;
        Ok(())
    }
}

/// Attributes of `<compiler>`, older ones included.
const KNOWN: &[&str] = &[
    "alignfree",
    "angle",
    "assetdir",
    "autolimits",
    "balanceinertia",
    "boundinertia",
    "boundmass",
    "conflict",
    "convexhull",
    "coordinate",
    "discardvisual",
    "eulerseq",
    "exactmeshinertia",
    "fitaabb",
    "fusestatic",
    "inertiafromgeom",
    "inertiagrouprange",
    "meshdir",
    "passthrough",
    "savecanonical",
    "savecompiled",
    "saveinertial",
    "settotalmass",
    "strippath",
    "texturedir",
    "usethread",
];
