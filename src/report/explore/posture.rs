//! Postures of the robot along a take: a position of every joint at some of its times.

use serde::Serialize;

use crate::outcome::skeleton::Skeleton;
use crate::report::explore::encoded::{Quantised, floats};
use crate::report::explore::thinned::every_nth;
use crate::stats::range::within;

/// Postures a second: smoother than that no eye sees it between two samples, since the page interpolates.
const RATE_HZ: f64 = 25.0;

/// Most postures of a take.
const MOST: usize = 3000;

/// Positions of all joints of the skeleton.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Postures {
    /// s since the start of the take, 32-bit floats.
    t: String,
    /// Rad or m, by joints of the skeleton.
    q: Vec<Quantised>,
}

impl Postures {
    /// Positions that `of` gives by the name of a joint; `None` where it lacks one that moves by itself.
    pub fn new<'a>(
        skeleton: &Skeleton,
        t: &[f64],
        of: impl Fn(&str) -> Option<&'a [f64]>,
    ) -> Option<Self> {
        let (first, last) = (t.first()?, t.last()?);
        let most = within(((last - first) * RATE_HZ).ceil(), [2.0, MOST as f64]);
        let rows: Vec<usize> = every_nth(t.len(), most as usize).collect();
        let mut q: Vec<Vec<f64>> = Vec::new();
        for bone in &skeleton.joints {
            let own = match (&bone.follows, bone.locked, of(&bone.name)) {
                (Some(leader), _, _) => {
                    let lead = q.get(leader.joint)?;
                    lead.iter()
                        .map(|q| leader.multiplier * q + leader.offset)
                        .collect()
                }
                (None, _, Some(series)) => rows.iter().map(|&row| series[row]).collect(),
                (None, Some(held), None) => vec![held; rows.len()],
                (None, None, None) => return None,
            };
            q.push(own);
        }
        Some(Self {
            t: floats(rows.iter().map(|&row| t[row] - first)),
            q: q.iter().map(|series| Quantised::of(series)).collect(),
        })
    }
}
