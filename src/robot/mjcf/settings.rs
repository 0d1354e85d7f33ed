//! Attributes of an element through its default classes: its own, those of its class, of the class around that, and so on.

use crate::fault::nearest;
use crate::robot::error::{LARGEST_NUMBER, RobotError, RobotErrorKind};
use crate::robot::mjcf::document::{Document, Id};
use crate::robot::mjcf::messages::fail;
use crate::robot::mjcf_fault::MjcfFault;
use nalgebra::Vector3;
use std::collections::HashMap;
use std::ops::RangeInclusive;

/// Name of the outermost class where it has none.
const OUTERMOST: &str = "main";

/// A default class: the elements that set its defaults, and the class around it.
#[derive(Debug, Default)]
struct Class {
    around: Option<String>,
    elements: Vec<Id>,
}

/// The default classes of a model by name.
#[derive(Debug)]
pub struct Classes {
    classes: HashMap<String, Class>,
    outermost: String,
}

impl Classes {
    /// The classes of all `<default>` sections; several outermost sections are one.
    pub fn of(document: &Document) -> Result<Self, RobotError> {
        let mut sections = document.within(document.root(), "default");
        let named = sections.find_map(|id| document.attribute(id, "class"));
        let outermost = named.unwrap_or(OUTERMOST).to_string();
        let mut classes = HashMap::from([(outermost.clone(), Class::default())]);
        let mut pending: Vec<(Id, String)> = document
            .within(document.root(), "default")
            .map(|id| (id, outermost.clone()))
            .collect();
        while let Some((id, name)) = pending.pop() {
            for &child in document.children(id) {
                if document.name(child) != "default" {
                    let class = classes.get_mut(&name);
                    class.into_iter().for_each(|c| c.elements.push(child));
                    continue;
                }
                let Some(inner) = document.attribute(child, "class") else {
                    return fail(document.place(child), MjcfFault::ClassWithoutName);
                };
                let class = Class {
                    around: Some(name.clone()),
                    elements: Vec::new(),
                };
                if classes.insert(inner.to_string(), class).is_some() {
                    let name = inner.to_string();
                    return fail(document.place(child), MjcfFault::ClassTwice { name });
                }
                pending.push((child, inner.to_string()));
            }
        }
        Ok(Self { classes, outermost })
    }

    /// The elements of one name, or any for which `fits` holds, that set defaults of a class, the nearest first.
    fn layers(&self, document: &Document, class: &str, fits: &dyn Fn(&str) -> bool) -> Vec<Id> {
        let mut layers = Vec::new();
        let mut at = self.classes.get(class);
        while let Some(class) = at {
            let own = class.elements.iter().rev().copied();
            layers.extend(own.filter(|id| fits(document.name(*id))));
            at = class
                .around
                .as_ref()
                .and_then(|name| self.classes.get(name));
        }
        layers
    }

    /// An element with its defaults: of its own class, else of `childclass`, else of the outermost one.
    pub fn settings<'a>(
        &self,
        document: &'a Document,
        id: Id,
        childclass: Option<&str>,
    ) -> Result<Settings<'a>, RobotError> {
        let name = document.name(id);
        self.settings_where(document, id, childclass, &|other| other == name)
    }

    /// The same with the defaults of all elements that `fits` accepts by name.
    pub fn settings_where<'a>(
        &self,
        document: &'a Document,
        id: Id,
        childclass: Option<&str>,
        fits: &dyn Fn(&str) -> bool,
    ) -> Result<Settings<'a>, RobotError> {
        let own = document.attribute(id, "class");
        let class = own.or(childclass).unwrap_or(&self.outermost);
        self.known(document, id, class)?;
        let mut layers = vec![id];
        layers.extend(self.layers(document, class, fits));
        Ok(Settings { document, layers })
    }

    /// Whether a class exists.
    pub fn known(&self, document: &Document, id: Id, class: &str) -> Result<(), RobotError> {
        if self.classes.contains_key(class) {
            return Ok(());
        }
        let fault = MjcfFault::UnknownClass {
            found: class.to_string(),
            nearest: nearest(class, self.classes.keys().map(String::as_str)),
        };
        fail(document.place(id), fault)
    }
}

/// An element and the elements that set its defaults, the nearest first.
#[derive(Debug)]
pub struct Settings<'a> {
    document: &'a Document,
    layers: Vec<Id>,
}

/// An attribute and the element that has it.
#[derive(Debug, Clone, Copy)]
pub struct Found<'a> {
    pub id: Id,
    pub text: &'a str,
}

impl<'a> Settings<'a> {
    /// An element without defaults.
    pub fn alone(document: &'a Document, id: Id) -> Self {
        Self {
            document,
            layers: vec![id],
        }
    }

    pub fn document(&self) -> &'a Document {
        self.document
    }

    /// The element itself.
    pub fn id(&self) -> Id {
        self.layers[0]
    }

    /// The nearest element that has one of the attributes, and all of them that it has.
    pub fn nearest_of(&self, names: &[&'static str]) -> Option<(Id, Vec<&'static str>)> {
        self.layers.iter().find_map(|&id| {
            let has = |name: &&&'static str| self.document.attribute(id, name).is_some();
            let found: Vec<&'static str> = names.iter().filter(has).copied().collect();
            (!found.is_empty()).then_some((id, found))
        })
    }

    pub fn find(&self, name: &str) -> Option<Found<'a>> {
        self.layers.iter().find_map(|&id| {
            let text = self.document.attribute(id, name)?;
            Some(Found { id, text })
        })
    }

    pub fn text(&self, name: &str) -> Option<&'a str> {
        self.find(name).map(|found| found.text)
    }

    /// Fails at the element.
    pub fn fail<T>(&self, fault: MjcfFault) -> Result<T, RobotError> {
        fail(self.document.place(self.id()), fault)
    }

    /// A word among those allowed.
    pub fn word(
        &self,
        name: &str,
        allowed: &'static [&'static str],
    ) -> Result<Option<&'static str>, RobotError> {
        let Some(found) = self.find(name) else {
            return Ok(None);
        };
        match allowed.iter().find(|word| **word == found.text.trim()) {
            Some(word) => Ok(Some(word)),
            None => {
                let fault = MjcfFault::NotAWord {
                    attribute: name.to_string(),
                    found: found.text.to_string(),
                    allowed,
                };
                fail(self.document.place(found.id), fault)
            }
        }
    }

    /// Whether an attribute is `true`.
    pub fn is_true(&self, name: &str) -> Result<Option<bool>, RobotError> {
        let word = self.word(name, &["false", "true"])?;
        Ok(word.map(|word| word == "true"))
    }

    /// The numbers of an attribute, as many as `count` says.
    pub fn numbers(
        &self,
        name: &str,
        count: RangeInclusive<usize>,
    ) -> Result<Option<Vec<f64>>, RobotError> {
        let Some(found) = self.find(name) else {
            return Ok(None);
        };
        let place = || self.document.place(found.id);
        let mut values = Vec::new();
        for word in found.text.split_whitespace() {
            let fault = |kind| Err(RobotError::new(place(), kind));
            let found = word.to_string();
            match word.parse::<f64>() {
                Err(_) => return fault(RobotErrorKind::NotNumber { found }),
                Ok(value) if !value.is_finite() => {
                    return fault(RobotErrorKind::NotFinite { found });
                }
                Ok(value) if value.abs() > LARGEST_NUMBER => {
                    let limit = LARGEST_NUMBER;
                    return fault(RobotErrorKind::TooLargeNumber { found, limit });
                }
                Ok(value) => values.push(value),
            }
        }
        if count.contains(&values.len()) {
            return Ok(Some(values));
        }
        let expected = match (count.start(), count.end()) {
            (least, most) if least == most => least.to_string(),
            (least, most) => format!("{least} to {most}"),
        };
        let fault = MjcfFault::WrongCount {
            attribute: name.to_string(),
            found: values.len(),
            expected,
        };
        fail(place(), fault)
    }

    pub fn number(&self, name: &str) -> Result<Option<f64>, RobotError> {
        Ok(self.numbers(name, 1..=1)?.map(|values| values[0]))
    }

    /// A number that is not negative.
    pub fn not_negative(&self, name: &str) -> Result<Option<f64>, RobotError> {
        let value = self.number(name)?;
        self.refuse_negative(name, value)
    }

    /// A value that is not negative, as it is.
    pub fn refuse_negative(
        &self,
        name: &str,
        value: Option<f64>,
    ) -> Result<Option<f64>, RobotError> {
        match value {
            Some(found) if found < 0.0 => self.fail(MjcfFault::Negative {
                attribute: name.to_string(),
                found,
            }),
            value => Ok(value),
        }
    }

    pub fn vector(&self, name: &str) -> Result<Option<Vector3<f64>>, RobotError> {
        let values = self.numbers(name, 3..=3)?;
        Ok(values.map(|v| Vector3::new(v[0], v[1], v[2])))
    }

    /// Two numbers, the first not above the second.
    pub fn range(&self, name: &str) -> Result<Option<[f64; 2]>, RobotError> {
        let Some(values) = self.numbers(name, 2..=2)? else {
            return Ok(None);
        };
        let [lower, upper] = [values[0], values[1]];
        if lower > upper {
            let place = self.document.place(self.id());
            let kind = RobotErrorKind::LimitsReversed { lower, upper };
            return Err(RobotError::new(place, kind));
        }
        Ok(Some([lower, upper]))
    }

    /// Refuses attributes of the element, not of its defaults, that are none of `known`.
    pub fn only(&self, known: &[&str]) -> Result<(), RobotError> {
        let mut attributes = self.document.attributes(self.id());
        match attributes.find(|name| !known.contains(name)) {
            None => Ok(()),
            Some(name) => self.fail(MjcfFault::UnknownAttribute {
                found: name.to_string(),
                nearest: nearest(name, known.iter().copied()),
            }),
        }
    }
}
