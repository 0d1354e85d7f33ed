//! Functions in a language, line by line: bindings, branches and loops over scalars and arrays of fixed size.

use crate::chain::effect::expression::Expression;
use crate::export::language::Language;

/// An argument of a function.
#[derive(Debug, Clone, Copy)]
pub enum Argument {
    Scalar(&'static str),
    /// Read, with its number of entries.
    Read(&'static str, usize),
    /// Written.
    Written(&'static str, usize),
}

impl Argument {
    pub fn name(self) -> &'static str {
        match self {
            Self::Scalar(name) | Self::Read(name, _) | Self::Written(name, _) => name,
        }
    }
}

/// Whether a function is for users or for its neighbours alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Visibility {
    Public,
    Private,
}

/// The head of a function.
#[derive(Debug, Clone, Copy)]
pub struct Head<'a> {
    pub name: &'a str,
    pub documentation: &'a str,
    pub arguments: &'a [Argument],
    pub visibility: Visibility,
}

/// A line of a body.
#[derive(Debug)]
enum Line {
    /// A value by name, which is left out where nothing reads it.
    Binding {
        name: String,
        text: String,
    },
    Other(String),
}

/// The body of a function while it is written.
#[derive(Debug)]
pub struct Body {
    pub language: Language,
    prefix: String,
    depth: usize,
    lines: Vec<Line>,
}

impl Body {
    pub fn new(language: Language, prefix: &str) -> Self {
        Self {
            language,
            prefix: prefix.to_string(),
            depth: 1,
            lines: Vec::new(),
        }
    }

    fn indented(&self, text: &str) -> String {
        format!("{}{text}", "    ".repeat(self.depth))
    }

    fn push(&mut self, text: &str) {
        let line = self.indented(text);
        self.lines.push(Line::Other(line));
    }

    /// A new value.
    pub fn bind(&mut self, name: &str, value: &Expression) -> Expression {
        let value = self.language.formula(value);
        let text = match self.language {
            Language::Rust => format!("let {name} = {value};"),
            Language::C => format!("const double {name} = {value};"),
            Language::NumPy => format!("{name} = {value}"),
        };
        let text = self.indented(&text);
        let name = name.to_string();
        self.lines.push(Line::Binding {
            name: name.clone(),
            text,
        });
        Expression::Name(name)
    }

    /// A new value that changes.
    pub fn variable(&mut self, name: &str, value: &Expression) -> Expression {
        let value = self.language.formula(value);
        self.push(&match self.language {
            Language::Rust => format!("let mut {name} = {value};"),
            Language::C => format!("double {name} = {value};"),
            Language::NumPy => format!("{name} = {value}"),
        });
        Expression::name(name)
    }

    /// A new array of zeros.
    pub fn array(&mut self, name: &str, size: usize) {
        self.push(&match self.language {
            Language::Rust => format!("let {name} = &mut [0.0_f64; {size}];"),
            // Laws may read none of it.
            Language::C => format!("double {name}[{size}] = {{0.0}}; (void){name};"),
            Language::NumPy => format!("{name} = [0.0] * {size}"),
        });
    }

    pub fn assign(&mut self, target: &str, value: &Expression) {
        let value = self.language.formula(value);
        let end = self.end_of_statement();
        self.push(&format!("{target} = {value}{end}"));
    }

    fn end_of_statement(&self) -> &'static str {
        match self.language {
            Language::NumPy => "",
            Language::Rust | Language::C => ";",
        }
    }

    /// A call of one of these functions.
    pub fn call(&mut self, function: &str, arguments: &[&str]) {
        let arguments = arguments.join(", ");
        self.push(&match self.language {
            Language::Rust => format!("{function}({arguments});"),
            Language::C => format!("{}_{function}({arguments});", self.prefix),
            Language::NumPy => format!("_{function}({arguments})"),
        });
    }

    /// A call of a helper.
    pub fn help(&mut self, function: &str, arguments: &[&str]) {
        let end = self.end_of_statement();
        self.push(&format!("{function}({}){end}", arguments.join(", ")));
    }

    /// Opens a loop over `0..count`.
    pub fn repeat(&mut self, counter: &str, count: usize) {
        self.push(&match self.language {
            Language::Rust => format!("for {counter} in 0..{count} {{"),
            Language::C => {
                format!("for (int {counter} = 0; {counter} < {count}; {counter}++) {{")
            }
            Language::NumPy => format!("for {counter} in range({count}):"),
        });
        self.depth += 1;
    }

    /// Opens a branch for `a < b`.
    pub fn if_less(&mut self, a: &Expression, b: &Expression) {
        let [a, b] = [a, b].map(|e| self.language.formula(e));
        self.push(&match self.language {
            Language::Rust => format!("if {a} < {b} {{"),
            Language::C => format!("if ({a} < {b}) {{"),
            Language::NumPy => format!("if {a} < {b}:"),
        });
        self.depth += 1;
    }

    pub fn otherwise(&mut self) {
        self.depth -= 1;
        self.push(match self.language {
            Language::Rust | Language::C => "} else {",
            Language::NumPy => "else:",
        });
        self.depth += 1;
    }

    /// Closes a loop or a branch.
    pub fn close(&mut self) {
        self.depth -= 1;
        if self.language != Language::NumPy {
            self.push("}");
        }
    }

    /// Leaves the loop.
    pub fn leave(&mut self) {
        let end = self.end_of_statement();
        self.push(&format!("break{end}"));
    }

    /// The lines without bindings that nothing behind them reads.
    fn text(&self) -> String {
        let mut kept: Vec<&str> = Vec::new();
        for line in self.lines.iter().rev() {
            match line {
                Line::Binding { name, text } => {
                    if kept.iter().any(|other| reads(other, name)) {
                        kept.push(text);
                    }
                }
                Line::Other(text) => kept.push(text),
            }
        }
        kept.iter().rev().map(|line| format!("{line}\n")).collect()
    }

    /// The function with this body.
    pub fn function(self, head: &Head<'_>) -> String {
        let text = self.text();
        let declared = self.declaration(head);
        let documentation = head.documentation;
        match self.language {
            Language::Rust => {
                let lines = documentation.replace('\n', "\n/// ");
                let names = head.arguments.iter().map(|a| format!("&{}", a.name()));
                let names = names.collect::<Vec<_>>().join(", ");
                format!(
                    "/// {lines}\n#[allow(unused_parens, clippy::all)]\n{declared} {{\n    \
                     let _ = ({names});\n{text}}}\n"
                )
            }
            Language::C => {
                let lines = documentation.replace('\n', "\n   ");
                let names = head.arguments.iter().map(|a| format!("(void){}", a.name()));
                let names = names.collect::<Vec<_>>().join(", ");
                format!("/* {lines} */\n{declared} {{\n    {names};\n{text}}}\n")
            }
            Language::NumPy => {
                let lines = documentation.replace('\n', "\n    ");
                format!("{declared}:\n    \"\"\"{lines}\"\"\"\n{text}    return None\n")
            }
        }
    }

    /// The head as the language declares it.
    pub fn declaration(&self, head: &Head<'_>) -> String {
        let name = head.name;
        match self.language {
            Language::Rust => {
                let arguments = head.arguments.iter().map(|argument| match argument {
                    Argument::Scalar(name) => format!("{name}: f64"),
                    Argument::Read(name, size) => format!("{name}: &[f64; {size}]"),
                    Argument::Written(name, size) => format!("{name}: &mut [f64; {size}]"),
                });
                let arguments = arguments.collect::<Vec<_>>().join(", ");
                let shown = match head.visibility {
                    Visibility::Public => "pub ",
                    Visibility::Private => "",
                };
                format!("{shown}fn {name}({arguments})")
            }
            Language::C => {
                let arguments = head.arguments.iter().map(|argument| match argument {
                    Argument::Scalar(name) => format!("double {name}"),
                    Argument::Read(name, size) => format!("const double {name}[{size}]"),
                    Argument::Written(name, size) => format!("double {name}[{size}]"),
                });
                let arguments = arguments.collect::<Vec<_>>().join(", ");
                let hidden = match head.visibility {
                    Visibility::Public => "",
                    Visibility::Private => "static ",
                };
                format!("{hidden}void {}_{name}({arguments})", self.prefix)
            }
            Language::NumPy => {
                let names = head.arguments.iter().map(|a| a.name());
                format!("def _{name}({})", names.collect::<Vec<_>>().join(", "))
            }
        }
    }
}

/// Whether a text holds a name that is not part of a longer one.
fn reads(text: &str, name: &str) -> bool {
    let is_letter = |c: char| c.is_ascii_alphanumeric() || c == '_';
    text.match_indices(name).any(|(at, _)| {
        let before = text[..at].chars().next_back();
        let after = text[at + name.len()..].chars().next();
        !before.is_some_and(is_letter) && !after.is_some_and(is_letter)
    })
}
