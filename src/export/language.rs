//! Rust and C, as far as straight lines of arithmetic need them.

/// A language of exported code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Language {
    Rust,
    C,
}

/// A number that both languages read back to the same bits.
pub fn number(value: f64) -> String {
    // The shortest decimal that reads back the same, always with a point or an exponent.
    format!("{value:?}")
}

impl Language {
    pub fn extension(self) -> &'static str {
        match self {
            Self::Rust => "rs",
            Self::C => "c",
        }
    }

    /// A new value.
    pub fn binding(self, name: &str, value: &str) -> String {
        match self {
            Self::Rust => format!("    let {name} = {value};\n"),
            Self::C => format!("    const double {name} = {value};\n"),
        }
    }

    pub fn sine(self, of: &str) -> String {
        self.call("sin", of)
    }

    pub fn cosine(self, of: &str) -> String {
        self.call("cos", of)
    }

    fn call(self, function: &str, of: &str) -> String {
        match self {
            Self::Rust => format!("{of}.{function}()"),
            Self::C => format!("{function}({of})"),
        }
    }

    /// The head of a function of position, velocity and acceleration that fills `out`, without its brace.
    /// Functions of C have no modules: their names begin with the robot's.
    pub fn head(self, function: &str, prefix: &str) -> String {
        match self {
            Self::Rust => format!(
                "pub fn {function}(\n    q: &[f64; JOINTS],\n    dq: &[f64; JOINTS],\n    \
                 ddq: &[f64; JOINTS],\n    out: &mut [f64; JOINTS],\n)"
            ),
            Self::C => {
                let size = format!("{}_JOINTS", prefix.to_uppercase());
                let array = |name: &str| format!("const double {name}[{size}]");
                format!(
                    "void {prefix}_{function}({}, {},\n    {}, double out[{size}])",
                    array("q"),
                    array("dq"),
                    array("ddq")
                )
            }
        }
    }

    /// A call of such a function with the arguments at hand.
    pub fn pass_on(self, function: &str, prefix: &str) -> String {
        match self {
            Self::Rust => format!("    {function}(q, dq, ddq, out);\n"),
            Self::C => format!("    {prefix}_{function}(q, dq, ddq, out);\n"),
        }
    }

    /// Arguments count as used.
    pub fn touch(self) -> &'static str {
        match self {
            Self::Rust => "    let _ = (q, dq, ddq);\n",
            Self::C => "    (void)q, (void)dq, (void)ddq;\n",
        }
    }

    /// A copy of `out` as `tau`.
    pub fn copy(self, prefix: &str) -> String {
        match self {
            Self::Rust => "    let tau = *out;\n".to_string(),
            Self::C => {
                let size = format!("{}_JOINTS", prefix.to_uppercase());
                format!(
                    "    double tau[{size}];\n    for (int k = 0; k < {size}; k++) tau[k] = out[k];\n"
                )
            }
        }
    }

    /// A comment in front of an item.
    pub fn documentation(self, lines: &[&str]) -> String {
        let mut text = String::new();
        match self {
            Self::Rust => lines
                .iter()
                .for_each(|l| text.push_str(&format!("/// {l}\n"))),
            Self::C => {
                text.push_str("/* ");
                text.push_str(&lines.join("\n   "));
                text.push_str(" */\n");
            }
        }
        text
    }

    /// Functions that formulas of laws use.
    pub fn helpers(self) -> &'static str {
        match self {
            Self::Rust => RUST_HELPERS,
            Self::C => C_HELPERS,
        }
    }
}

const RUST_HELPERS: &str = "\
/// v / (|v| + width), 0 at standstill.
#[allow(dead_code)]
#[inline]
fn sign(v: f64, width: f64) -> f64 {
    if v == 0.0 { 0.0 } else { v / (v.abs() + width) }
}
#[allow(dead_code)]
#[inline]
fn magnitude(x: f64) -> f64 {
    x.abs()
}
#[allow(dead_code)]
#[inline]
fn square(x: f64) -> f64 {
    x * x
}
#[allow(dead_code)]
#[inline]
fn exponential(x: f64) -> f64 {
    x.exp()
}
";

const C_HELPERS: &str = "\
/* v / (|v| + width), 0 at standstill. */
static inline double sign(double v, double width) { return v == 0.0 ? 0.0 : v / (fabs(v) + width); }
static inline double magnitude(double x) { return fabs(x); }
static inline double square(double x) { return x * x; }
static inline double exponential(double x) { return exp(x); }
";
