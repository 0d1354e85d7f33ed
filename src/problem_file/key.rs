//! The keys of a problem file: what each one is, in which form and unit, what holds where it is absent, and an example.
//!
//! The tables of keys stand with the readers of their sections. A reader refuses a key that is not in its table, so the
//! schema and the reference that are made from the tables hold every key there is.

use crate::problem_file::choices::Choice;

/// One key of a table.
#[derive(Debug)]
pub struct Key {
    /// As it stands in the file.
    pub name: &'static str,
    /// What its value has to be.
    pub form: Form,
    /// In words, with that of sliding joints in brackets; empty where there is none.
    pub unit: &'static str,
    /// What holds where the key is absent: a value of TOML, or words. [`REQUIRED`] where it may not be absent.
    pub default: &'static str,
    /// A value of TOML; empty for a table, whose own keys have examples.
    pub example: &'static str,
    /// In a few words, as the reference shows it.
    pub meaning: &'static str,
}

/// The default of a key that has to be given.
pub const REQUIRED: &str = "required";

/// What a value has to be.
#[derive(Debug)]
pub enum Form {
    /// Not blank.
    Text,
    /// A file's path, which starts from the problem file's folder unless it is absolute.
    File,
    /// true or false.
    Boolean,
    /// A number in a range.
    Number(Range),
    /// A number for all joints, or a list with one for each.
    PerJoint(Range),
    /// A whole number from this one to a million.
    Count(usize),
    /// One of these words.
    Words(fn() -> Vec<&'static str>),
    /// The identifier of an effect.
    Effect,
    /// A list of values of one form.
    List(&'static Form, Length),
    /// A table with these keys.
    Table(&'static [Key]),
    /// A table whose keys are names, perhaps with dots: of joints, parameters or files.
    Named(&'static Form),
    /// A table of tables with these keys, each under the name of a joint.
    NamedTables(&'static [Key]),
    /// One of several forms.
    Either(&'static [Form]),
}

/// Which numbers are allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Range {
    /// Infinity too.
    Any,
    /// Not infinite.
    Finite,
    /// Finite and above zero.
    Positive,
    /// Finite and not below zero.
    NonNegative,
    /// Finite and not zero.
    Nonzero,
    /// 0 <= x < 1.
    Correlation,
    /// 0 < x < 1.
    Probability,
}

/// How many entries a list has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Length {
    /// Any number, none included.
    Any,
    /// No entry twice.
    Distinct,
    /// No entry twice, and at least one.
    SomeDistinct,
    /// No entry twice, and at least two.
    SeveralDistinct,
    /// At least one.
    Some,
    /// So many.
    Exactly(usize),
    /// One or two.
    OneOrTwo,
    /// Two, and not the same.
    TwoDistinct,
}

/// The words of a choice.
pub fn words<C: Choice>() -> Vec<&'static str> {
    C::WORDS.iter().map(|(word, _)| *word).collect()
}

impl Form {
    /// The keys of the tables of this form; of several forms, those of the one that has most.
    fn keys(&self) -> &'static [Key] {
        match self {
            Self::Table(keys) | Self::NamedTables(keys) => keys,
            Self::List(item, _) | Self::Named(item) => item.keys(),
            Self::Either(forms) => {
                let tables = forms.iter().map(Self::keys);
                tables.max_by_key(|keys| keys.len()).unwrap_or(&[])
            }
            _ => &[],
        }
    }
}

/// A table of keys and where it stands.
pub struct Section {
    /// Parts of its path, `["recordings", "columns"]`; none at the top.
    pub path: Vec<&'static str>,
    /// How the table is written, `[[fit.compare]]`; empty at the top.
    pub header: String,
    /// Its keys.
    pub keys: &'static [Key],
}

/// Every table with fixed keys: the top level, then each with those below it.
pub fn sections(keys: &'static [Key]) -> Vec<Section> {
    let mut found = vec![Section {
        path: Vec::new(),
        header: String::new(),
        keys,
    }];
    descend(&[], keys, &mut found);
    found
}

/// Tables of one level come before those below them, so that a table which stands at several places has the path of the
/// highest.
fn descend(path: &[&'static str], keys: &'static [Key], found: &mut Vec<Section>) {
    let first = found.len();
    for key in keys {
        let below = key.form.keys();
        // The forms of a column are alike: those of positions stand for all.
        if below.is_empty() || found.iter().any(|s| std::ptr::eq(s.keys, below)) {
            continue;
        }
        let path = [path, &[key.name]].concat();
        let dotted = path.join(".");
        let header = match &key.form {
            Form::List(..) => format!("[[{dotted}]]"),
            Form::Named(_) | Form::NamedTables(_) => format!("[{dotted}.NAME]"),
            _ => format!("[{dotted}]"),
        };
        found.push(Section {
            path,
            header,
            keys: below,
        });
    }
    for k in first..found.len() {
        let (path, below) = (found[k].path.clone(), found[k].keys);
        descend(&path, below, found);
    }
}

/// Whether a table, by the parts of its path, is one whose keys are names with dots.
pub fn is_table_of_names(keys: &'static [Key], path: &[String]) -> bool {
    let Some((first, rest)) = path.split_first() else {
        return false;
    };
    let Some(key) = keys.iter().find(|key| key.name == first) else {
        return false;
    };
    match (&key.form, rest) {
        (Form::Named(_), []) => true,
        (Form::NamedTables(_), _) => false,
        (form, rest) => is_table_of_names(form.keys(), rest),
    }
}
