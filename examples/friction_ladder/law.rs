//! The friction laws, as models and as truths.

/// A law with what it is made of and its true values for a joint.
pub struct Law {
    pub name: &'static str,
    pub effects: &'static [&'static str],
    /// `<effect>.<parameter>` and value, for a joint with this Coulomb friction, N·m.
    pub truth: fn(f64) -> Vec<(&'static str, f64)>,
}

pub const LAWS: [Law; 4] = [
    Law {
        name: "Coulomb-viscous",
        effects: &["coulomb_friction", "viscous_friction"],
        truth: |_| Vec::new(),
    },
    Law {
        name: "Stribeck",
        effects: &["coulomb_friction", "viscous_friction", "stribeck_friction"],
        truth: |dry| {
            vec![
                ("stribeck_friction.Fs", 0.4 * dry),
                ("stribeck_friction.vs", 0.1),
            ]
        },
    },
    Law {
        name: "LuGre",
        effects: &[
            "coulomb_friction",
            "viscous_friction",
            "presliding_hysteresis",
        ],
        truth: |dry| {
            vec![
                ("presliding_hysteresis.sigma0", 100.0 * dry),
                ("presliding_hysteresis.sigma1", dry),
                ("presliding_hysteresis.Fs", 0.3 * dry),
                ("presliding_hysteresis.vs", 0.1),
            ]
        },
    },
    Law {
        name: "sigmoid",
        effects: &["sigmoid_friction", "viscous_friction"],
        truth: |dry| {
            vec![
                ("sigmoid_friction.psi1", 2.0 * dry),
                ("sigmoid_friction.psi2", 12.0),
                ("sigmoid_friction.psi3", 0.03),
            ]
        },
    },
];

/// Coulomb and viscous friction of the joints, N·m and N·m·s/rad.
const DRY: [f64; 7] = [1.5, 1.5, 1.2, 1.2, 0.8, 0.6, 0.5];
const VISCOUS: [f64; 7] = [2.5, 2.5, 2.0, 2.0, 0.9, 0.8, 0.6];

/// Transition speed of Coulomb friction, rad/s.
const WIDTH: f64 = 0.01;

impl Law {
    /// Every friction parameter of the arm by its name, and its value.
    pub fn values(&self) -> Vec<(String, f64)> {
        let has_coulomb = self.effects.contains(&"coulomb_friction");
        let mut values = Vec::new();
        for (joint, (dry, viscous)) in DRY.into_iter().zip(VISCOUS).enumerate() {
            let mut own = vec![("viscous_friction.Fv", viscous)];
            if has_coulomb {
                own.extend([("coulomb_friction.Fc", dry), ("coulomb_friction.w", WIDTH)]);
            }
            own.extend((self.truth)(dry));
            let named = own.into_iter();
            values.extend(named.map(|(name, v)| (format!("joint{}.{name}", joint + 1), v)));
        }
        values
    }

    /// The effects as a value of the problem file.
    pub fn list(&self) -> String {
        format!("{:?}", self.effects)
    }
}
