//! `<equality>`: joints that follow others, joints that are held, and loops that stay open.
//!
//! A constraint between joints is `q₁ − ref₁ = a₀ + a₁ (q₂ − ref₂) + a₂ (q₂ − ref₂)² + …`; without a second joint q₁ is
//! held at `ref₁ + a₀`.

use crate::fault::nearest;
use crate::robot::dependents::RawDependent;
use crate::robot::description::{Note, Weight};
use crate::robot::error::RobotError;
use crate::robot::mjcf::body::Bodies;
use crate::robot::mjcf::messages::note;
use crate::robot::mjcf::model::Model;
use crate::robot::mjcf::settings::Settings;
use crate::robot::mjcf_fault::MjcfFault;

/// What the constraints of a model make of its joints.
#[derive(Default)]
pub struct Equalities {
    pub dependents: Vec<RawDependent>,
    pub held: Vec<HeldByName>,
    pub notes: Vec<Note>,
}

/// A joint and the position at which a constraint holds it, rad (m).
pub struct HeldByName {
    pub joint: String,
    pub position: f64,
}

/// Reads the constraints that act.
pub fn of(model: &Model<'_>, bodies: &Bodies) -> Result<Equalities, RobotError> {
    let mut found = Equalities::default();
    let document = model.document;
    if !model.compiler.equality {
        return Ok(found);
    }
    for section in document.within(document.root(), "equality") {
        for &id in document.children(section) {
            let settings = model
                .classes
                .settings_where(document, id, None, &|name| name == "equality")?;
            if settings.is_true("active")? == Some(false) {
                continue;
            }
            match document.name(id) {
                "joint" => found.joint(model, bodies, &settings)?,
                kind => {
                    let message = format!(
                        "the constraint <{kind}> is not in the model: the loop that it closes is open"
                    );
                    let remedy =
                        "close it with [[robot.closed]], or leave the joints out that it holds";
                    let place = document.place(id);
                    found
                        .notes
                        .push(note(place, Weight::LeftOut, message, remedy));
                }
            }
        }
    }
    Ok(found)
}

impl Equalities {
    fn joint(
        &mut self,
        model: &Model<'_>,
        bodies: &Bodies,
        settings: &Settings<'_>,
    ) -> Result<(), RobotError> {
        let known = |attribute: &'static str| match settings.text(attribute) {
            None => Ok(None),
            Some(name) if bodies.references.contains_key(name) => Ok(Some(name)),
            Some(name) if bodies.still.iter().any(|still| still == name) => Ok(Some(name)),
            Some(name) => {
                let names = bodies.joints.iter().map(|joint| joint.name.as_str());
                settings.fail(MjcfFault::UnknownJoint {
                    found: name.to_string(),
                    nearest: nearest(name, names),
                })
            }
        };
        let Some(joint) = known("joint1")? else {
            return settings.fail(MjcfFault::MissingAttribute {
                attribute: "joint1",
            });
        };
        let leader = known("joint2")?;
        let mut terms = settings.numbers("polycoef", 1..=5)?.unwrap_or_default();
        let given = terms.len();
        terms.resize(5, 0.0);
        if given < 2 {
            terms[1] = 1.0;
        }
        let reference = |name: &str| bodies.references.get(name).copied().unwrap_or(0.0);
        let place = model.document.place(settings.id());
        let Some(leader) = leader else {
            self.held.push(HeldByName {
                joint: joint.to_string(),
                position: reference(joint) + terms[0],
            });
            return Ok(());
        };
        if terms[2..].iter().any(|term| *term != 0.0) {
            let message = format!(
                "`{joint}` follows `{leader}` by a polynomial, which is not in the model: it moves alone"
            );
            let remedy = "lock both, or write the constraint with two terms";
            self.notes
                .push(note(place, Weight::LeftOut, message, remedy));
            return Ok(());
        }
        self.dependents.push(RawDependent {
            joint: joint.to_string(),
            leader: leader.to_string(),
            multiplier: terms[1],
            offset: reference(joint) + terms[0] - terms[1] * reference(leader),
            place,
        });
        Ok(())
    }
}
