//! The three types: what their files say, and what one robot of a type has.

use exid::robot::random::symmetric;
use rand_chacha::ChaCha8Rng;

/// A joint of a type.
pub struct JointOfType {
    pub axis: &'static str,
    /// Placement in the link before, m.
    pub at: &'static str,
    /// kg.
    pub mass: f64,
    /// N·m, of a robot in the middle of its type.
    pub friction: f64,
    pub weight: Weight,
}

/// What gravity does at a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weight {
    /// Nothing: its axis stands vertical.
    None,
    /// Too little for the zero of its encoder to show.
    Little,
    Shows,
}

/// A type of robots.
pub struct Type {
    pub name: &'static str,
    pub joints: &'static [JointOfType],
}

const fn joint(
    axis: &'static str,
    at: &'static str,
    [mass, friction]: [f64; 2],
    weight: Weight,
) -> JointOfType {
    JointOfType {
        axis,
        at,
        mass,
        friction,
        weight,
    }
}

const Y: &str = "0 1 0";
const Z: &str = "0 0 1";

pub static TYPES: [Type; 3] = [
    Type {
        name: "swing",
        joints: &[
            joint(Y, "0 0 0.3", [6.0, 3.0], Weight::Shows),
            joint(Y, "0.4 0 0", [4.0, 2.0], Weight::Shows),
        ],
    },
    Type {
        name: "turn",
        joints: &[
            joint(Z, "0 0 0.2", [8.0, 4.0], Weight::None),
            joint(Y, "0 0 0.1", [6.0, 3.0], Weight::Shows),
            joint(Y, "0.4 0 0", [4.0, 2.0], Weight::Shows),
        ],
    },
    Type {
        name: "wrist",
        joints: &[
            joint(Z, "0 0 0.2", [8.0, 4.0], Weight::None),
            joint(Y, "0 0 0.1", [6.0, 3.0], Weight::Shows),
            joint(Y, "0.4 0 0", [4.0, 2.0], Weight::Shows),
            joint("1 0 0", "0.3 0 0", [1.5, 0.8], Weight::Little),
        ],
    },
];

/// kg of the tool.
pub const TOOL: f64 = 1.5;

/// Where its centre of mass is in the last link, m: known of the tool, and of what it grips.
const TOOL_CENTRE: &str = "0.15 0.01 0.03";

impl Type {
    pub fn joint_name(&self, j: usize) -> String {
        format!("j{}", j + 1)
    }

    pub fn urdf(&self) -> String {
        let mut text = format!("<robot name=\"{}\">\n<link name=\"base\"/>\n", self.name);
        for (j, joint) in self.joints.iter().enumerate() {
            let (n, m) = (j + 1, joint.mass);
            let before = if j == 0 {
                "base".to_string()
            } else {
                format!("l{j}")
            };
            text.push_str(&format!(
                "<link name=\"l{n}\"><inertial><origin xyz=\"0.18 0.01 0.02\"/><mass value=\"{m}\"/><inertia ixx=\"{0}\" ixy=\"0\" \
                 ixz=\"0\" iyy=\"{1}\" iyz=\"0\" izz=\"{1}\"/></inertial></link>\n<joint name=\"j{n}\" type=\"revolute\"><origin \
                 xyz=\"{2}\"/><parent link=\"{before}\"/><child link=\"l{n}\"/><axis xyz=\"{3}\"/><limit lower=\"-1.6\" \
                 upper=\"1.6\" velocity=\"3.0\" effort=\"200\"/></joint>\n",
                0.004 * m,
                0.016 * m,
                joint.at,
                joint.axis
            ));
        }
        let last = self.joints.len();
        text + &format!(
            "<link name=\"tool\"/>\n<joint name=\"flange\" type=\"fixed\"><origin xyz=\"{TOOL_CENTRE}\"/><parent link=\"l{last}\"/>\
             <child link=\"tool\"/></joint>\n</robot>\n"
        )
    }

    /// The problem of all robots of the type, and with values one that simulates a robot.
    pub fn problem(&self) -> String {
        const EFFECTS: &str = "\"coulomb_friction\", \"viscous_friction\", \"transmission_efficiency\", \"torque_offset\", \
                               \"time_delay\"";
        let count = self.joints.len();
        let numbered = || self.joints.iter().zip(1..);
        let widths: String = (1..=count)
            .map(|n| format!("\"j{n}.coulomb_friction.w\" = 0.01\n"))
            .collect();
        let with_zero: String = numbered()
            .filter(|(joint, _)| joint.weight == Weight::Shows)
            .map(|(_, n)| format!("j{n} = [{EFFECTS}, \"encoder_offset\"]\n"))
            .collect();
        format!(
            "name = \"{0}\"\n[robot]\nurdf = \"{0}.urdf\"\ninertials = \"known\"\npayload = \"tool\"\nzero = [\"payload.com_x\", \
             \"payload.com_y\", \"payload.com_z\", \"payload.inertia_xy\", \"payload.inertia_xz\", \"payload.inertia_yz\"]\n\
             [drive]\nrotor_inertia = {1:?}\neffects = [{EFFECTS}]\n[drive.effects_of]\n{with_zero}[drive.values]\n{widths}\
             [recordings]\ntrain = [\"none.csv\"]\nsignal = \"torque\"\nrate = 100.0\nperiod = 5.0\n",
            self.name,
            vec![0.3; count]
        )
    }
}

/// The physics of one joint of one robot.
#[derive(Clone)]
pub struct Joint {
    pub coulomb: f64,
    pub viscous: f64,
    pub efficiency: f64,
    /// N·m.
    pub offset: f64,
    /// s.
    pub delay: f64,
    /// Its encoder shows so much less than is, rad.
    pub encoder: f64,
}

/// One robot.
#[derive(Clone)]
pub struct Robot {
    pub joints: Vec<Joint>,
    /// kg.
    pub tool: f64,
}

impl Robot {
    /// A robot of a type.
    pub fn draw(of: &Type, rng: &mut ChaCha8Rng) -> Self {
        let mut about = |share: f64| 1.0 + symmetric(rng, share);
        let mut joints: Vec<Joint> = Vec::new();
        for joint in of.joints {
            joints.push(Joint {
                coulomb: joint.friction * about(0.2),
                viscous: 0.5 * joint.friction * about(0.2),
                efficiency: 0.9 * about(0.02),
                offset: 0.0,
                delay: 0.004 * about(0.1),
                encoder: 0.0,
            });
        }
        let tool = TOOL * about(0.05);
        for joint in &mut joints {
            joint.offset = symmetric(rng, 0.2);
            joint.encoder = symmetric(rng, 0.001);
        }
        Self { joints, tool }
    }

    /// The same robot on one night.
    pub fn tonight(&self, rng: &mut ChaCha8Rng) -> Self {
        let mut tonight = self.clone();
        for joint in &mut tonight.joints {
            joint.coulomb *= 1.0 + symmetric(rng, 0.02);
            joint.viscous *= 1.0 + symmetric(rng, 0.03);
            joint.offset += symmetric(rng, 0.02);
        }
        tonight
    }

    /// A parameter by its name in a report.
    pub fn value(&self, parameter: &str) -> Option<f64> {
        let parts: Vec<&str> = parameter.split('.').collect();
        let joint = |name: &str| {
            self.joints
                .get(name.trim_start_matches('j').parse::<usize>().ok()? - 1)
        };
        match parts[..] {
            ["payload", "mass"] => Some(self.tool),
            [name, _, "Fc"] => Some(joint(name)?.coulomb),
            [name, _, "Fv"] => Some(joint(name)?.viscous),
            [name, _, "R"] => Some(joint(name)?.efficiency),
            [name, "encoder_offset", _] => Some(joint(name)?.encoder),
            [name, _, "offset"] => Some(joint(name)?.offset),
            [name, _, "delay"] => Some(joint(name)?.delay),
            _ => None,
        }
    }

    /// The values of a simulation in which encoders show where the joints are.
    pub fn values(&self, of: &Type) -> String {
        let mut text = String::from("[simulate.values]\n");
        for (j, joint) in self.joints.iter().enumerate() {
            let name = format!("j{}", j + 1);
            for (parameter, value) in [
                ("coulomb_friction.Fc", joint.coulomb),
                ("viscous_friction.Fv", joint.viscous),
                ("transmission_efficiency.R", joint.efficiency),
                ("torque_offset.offset", joint.offset),
                ("time_delay.delay", joint.delay),
            ] {
                text.push_str(&format!("\"{name}.{parameter}\" = {value:?}\n"));
            }
            if of.joints[j].weight == Weight::Shows {
                text.push_str(&format!("\"{name}.encoder_offset.offset\" = 0.0\n"));
            }
        }
        for (quantity, value) in [
            ("mass", self.tool),
            ("com_x", 0.0),
            ("com_y", 0.0),
            ("com_z", 0.0),
            ("inertia_xx", 0.002),
            ("inertia_xy", 0.0),
            ("inertia_xz", 0.0),
            ("inertia_yy", 0.002),
            ("inertia_yz", 0.0),
            ("inertia_zz", 0.002),
        ] {
            text.push_str(&format!("\"payload.{quantity}\" = {value:?}\n"));
        }
        text
    }
}
