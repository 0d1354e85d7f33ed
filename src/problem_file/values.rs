//! Values of single keys: each function turns a node into a value of its type and range, or says
//! what is wrong with it.

use crate::problem_file::choices::Choice;
use crate::problem_file::context::Context;
use crate::problem_file::document::{Node, NodeValue, Table};
use crate::problem_file::error::{NumberFault, ProblemFileError, ProblemFileErrorKind, ValueFault};
use crate::problem_file::located::{FilePath, Located, PerJoint};

type Parsed<T> = Result<T, ProblemFileError>;

fn fault<T>(node: &Node, kind: impl Into<ProblemFileErrorKind>) -> Parsed<T> {
    Err(ProblemFileError::new(&node.place, kind))
}

pub(super) fn wrong_type(node: &Node, expected: &'static str) -> ProblemFileError {
    let found = match &node.value {
        NodeValue::Text(text) => format!("the text \"{text}\""),
        NodeValue::Integer(integer) => format!("the number {integer}"),
        NodeValue::Number(number) => format!("the number {number}"),
        NodeValue::Boolean(boolean) => boolean.to_string(),
        NodeValue::Date(date) => format!("the date {date}"),
        NodeValue::List(_) | NodeValue::Table(_) => node.kind().to_owned(),
    };
    ProblemFileError::new(&node.place, ValueFault::WrongType { expected, found })
}

pub(super) fn table(node: &Node) -> Parsed<&Table> {
    match &node.value {
        NodeValue::Table(table) => Ok(table),
        _ => Err(wrong_type(node, "a table")),
    }
}

pub(super) fn items<'a>(node: &'a Node, expected: &'static str) -> Parsed<&'a [Node]> {
    match &node.value {
        NodeValue::List(items) => Ok(items),
        _ => Err(wrong_type(node, expected)),
    }
}

/// A list of exactly N values.
pub(super) fn array<T, const N: usize>(
    node: &Node,
    expected: &'static str,
    parse: impl Fn(&Node) -> Parsed<T>,
) -> Parsed<[T; N]> {
    let values: Vec<T> = items(node, expected)?
        .iter()
        .map(parse)
        .collect::<Result<_, _>>()?;
    values.try_into().or_else(|values: Vec<T>| {
        fault(
            node,
            ValueFault::WrongLength {
                expected: expected.to_owned(),
                found: values.len(),
            },
        )
    })
}

pub(super) fn vector3(node: &Node) -> Parsed<[f64; 3]> {
    array(node, "three numbers along x, y, z", finite)
}

pub(super) fn vector4(node: &Node) -> Parsed<[f64; 4]> {
    array(node, "four coefficients c0, c1, c2, c3", finite)
}

/// A text that is not blank.
pub(super) fn text(node: &Node) -> Parsed<String> {
    match &node.value {
        NodeValue::Text(text) if text.trim().is_empty() => fault(node, ValueFault::EmptyText),
        NodeValue::Text(text) => Ok(text.clone()),
        _ => Err(wrong_type(node, "a text in quotes")),
    }
}

pub(super) fn boolean(node: &Node) -> Parsed<bool> {
    match node.value {
        NodeValue::Boolean(boolean) => Ok(boolean),
        _ => Err(wrong_type(node, "true or false")),
    }
}

/// A number, perhaps infinite.
pub(super) fn not_nan(node: &Node) -> Parsed<f64> {
    match node.value {
        NodeValue::Integer(integer) => Ok(integer as f64),
        NodeValue::Number(number) if number.is_nan() => fault(node, NumberFault::NotANumber),
        NodeValue::Number(number) => Ok(number),
        _ => Err(wrong_type(node, "a number")),
    }
}

pub(super) fn finite(node: &Node) -> Parsed<f64> {
    let number = not_nan(node)?;
    match number.is_finite() {
        true => Ok(number),
        false => fault(node, NumberFault::Infinite { found: number }),
    }
}

pub(super) fn positive(node: &Node) -> Parsed<f64> {
    let found = finite(node)?;
    match found > 0.0 {
        true => Ok(found),
        false => fault(node, NumberFault::NotPositive { found }),
    }
}

pub(super) fn non_negative(node: &Node) -> Parsed<f64> {
    let found = finite(node)?;
    match found >= 0.0 {
        true => Ok(found),
        false => fault(node, NumberFault::Negative { found }),
    }
}

fn nonzero(node: &Node) -> Parsed<f64> {
    let found = finite(node)?;
    match found != 0.0 {
        true => Ok(found),
        false => fault(node, NumberFault::Zero),
    }
}

/// A whole number from 1.
pub(super) fn count(node: &Node) -> Parsed<usize> {
    whole_number(node, 1, "from 1 to 1 000 000, a whole number")
}

/// A whole number from 0.
pub(super) fn count_or_zero(node: &Node) -> Parsed<usize> {
    whole_number(node, 0, "from 0 to 1 000 000, a whole number")
}

/// No count of a problem file is this large on purpose, and memory grows with several of them.
pub(super) const LARGEST_COUNT: usize = 1_000_000;

fn whole_number(node: &Node, least: usize, range: &'static str) -> Parsed<usize> {
    let NodeValue::Integer(integer) = node.value else {
        return Err(wrong_type(node, "a whole number"));
    };
    match usize::try_from(integer) {
        Ok(count) if (least..=LARGEST_COUNT).contains(&count) => Ok(count),
        _ => fault(
            node,
            NumberFault::OutOfRange {
                found: integer.to_string(),
                range,
            },
        ),
    }
}

/// A number for all joints, or a list with one for each.
fn per_joint(node: &Node, parse: impl Fn(&Node) -> Parsed<f64>) -> Parsed<PerJoint> {
    match &node.value {
        NodeValue::List(list) => {
            let values = list.iter().map(parse).collect::<Result<_, _>>()?;
            not_empty(values, node).map(PerJoint::Each)
        }
        NodeValue::Integer(_) | NodeValue::Number(_) => parse(node).map(PerJoint::All),
        _ => Err(wrong_type(
            node,
            "a list with one number per joint, or one number for all",
        )),
    }
}

pub(super) fn per_joint_finite(node: &Node) -> Parsed<PerJoint> {
    per_joint(node, finite)
}

pub(super) fn per_joint_positive(node: &Node) -> Parsed<PerJoint> {
    per_joint(node, positive)
}

pub(super) fn per_joint_non_negative(node: &Node) -> Parsed<PerJoint> {
    per_joint(node, non_negative)
}

pub(super) fn per_joint_nonzero(node: &Node) -> Parsed<PerJoint> {
    per_joint(node, nonzero)
}

pub(super) fn not_empty<T>(values: Vec<T>, node: &Node) -> Parsed<Vec<T>> {
    match values.is_empty() {
        true => fault(node, ValueFault::EmptyList),
        false => Ok(values),
    }
}

/// One word of a fixed list.
pub(super) fn choice<C: Choice>(node: &Node) -> Parsed<C> {
    let found = text(node)?;
    let choice = C::WORDS.iter().find(|(word, _)| *word == found);
    match choice {
        Some((_, choice)) => Ok(*choice),
        None => fault(
            node,
            ValueFault::UnknownWord {
                noun: C::NOUN,
                code: C::CODE,
                found,
                known: C::WORDS.iter().map(|(word, _)| (*word).into()).collect(),
            },
        ),
    }
}

/// A list of names, each once.
pub(super) fn names(node: &Node, expected: &'static str) -> Parsed<Vec<Located<String>>> {
    let names: Vec<Located<String>> = items(node, expected)?
        .iter()
        .map(|item| {
            Ok(Located {
                value: text(item)?,
                place: item.place.clone(),
            })
        })
        .collect::<Result<_, _>>()?;
    check_no_duplicates(names.iter())?;
    Ok(names)
}

/// A list of effects, each once and known.
pub(super) fn effects(node: &Node, context: &Context) -> Parsed<Vec<Located<String>>> {
    let effects = names(node, "a list of effects such as [\"coulomb_friction\"]")?;
    let unknown = |effect: &&Located<String>| !context.effect_ids.contains(&effect.as_str());
    match effects.iter().find(unknown) {
        None => Ok(effects),
        Some(effect) => Err(ProblemFileError::new(
            &effect.place,
            ValueFault::UnknownWord {
                noun: "effect",
                code: "unknown-effect",
                found: effect.value.clone(),
                known: context.effect_ids.iter().map(|id| (*id).into()).collect(),
            },
        )),
    }
}

pub(super) fn check_no_duplicates<'a>(
    names: impl Iterator<Item = &'a Located<String>>,
) -> Parsed<()> {
    let mut seen: Vec<&str> = Vec::new();
    for name in names {
        if seen.contains(&name.as_str()) {
            return Err(ProblemFileError::new(
                &name.place,
                ValueFault::Duplicate {
                    found: name.value.clone(),
                },
            ));
        }
        seen.push(&name.value);
    }
    Ok(())
}

pub(super) fn file_path(node: &Node, context: &Context) -> Parsed<FilePath> {
    Ok(FilePath::new(context.folder, &text(node)?))
}

/// A name that is also a folder's.
pub(super) fn folder_name(node: &Node) -> Parsed<String> {
    let name = text(node)?;
    match is_folder_name(&name) {
        true => Ok(name),
        false => fault(node, ValueFault::NotAFolderName { found: name }),
    }
}

pub(super) fn is_folder_name(name: &str) -> bool {
    let allowed = |c: char| c.is_alphanumeric() || " -_.".contains(c);
    name.chars().all(allowed) && !name.chars().all(|c| c == '.' || c == ' ')
}
