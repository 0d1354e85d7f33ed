//! Friction in proportion to the transmitted torque: `mu·|τ_M|·sign(v)`.

use crate::chain::effect::expression::{Expression, Variable};
use crate::chain::effect::fitted_effect::FittedEffect;
use crate::chain::effect::knowledge::{Change, Drawn, Knowledge, Sizes, Trial, drawn};
use crate::chain::effect::law::size;
use crate::chain::effect::site::Site;
use crate::chain::effect::{
    Confounder, Dependence, Effect, Law, Needs, ParameterInfo, Samples, Search, Span,
    TransmissionLaw, Transmitted, Unit,
};
use rand_chacha::ChaCha8Rng;

/// The table's entry.
pub const EFFECT: Effect = Effect {
    id: "load_dependent_friction",
    sentence: "Friction of teeth and bearings grows with the torque that they carry.",
    equation: "mu·|τ_M|·sign(v)",
    source: "Hamon, Gautier and Garrec 2010",
    parameters: &[ParameterInfo::nonlinear(
        "mu",
        Unit::One,
        "friction torque per transmitted torque",
        Span {
            lower: -1.0,
            typical: 0.05,
            upper: 5.0,
        },
        Search::Values(&[0.05]),
    )],
    depends_on: &[Dependence::Load, Dependence::Direction],
    confounded_with: &[Confounder {
        with: "transmission_efficiency",
        separated_by: "known link inertials or a known load: an efficiency has the gain (1/R + R)/2 as well",
    }],
    law: Law::Transmission(&LoadFriction),
    needs: Needs::NOTHING,
    knowledge: Knowledge {
        finding: Some(finding),
        change: Some(Change {
            up: "efficiency down",
            down: "efficiency up",
        }),
        sizes: Sizes::First,
        trial: Trial::Drawn(sized),
        ..Knowledge::NONE
    },
};

fn finding(found: &FittedEffect<'_>) -> String {
    let share = found.scaled("mu", "%", |mu| 100.0 * mu.max(0.0));
    let share = share.map_or_else(String::new, |share| format!(", by {share} of it"));
    format!(
        "Friction of {} grows with the load that it carries{share}; the model's friction did not know the load",
        found.who
    )
}

fn sized(site: &Site, _: &mut ChaCha8Rng) -> Vec<Drawn> {
    vec![drawn("mu", site.share)]
}

#[derive(Debug)]
struct LoadFriction;

impl TransmissionLaw for LoadFriction {
    fn add(
        &self,
        samples: Samples<'_>,
        load: &[f64],
        parameters: &[f64],
        out: &mut Transmitted<'_>,
    ) {
        let [mu] = *parameters else { return };
        for (k, (load, sign)) in load.iter().zip(samples.sign).enumerate() {
            let (size, slope) = size(*load, out.rounding);
            out.torque[k] += mu * size * sign;
            out.by_load[k] += mu * slope * sign;
            out.by_parameter[0][k] = size * sign;
            out.by_sign[k] += mu * size;
        }
    }

    fn added(&self) -> Expression {
        let size = Expression::from(Variable::Load).magnitude();
        Expression::parameter(0) * size * Variable::Sign
    }
}
