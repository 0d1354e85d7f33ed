//! Whether a term that is odd in the speed of a joint dissipates power.
//!
//! ```text
//! P = ½ (τ(q, v, a) − τ(q, −v, a)) v,   Σ max(−P, 0) ≤ Σ |P| / 20
//! ```
//!
//! Inertia, gravity and springs are even in all speeds together, and so are centrifugal torques: the odd part of a whole model
//! is its friction, of which a formula may be a part that alone would drive. A model that drives a joint with it has something
//! else in it: such a formula gives way to any other that is as good.

use crate::chain::dataset::Prepared;
use crate::chain::effect::Memory;
use crate::diagnose::fit::channel_series::ChannelSeries;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::recording::split::Split;

/// Share of the work of friction that may drive: what uncertain parameters and speeds near zero give.
const DRIVES: f64 = 0.05;

/// Whether the friction of a channel brakes its joint along the fitted recordings; true where the model remembers, as nothing
/// then is known of the same motion in the other direction.
pub fn brakes(context: &Context<'_>, fit: &ModelFit, channel: usize) -> bool {
    let model = &fit.model;
    let Some(joint) = model.channels()[channel].joint else {
        return true;
    };
    let of_joint = &model.joints()[joint];
    if model.memory() == Memory::WholeMotion || of_joint.has_lag() || of_joint.delay.is_some() {
        return true;
    }
    let recordings = context.recordings(Split::Train);
    let turned: Vec<Prepared> = recordings.iter().map(|r| r.with_speeds_turned()).collect();
    let turned: Vec<&Prepared> = turned.iter().collect();
    let [there, back] = [&recordings, &turned]
        .map(|of| ChannelSeries::predicted_of(channel, model, &fit.values, of));
    let speeds = recordings.iter().flat_map(|r| {
        let speed = &r.segment().motors.dq[joint];
        r.counting_for(channel).map(move |row| speed[row])
    });
    let (mut driven, mut all) = (0.0, 0.0);
    for ((there, back), v) in there.iter().zip(&back).zip(speeds) {
        let power = 0.5 * (there - back) * v;
        driven += (-power).max(0.0);
        all += power.abs();
    }
    driven <= DRIVES * all
}
