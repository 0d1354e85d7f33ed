//! `[[law]]`: laws of one's own, in the problem file or in files of their own that `laws` names.

use std::fs;
use std::path::{Path, PathBuf};

use crate::fault::Place;
use crate::problem_file::choices::Choice;
use crate::problem_file::context::Context;
use crate::problem_file::document::{self, Entry, Node, NodeValue};
use crate::problem_file::error::{KeyFault, ProblemFileError};
use crate::problem_file::key::{Form, Key, Length, REQUIRED, Range, words};
use crate::problem_file::located::{FilePath, Located, Named};
use crate::problem_file::reader::Reader;
use crate::problem_file::values;

/// Keys of a `[[law]]`.
#[rustfmt::skip]
pub(crate) const KEYS: &[Key] = &[
    Key { name: "id", form: Form::Text, unit: "", default: REQUIRED, example: "\"cogging_by_load\"", meaning: "Name of the effect, wherever an effect's name goes" },
    Key { name: "sentence", form: Form::Text, unit: "", default: REQUIRED, example: "\"Teeth that mesh harder under load\"", meaning: "What it is, in one sentence of physics" },
    Key { name: "source", form: Form::Text, unit: "", default: "none", example: "\"Author 2020 eq. 3\"", meaning: "Where the law comes from" },
    Key { name: "acts_on", form: Form::Words(words::<ActsOn>), unit: "", default: "\"motor\"", example: "\"joint\"", meaning: "Where it acts: a torque of the motor, a torque at the joint, what the signal shows beyond the motor's torque, or a factor of the torque constant" },
    Key { name: "torque", form: Form::Text, unit: "N·m (N); of a gain none", default: REQUIRED, example: "\"a*tau*sin(n*q + phi)\"", meaning: "The formula, in q, v, acc, tau (transmitted torque), i, t, T (temperature), q[joint], v[joint], period, z and the parameters" },
    Key { name: "dz", form: Form::Either(&[Form::Text, Form::List(&Form::Text, Length::Any)]), unit: "", default: "no state", example: "\"v - abs(v)*z/d\"", meaning: "Rate of a state z, in v, z and parameters; of several states z1, z2, ... a list, each in its own state" },
    Key { name: "start", form: Form::Either(&[Form::Text, Form::List(&Form::Text, Length::Any)]), unit: "", default: "0", example: "\"d*sign(v)\"", meaning: "First value of the state, in v and parameters; of several states a list" },
    Key { name: "refines", form: Form::List(&Form::Effect, Length::Distinct), unit: "", default: "none", example: "[\"coulomb_friction\"]", meaning: "Effects without any of which, on the same joint, it is not looked for" },
    Key { name: "parameters", form: Form::NamedTables(PARAMETER_KEYS), unit: "", default: "none", example: "", meaning: "Its parameters by their names in the formula" },
];

/// Keys of a parameter of a law.
#[rustfmt::skip]
pub(crate) const PARAMETER_KEYS: &[Key] = &[
    Key { name: "unit", form: Form::Text, unit: "", default: "not checked", example: "\"N·m/rad\"", meaning: "Unit, \"1\" for a pure number; where units are stated, formulas are checked" },
    Key { name: "meaning", form: Form::Text, unit: "", default: "none", example: "\"share of the load\"", meaning: "What the parameter is" },
    Key { name: "lower", form: Form::Number(Range::Any), unit: "of the parameter", default: "-inf", example: "0.0", meaning: "Least value" },
    Key { name: "upper", form: Form::Number(Range::Any), unit: "of the parameter", default: "inf", example: "1.0", meaning: "Greatest value" },
    Key { name: "typical", form: Form::Number(Range::Finite), unit: "of the parameter", default: REQUIRED, example: "0.1", meaning: "Value from which estimates start, of a size at which it matters" },
    Key { name: "search", form: Form::Either(&[Form::List(&Form::Number(Range::Finite), Length::Some), Form::Words(cycles)]), unit: "of the parameter", default: "typical alone", example: "[4.0, 8.0, 16.0]", meaning: "Values from which a search starts; \"cycles\": from one cycle over the joint's range to what the sampling resolves" },
    Key { name: "share_of", form: Form::Words(words::<ShareOf>), unit: "", default: "none: the values themselves", example: "\"speed\"", meaning: "What the values of search are shares of: the way from the least to the greatest position, the range of positions, the greatest speed, one over it, or the duration" },
];

/// Keys of a file of laws.
#[rustfmt::skip]
pub(crate) const FILE_KEYS: &[Key] = &[
    Key { name: "law", form: Form::List(&Form::Table(KEYS), Length::Any), unit: "", default: "none", example: "", meaning: "The laws" },
];

/// Where a law acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActsOn {
    /// A torque that the motor exerts in addition.
    Motor,
    /// A torque at the joint, which an elastic gear passes on.
    Joint,
    /// What the signal shows beyond the torque of the motor.
    Signal,
    /// The true torque constant over the declared one.
    Gain,
}

impl Choice for ActsOn {
    const NOUN: &'static str = "place of a law";
    const CODE: &'static str = "unknown-place";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("motor", Self::Motor),
        ("joint", Self::Joint),
        ("signal", Self::Signal),
        ("gain", Self::Gain),
    ];
}

/// What values of a search are shares of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShareOf {
    /// Of the way from the least to the greatest position.
    Position,
    /// Of the range of positions.
    Range,
    /// Of the greatest speed.
    Speed,
    /// Multiples of one over the greatest speed.
    OverSpeed,
    /// Of the duration of the recording.
    Duration,
}

impl Choice for ShareOf {
    const NOUN: &'static str = "share";
    const CODE: &'static str = "unknown-share";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("position", Self::Position),
        ("range", Self::Range),
        ("speed", Self::Speed),
        ("over_speed", Self::OverSpeed),
        ("duration", Self::Duration),
    ];
}

/// One table `[[law]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct LawTable {
    /// Identifier in lists of effects and in results.
    pub id: Located<String>,
    /// One sentence of physics.
    pub sentence: Located<String>,
    /// Author, year and equation. Default: none.
    pub source: Option<Located<String>>,
    /// Default: [`ActsOn::Motor`].
    pub acts_on: Located<ActsOn>,
    /// The formula: N·m (N); of a gain a factor.
    pub torque: Located<String>,
    /// Rates of the states z1, z2, ... (of a single one: z). Default: no state.
    pub dz: Vec<Located<String>>,
    /// First values of the states. Default: zero.
    pub start: Vec<Located<String>>,
    /// Effects of which it refines one: without any of them it is not looked for. Default: none.
    pub refines: Vec<Located<String>>,
    /// By their names in the formulas.
    pub parameters: Vec<Named<LawParameter>>,
}

/// A parameter of a law.
#[derive(Debug, Clone, PartialEq)]
pub struct LawParameter {
    /// Default: none, and dimensions are not checked with it.
    pub unit: Option<String>,
    /// In a few words; may be empty.
    pub meaning: String,
    /// Least value, in its unit. Default: minus infinity.
    pub lower: f64,
    /// Greatest value. Default: infinity.
    pub upper: f64,
    /// A value of usual size, from which estimates start.
    pub typical: f64,
    /// Where a search for it starts.
    pub search: LawSearch,
}

/// Values from which a search for a parameter starts.
#[derive(Debug, Clone, PartialEq)]
pub enum LawSearch {
    /// From the typical value alone.
    Typical,
    /// Cycles over the range of the joint's positions, from one to what the sampling resolves.
    Cycles,
    /// From each of these, in the parameter's unit.
    Values(Vec<f64>),
    /// From each of these shares of something that the motion has.
    Shares(ShareOf, Vec<f64>),
}

const CYCLES: &str = "cycles";

fn cycles() -> Vec<&'static str> {
    vec![CYCLES]
}

impl LawTable {
    pub(super) fn from_node(node: &Node, context: &Context) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, KEYS)?;
        Ok(Self {
            id: reader.required("id", "give the law a name", values::text)?,
            sentence: reader.required("sentence", "say what it is", values::text)?,
            source: reader.optional("source", values::text)?,
            acts_on: reader.or("acts_on", ActsOn::Motor, values::choice)?,
            torque: reader.required("torque", "state its formula", values::text)?,
            dz: reader.list("dz", texts)?,
            start: reader.list("start", texts)?,
            refines: reader.list("refines", |n| values::effects(n, context))?,
            parameters: reader.named("parameters", LawParameter::from_node)?,
        })
    }
}

impl LawParameter {
    fn from_node(node: &Node) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, PARAMETER_KEYS)?;
        let share = reader.optional("share_of", values::choice::<ShareOf>)?;
        let search = match reader.node("search") {
            None => LawSearch::Typical,
            Some(node) => match &node.value {
                NodeValue::Text(word) if word == CYCLES => LawSearch::Cycles,
                _ => {
                    let expected = "a list of numbers, or \"cycles\"";
                    let items = values::items(node, expected)?;
                    let found = items.iter().map(values::finite);
                    let found = found.collect::<Result<Vec<_>, _>>()?;
                    let found = values::not_empty(found, node)?;
                    match &share {
                        None => LawSearch::Values(found),
                        Some(share) => LawSearch::Shares(share.value, found),
                    }
                }
            },
        };
        if let (Some(share), LawSearch::Typical | LawSearch::Cycles) = (&share, &search) {
            return Err(ProblemFileError::new(
                &share.place,
                KeyFault::Conflict {
                    found: "shares without values".into(),
                    remedy: "give search a list of shares, or leave share_of out".into(),
                },
            ));
        }
        let bound = |key: &str, default: f64| {
            let found = reader.or(key, default, values::not_nan)?;
            Ok::<f64, ProblemFileError>(found.value)
        };
        Ok(Self {
            unit: reader.optional("unit", values::text)?.map(|u| u.value),
            meaning: reader.or("meaning", String::new(), values::text)?.value,
            lower: bound("lower", f64::NEG_INFINITY)?,
            upper: bound("upper", f64::INFINITY)?,
            typical: reader
                .required(
                    "typical",
                    "give a value of a size at which it matters",
                    values::finite,
                )?
                .value,
            search,
        })
    }
}

/// A text, or a list of them.
fn texts(node: &Node) -> Result<Vec<Located<String>>, ProblemFileError> {
    let of = |node: &Node| {
        Ok(Located {
            value: values::text(node)?,
            place: node.place.clone(),
        })
    };
    match &node.value {
        NodeValue::List(items) => items.iter().map(of).collect(),
        _ => Ok(vec![of(node)?]),
    }
}

/// Puts the laws of the files and folders that `laws` names in front of those of the problem file: a result keeps them with
/// the problem.
pub(super) fn gather(root: &mut Node, folder: &Path) -> Result<(), ProblemFileError> {
    let NodeValue::Table(table) = &mut root.value else {
        return Ok(());
    };
    let Some(at) = table.entries.iter().position(|e| e.key == "laws") else {
        return Ok(());
    };
    let named = table.entries.remove(at);
    let context = Context {
        folder,
        effect_ids: &[],
    };
    let mut found = Vec::new();
    for node in values::items(
        &named.node,
        "a list of files or folders such as [\"laws/dahl.toml\"]",
    )? {
        let path = values::file_path(node, &context)?;
        for file in files(&path, &node.place)? {
            found.extend(laws_of(&file)?);
        }
    }
    match table.entries.iter_mut().find(|e| e.key == "law") {
        Some(entry) => {
            if let NodeValue::List(own) = &mut entry.node.value {
                found.append(own);
                *own = found;
            }
        }
        None => table.entries.push(Entry {
            key: "law".into(),
            place: named.place.clone(),
            node: Node {
                value: NodeValue::List(found),
                place: named.place,
            },
        }),
    }
    Ok(())
}

/// A file, or the TOML files of a folder by their names.
fn files(path: &FilePath, place: &Place) -> Result<Vec<PathBuf>, ProblemFileError> {
    if !path.resolved.is_dir() {
        return Ok(vec![path.resolved.clone()]);
    }
    let unreadable = |reason: String| {
        ProblemFileError::new(
            place,
            KeyFault::Conflict {
                found: format!(
                    "the folder {} cannot be read: {reason}",
                    path.resolved.display()
                ),
                remedy: "name a folder with files of laws".into(),
            },
        )
    };
    let entries = fs::read_dir(&path.resolved).map_err(|e| unreadable(e.to_string()))?;
    let mut files = Vec::new();
    for entry in entries {
        let file = entry.map_err(|e| unreadable(e.to_string()))?.path();
        if file
            .extension()
            .is_some_and(|extension| extension == "toml")
        {
            files.push(file);
        }
    }
    files.sort();
    match files.is_empty() {
        true => Err(unreadable("it holds no file that ends in .toml".into())),
        false => Ok(files),
    }
}

/// The tables of a file of laws.
fn laws_of(file: &Path) -> Result<Vec<Node>, ProblemFileError> {
    let text = document::read_text(file)?;
    let root = document::parse(file, &text)?;
    Ok(Reader::open(&root, FILE_KEYS)?.tables("law")?.to_vec())
}

/// The laws of a file or of the files of a folder, which may refine effects of these identifiers and each other's.
///
/// # Errors
/// As of a problem file: the first fault found, with file, line, column and key.
pub fn read(path: &Path, effect_ids: &[&str]) -> Result<Vec<LawTable>, ProblemFileError> {
    let place = Place::file(path);
    let path = FilePath {
        written: path.display().to_string(),
        resolved: path.to_path_buf(),
    };
    let mut nodes = Vec::new();
    for file in files(&path, &place)? {
        nodes.extend(laws_of(&file)?);
    }
    of_nodes(&nodes, effect_ids)
}

/// The laws of a problem that a result keeps.
///
/// # Errors
/// As of [`read`], without lines and columns.
pub fn kept(
    problem: &serde_json::Value,
    effect_ids: &[&str],
) -> Result<Vec<LawTable>, ProblemFileError> {
    let Some(laws) = problem.get("law") else {
        return Ok(Vec::new());
    };
    let node = Node::from_json(laws, Place::default().key("law"));
    of_nodes(values::items(&node, "a list of tables")?, effect_ids)
}

/// The laws of tables.
pub(super) fn of_nodes(
    nodes: &[Node],
    effect_ids: &[&str],
) -> Result<Vec<LawTable>, ProblemFileError> {
    let ids = ids_with(nodes, effect_ids);
    let context = Context {
        folder: Path::new(""),
        effect_ids: &ids,
    };
    let laws = nodes.iter().map(|node| LawTable::from_node(node, &context));
    let laws: Vec<LawTable> = laws.collect::<Result<_, _>>()?;
    for (k, law) in laws.iter().enumerate() {
        let earlier = laws[..k].iter().any(|other| other.id.value == law.id.value);
        if earlier || effect_ids.contains(&law.id.as_str()) {
            return Err(ProblemFileError::new(
                &law.id.place,
                KeyFault::Conflict {
                    found: format!("there is an effect \"{}\" already", law.id.value),
                    remedy: "give the law another id; `exid effects` lists those that are taken"
                        .into(),
                },
            ));
        }
    }
    Ok(laws)
}

/// Identifiers of effects and of laws, whatever else is wrong with these.
pub(super) fn ids_with<'a>(nodes: &'a [Node], effect_ids: &[&'a str]) -> Vec<&'a str> {
    let of = |node: &'a Node| match &node.value {
        NodeValue::Table(table) => match &table.get("id")?.value {
            NodeValue::Text(id) => Some(id.as_str()),
            _ => None,
        },
        _ => None,
    };
    let own = nodes.iter().filter_map(of);
    effect_ids.iter().copied().chain(own).collect()
}
