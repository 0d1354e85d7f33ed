//! The effects of which `laws/vocabulary/own_versions.toml` has versions as formulas, with a truth of each.

/// Identifiers, each with the parameters that are not those of the declared friction.
pub const TRUTHS: &[(&str, &[(&str, f64)])] = &[
    ("coulomb_friction", &[]),
    ("viscous_friction", &[]),
    ("asymmetric_friction", &[("dFc", 0.2), ("dFv", 0.3)]),
    ("stribeck_friction", &[("Fs", 0.8), ("vs", 0.3)]),
    ("viscous_nonlinearity", &[("Fn", 0.3), ("p", 2.0)]),
    (
        "sigmoid_friction",
        &[("psi1", 1.0), ("psi2", 3.0), ("psi3", 0.2)],
    ),
    (
        "position_dependent_friction",
        &[("dF", 0.7), ("q0", 0.3), ("width", 0.4)],
    ),
    ("transmission_efficiency", &[("R", 0.85)]),
    ("load_dependent_friction", &[("mu", 0.1)]),
    ("drive_gain", &[("gain", 1.1)]),
    ("torque_offset", &[("offset", 0.3)]),
    ("rotor_inertia", &[("Jm", 0.2)]),
    (
        "torque_ripple",
        &[
            ("order", 8.0),
            ("amplitude", 0.4),
            ("phase", 0.4),
            ("amplitude2", 0.1),
            ("phase2", 1.0),
        ],
    ),
    ("joint_spring", &[("k", 2.0), ("q0", 0.3)]),
];
