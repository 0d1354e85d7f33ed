//! A formula as a user-defined law: its text, the units of its parameters, and the table of a problem file.

use crate::chain::effect::user_law::{ActsOn, LawText, ParameterText, SearchText};
use crate::chain::model::Model;
use crate::diagnose::formula::factor::{Factor, Shape};
use crate::diagnose::formula::grammar::Grammar;
use crate::diagnose::formula::named::{Named, NamedTerm};
use crate::diagnose::formula::solved::Solved;
use crate::diagnose::formula::term::Term;
use crate::diagnose::formula::units::Units;
use crate::diagnose::formula::words;
use crate::robot::tree::JointKind;
use std::fmt::Write;

/// A sum of terms whose parameters have names, values and units.
#[derive(Debug, Clone)]
pub struct Formula {
    pub id: String,
    pub joint: usize,
    /// Name of the joint.
    pub on: String,
    pub terms: Vec<NamedTerm>,
    /// Names of all joints.
    joints: Vec<String>,
}

const SIZES: [&str; 3] = ["a", "b", "c"];

impl Formula {
    /// Of what a search has found for a joint.
    pub fn of(found: &Solved, grammar: &Grammar, model: &Model, joint: usize) -> Self {
        let kinds: Vec<JointKind> = model.joints().iter().map(|j| j.kind).collect();
        let units = Units {
            kinds: &kinds,
            joint,
        };
        let all = found.terms.iter().zip(&found.sizes).enumerate();
        let terms = all.map(|(k, (term, sizes))| named(k, term, sizes, grammar, &units));
        let on = model.joints()[joint].name.clone();
        Self {
            id: free_id(model, &on),
            joint,
            on,
            terms: terms.collect(),
            joints: model.joints().iter().map(|j| j.name.clone()).collect(),
        }
    }

    /// Name of a parameter in a model that has it.
    pub fn full_name(&self, parameter: &str) -> String {
        format!("{}.{}.{parameter}", self.on, self.id)
    }

    /// Whether each of its terms is of the motion of another joint too.
    pub fn is_of_others(&self) -> bool {
        let knows_others = |term: &Term| term.factors.iter().any(|f| f.quantity.other().is_some());
        self.terms.iter().all(|named| knows_others(&named.term))
    }

    pub fn parameters(&self) -> impl Iterator<Item = &Named> {
        self.terms.iter().flat_map(NamedTerm::parameters)
    }

    /// The same with other values of its parameters, by name.
    pub fn with_values(&self, value: &dyn Fn(&str) -> Option<f64>) -> Self {
        let mut changed = self.clone();
        for term in &mut changed.terms {
            let own = term.inner.iter_mut().chain(&mut term.centre).flatten();
            let own = std::iter::once(&mut term.size).chain(own);
            for parameter in own.chain(&mut term.second) {
                parameter.value = value(&parameter.name).unwrap_or(parameter.value);
            }
        }
        changed
    }

    /// With numbers, as people read it: `0.41·tau·sin(8·q)`.
    pub fn expression(&self) -> String {
        words::expression(&self.terms, &self.joints)
    }

    /// The variables of the motion that it has, each once.
    pub fn variables(&self) -> Vec<String> {
        let terms = self.terms.iter().map(|named| &named.term);
        let factors = terms.flat_map(|term| &term.factors);
        let mut found: Vec<String> = Vec::new();
        for name in factors.map(|factor| words::variable(factor.quantity, &self.joints)) {
            if !found.contains(&name) {
                found.push(name);
            }
        }
        found
    }

    /// Whether it has a term that turns over with the speed of its joint.
    pub fn has_friction(&self) -> bool {
        self.terms.iter().any(|named| named.term.is_friction())
    }

    pub fn text(&self) -> LawText {
        let parameter = |named: &Named| ParameterText {
            name: named.name.clone(),
            unit: Some(named.unit.clone()),
            meaning: named.meaning.to_string(),
            lower: named.bounds[0],
            upper: named.bounds[1],
            typical: rounded(named.value),
            search: match named.is_shape {
                true => SearchText::Values(vec![rounded(named.value)]),
                false => SearchText::Typical,
            },
        };
        LawText {
            id: self.id.clone(),
            sentence: format!("A formula for what has no name on {}.", self.on),
            source: "proposed by exid diagnose".to_string(),
            acts_on: ActsOn::Motor,
            torque: words::torque(&self.terms, &self.joints),
            states: Vec::new(),
            parameters: self.parameters().map(parameter).collect(),
            refines: Vec::new(),
        }
    }

    /// The table of a problem file.
    pub fn table(&self) -> String {
        let text = self.text();
        let quoted =
            |text: &str| format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""));
        let mut table = format!(
            "# Found on {on}: with effects_of in [drive], its id goes among the effects of {on}.\n\n[[law]]\nid = {}\n\
             sentence = {}\nsource = {}\nacts_on = \"motor\"\ntorque = {}\n\n[law.parameters]\n",
            quoted(&text.id),
            quoted(&text.sentence),
            quoted(&text.source),
            quoted(&text.torque),
            on = self.on
        );
        for named in self.parameters() {
            let mut entry = format!(
                "unit = {}, meaning = {}, typical = {:?}",
                quoted(&named.unit),
                quoted(named.meaning),
                rounded(named.value)
            );
            for (key, bound) in ["lower", "upper"].iter().zip(named.bounds) {
                if bound.is_finite() {
                    // Writing to a string does not fail.
                    let _ = write!(entry, ", {key} = {:?}", rounded(bound));
                }
            }
            if named.is_shape {
                let _ = write!(entry, ", search = [{:?}]", rounded(named.value));
            }
            let _ = writeln!(table, "{} = {{ {entry} }}", named.name);
        }
        table
    }
}

/// Six significant digits: a start, not a result.
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// An identifier that no effect has yet.
fn free_id(model: &Model, joint: &str) -> String {
    let word = |c: char| if c.is_alphanumeric() { c } else { '_' };
    let plain = format!("formula_{}", joint.chars().map(word).collect::<String>());
    let is_taken = |id: &String| model.catalogue().ids().contains(&id.as_str());
    let numbered = (2..).map(|k| format!("{plain}_{k}"));
    let mut all = std::iter::once(plain.clone()).chain(numbered);
    all.find(|id| !is_taken(id)).unwrap_or(plain)
}

fn named(
    number: usize,
    term: &Term,
    sizes: &[f64],
    grammar: &Grammar,
    units: &Units<'_>,
) -> NamedTerm {
    const FREE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
    let again = match number {
        0 => String::new(),
        number => format!("{}", number + 1),
    };
    // Factors after the first have names of their own.
    let of_factor = |name: &str, f: usize| match f {
        0 => format!("{name}{again}"),
        f => format!("{name}{again}_{}", f + 1),
    };
    let inner = |(f, factor): (usize, &Factor)| {
        let (name, meaning) = match factor.shape {
            Shape::Wave | Shape::Sine | Shape::Cosine => ("n", "periods over 2π"),
            Shape::Above(_) | Shape::Below(_) => ("touch", "value at which it begins"),
            Shape::Slopes => ("knee", "value at which its slope changes"),
            Shape::DeadZone => ("zone", "distance up to which it is none"),
            Shape::Shifted => ("zero", "position at which it is none"),
            Shape::Decay => ("scale", "speed over which it decays"),
            Shape::Saturation | Shape::Bump | Shape::Resonance | Shape::Breakdown => {
                ("width", "range over which it changes")
            }
            Shape::Exponential => ("rate", "growth"),
            Shape::Power(_) | Shape::Magnitude | Shape::SignedSquare | Shape::Direction => {
                return None;
            }
        };
        Some(Named {
            name: of_factor(name, f),
            value: factor.inner,
            unit: units.of_inner(factor),
            meaning,
            bounds: grammar.limits(factor),
            is_shape: true,
        })
    };
    let centre = |(f, factor): (usize, &Factor)| {
        factor.has_centre().then(|| Named {
            name: of_factor("middle", f),
            value: factor.centre,
            unit: units.of_centre(factor),
            meaning: "position of its middle",
            bounds: grammar.inside(factor.quantity),
            is_shape: true,
        })
    };
    let factors = || term.factors.iter().enumerate();
    let free = |name: &str, value: f64, unit: &str, meaning: &'static str| Named {
        name: format!("{name}{again}"),
        value,
        unit: unit.to_string(),
        meaning,
        bounds: FREE,
        is_shape: false,
    };
    let (size, second) = match (sizes, term.sum().map(|factor| factor.shape)) {
        ([above, below], Some(Shape::Slopes)) => {
            let ratio = free("ratio", below / above, "1", "slope below over that above");
            (*above, Some(ratio))
        }
        ([sine, cosine], _) => {
            let phase = free("phi", cosine.atan2(*sine), "rad", "phase");
            (sine.hypot(*cosine), Some(phase))
        }
        _ => (sizes.first().copied().unwrap_or(0.0), None),
    };
    NamedTerm {
        is_negative: size < 0.0,
        size: Named {
            name: SIZES[number % SIZES.len()].to_string(),
            value: size.abs(),
            unit: units.of_size(term),
            meaning: "size",
            bounds: FREE,
            is_shape: false,
        },
        inner: factors().map(inner).collect(),
        centre: factors().map(centre).collect(),
        second,
        term: term.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::effect::user_law;
    use crate::chain::effect::{Law, Samples, Surroundings};
    use crate::diagnose::formula::rows::FittedRows;
    use crate::diagnose::residuals::quantity::Quantity::{
        self, Acceleration, OtherPosition, OtherVelocity, Position, Velocity,
    };

    const ROWS: usize = 40;

    /// The torque of a law that is compiled from its text, along rows.
    fn compiled(formula: &Formula, rows: &FittedRows) -> Vec<f64> {
        let effect = user_law::effect(&formula.text()).unwrap();
        let Law::Motor(law) = effect.law else {
            panic!("a law of the motor: {}", formula.expression());
        };
        let values: Vec<f64> = formula.parameters().map(|p| p.value).collect();
        let others: [[&[f64]; 2]; 1] =
            [[OtherPosition(1), OtherVelocity(1)].map(|quantity| rows.series(quantity))];
        law.torques(
            Samples {
                position: rows.series(Position),
                velocity: rows.series(Velocity),
                acceleration: rows.series(Acceleration),
                sign: &rows.direction,
                time: &[],
                cyclic: false,
                surroundings: Surroundings {
                    others: &others,
                    ..Surroundings::default()
                },
            },
            &values,
        )
    }

    /// Every shape of every variable, alone and beside another: the text of the law, compiled, is what the search has seen.
    #[test]
    fn laws_are_what_the_search_has_seen() {
        let rows = FittedRows::drawn(ROWS);
        let kinds = [JointKind::Revolute, JointKind::Revolute];
        let units = Units {
            kinds: &kinds,
            joint: 0,
        };
        let sets: [&[Quantity]; 3] = [
            &[Position, Velocity],
            &[OtherVelocity(1), OtherPosition(1)],
            &[Acceleration, OtherVelocity(1)],
        ];
        let mut shapes: Vec<Shape> = Vec::new();
        for few in sets {
            let grammar = Grammar::of(&rows, Some(few));
            for term in grammar.terms.iter().step_by(7) {
                shapes.extend(term.factors.iter().map(|factor| factor.shape));
                let columns = term.columns(&rows);
                let sizes = &[0.7, -0.3][..columns.len()];
                let formula = Formula {
                    id: "formula_a".to_string(),
                    joint: 0,
                    on: "a".to_string(),
                    terms: vec![named(0, term, sizes, &grammar, &units)],
                    joints: vec!["a".to_string(), "b".to_string()],
                };
                let of_search = |row: usize| -> f64 {
                    let each = columns.iter().zip(sizes);
                    each.map(|(column, size)| column[row] * size).sum()
                };
                let size: f64 = (0..ROWS)
                    .map(|row| of_search(row).abs())
                    .fold(0.0, f64::max);
                for (row, found) in compiled(&formula, &rows).iter().enumerate() {
                    let off = (found - of_search(row)).abs();
                    assert!(off <= 1e-9 * size, "{}", formula.expression());
                }
            }
        }
        for shape in [
            Shape::Saturation,
            Shape::Bump,
            Shape::Exponential,
            Shape::Shifted,
            Shape::Wave,
            Shape::Slopes,
            Shape::DeadZone,
            Shape::Resonance,
            Shape::Breakdown,
        ] {
            assert!(shapes.contains(&shape), "{shape:?}");
        }
    }

    /// Parameters of two factors of one kind have names of their own.
    #[test]
    fn parameters_of_a_law_have_names_of_their_own() {
        let rows = FittedRows::drawn(ROWS);
        let few = [Position, OtherPosition(1)];
        let grammar = Grammar::of(&rows, Some(&few));
        let bump = |quantity: Quantity| {
            let plain = Factor::plain(quantity, Shape::Bump);
            plain.with_inner(0.3).about(0.1)
        };
        let units = Units {
            kinds: &[JointKind::Revolute, JointKind::Prismatic],
            joint: 0,
        };
        let term = Term::of(few.map(bump));
        let named = named(1, &term, &[2.0], &grammar, &units);
        let names: Vec<(&str, &str)> = named
            .parameters()
            .map(|p| (p.name.as_str(), p.unit.as_str()))
            .collect();
        let expected = [
            ("b", "N·m"),
            ("width2", "rad"),
            ("width2_2", "m"),
            ("middle2", "rad"),
            ("middle2_2", "m"),
        ];
        assert_eq!(names, expected);
    }
}
