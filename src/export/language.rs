//! Rust, C and Python with NumPy, as far as laws of robots need them.

use crate::chain::effect::expression::{Expression, Function, Operator};

/// A language of exported code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Language {
    Rust,
    C,
    NumPy,
}

impl Language {
    pub fn extension(self) -> &'static str {
        match self {
            Self::Rust => "rs",
            Self::C => "c",
            Self::NumPy => "py",
        }
    }

    /// A number that reads back to the same bits.
    pub fn number(self, value: f64) -> String {
        if value.is_finite() {
            // The shortest decimal that reads back the same, always with a point or an exponent.
            return format!("{value:?}");
        }
        let word = match (self, value.is_nan()) {
            (Self::Rust, true) => "f64::NAN",
            (Self::Rust, false) => "f64::INFINITY",
            (Self::C, true) => "NAN",
            (Self::C, false) => "INFINITY",
            (Self::NumPy, true) => "np.nan",
            (Self::NumPy, false) => "np.inf",
        };
        let sign = if value < 0.0 { "-" } else { "" };
        format!("{sign}{word}")
    }

    /// A formula of names and numbers.
    pub fn formula(self, of: &Expression) -> String {
        match of {
            Expression::Number(value) => self.number(*value),
            Expression::Name(name) => name.clone(),
            // Written by an effect, and replaced by who writes the program.
            Expression::Parameter(position) => format!("p[{position}]"),
            Expression::Variable(variable) => format!("{variable:?}").to_lowercase(),
            Expression::Negative(of) => format!("-{}", self.operand(of)),
            Expression::Binary(operator, pair) => {
                let sign = match operator {
                    Operator::Sum => "+",
                    Operator::Difference => "-",
                    Operator::Product => "*",
                    Operator::Quotient => "/",
                };
                let [a, b] = [0, 1].map(|k| self.operand(&pair[k]));
                format!("{a} {sign} {b}")
            }
            Expression::Call(function, of) => {
                let of: Vec<String> = of.iter().map(|e| self.formula(e)).collect();
                format!("{}({})", self.function(*function), of.join(", "))
            }
            Expression::Less(four) => {
                let [a, b, then, otherwise] = [0, 1, 2, 3].map(|k| self.operand(&four[k]));
                match self {
                    Self::Rust => format!("if {a} < {b} {{ {then} }} else {{ {otherwise} }}"),
                    Self::C => format!("{a} < {b} ? {then} : {otherwise}"),
                    Self::NumPy => format!("{then} if {a} < {b} else {otherwise}"),
                }
            }
        }
    }

    fn operand(self, of: &Expression) -> String {
        let text = self.formula(of);
        let alone = match of {
            Expression::Number(value) => value.is_sign_positive(),
            Expression::Name(_)
            | Expression::Parameter(_)
            | Expression::Variable(_)
            | Expression::Call(..) => true,
            _ => false,
        };
        if alone { text } else { format!("({text})") }
    }

    fn function(self, function: Function) -> &'static str {
        let [rust, c, numpy] = match function {
            Function::Sine => ["f64::sin", "sin", "np.sin"],
            Function::Cosine => ["f64::cos", "cos", "np.cos"],
            Function::Exponential => ["f64::exp", "exp", "np.exp"],
            Function::Logarithm => ["f64::ln", "log", "np.log"],
            Function::HyperbolicTangent => ["f64::tanh", "tanh", "np.tanh"],
            Function::Magnitude => ["f64::abs", "fabs", "np.abs"],
            Function::SquareRoot => ["f64::sqrt", "sqrt", "np.sqrt"],
            Function::Signum => ["direction", "direction", "np.sign"],
            Function::Power => ["f64::powf", "pow", "np.power"],
            Function::Smaller => ["f64::min", "fmin", "np.minimum"],
            Function::Larger => ["f64::max", "fmax", "np.maximum"],
        };
        match self {
            Self::Rust => rust,
            Self::C => c,
            Self::NumPy => numpy,
        }
    }

    /// Functions that formulas of laws use.
    pub fn helpers(self) -> &'static str {
        match self {
            Self::Rust => RUST_HELPERS,
            Self::C => C_HELPERS,
            Self::NumPy => NUMPY_HELPERS,
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
/// sgn x, 0 at 0.
#[allow(dead_code)]
#[inline]
fn direction(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}
/// Solves n equations by elimination with pivots; `right` becomes the solution.
#[allow(dead_code)]
fn solve(n: usize, matrix: &mut [f64], right: &mut [f64]) {
    for k in 0..n {
        let mut best = k;
        for r in k + 1..n {
            if matrix[r * n + k].abs() > matrix[best * n + k].abs() {
                best = r;
            }
        }
        if best != k {
            for c in 0..n {
                matrix.swap(k * n + c, best * n + c);
            }
            right.swap(k, best);
        }
        for r in k + 1..n {
            let factor = matrix[r * n + k] / matrix[k * n + k];
            for c in k..n {
                matrix[r * n + c] -= factor * matrix[k * n + c];
            }
            right[r] -= factor * right[k];
        }
    }
    for k in (0..n).rev() {
        for c in k + 1..n {
            right[k] -= matrix[k * n + c] * right[c];
        }
        right[k] /= matrix[k * n + k];
    }
}
/// Sum of squares.
#[allow(dead_code)]
fn squares(n: usize, x: &[f64]) -> f64 {
    x[..n].iter().map(|x| x * x).sum()
}
";

const C_HELPERS: &str = "\
#if defined(__GNUC__)
#define EXID_HELPER static __attribute__((unused))
#else
#define EXID_HELPER static
#endif
/* v / (|v| + width), 0 at standstill. */
EXID_HELPER double sign(double v, double width) { return v == 0.0 ? 0.0 : v / (fabs(v) + width); }
/* sgn x, 0 at 0. */
EXID_HELPER double direction(double x) { return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : 0.0; }
/* Solves n equations by elimination with pivots; right becomes the solution. */
EXID_HELPER void solve(int n, double *matrix, double *right) {
    for (int k = 0; k < n; k++) {
        int best = k;
        for (int r = k + 1; r < n; r++)
            if (fabs(matrix[r * n + k]) > fabs(matrix[best * n + k])) best = r;
        for (int c = 0; c < n; c++) {
            const double held = matrix[k * n + c];
            matrix[k * n + c] = matrix[best * n + c];
            matrix[best * n + c] = held;
        }
        const double held = right[k];
        right[k] = right[best];
        right[best] = held;
        for (int r = k + 1; r < n; r++) {
            const double factor = matrix[r * n + k] / matrix[k * n + k];
            for (int c = k; c < n; c++) matrix[r * n + c] -= factor * matrix[k * n + c];
            right[r] -= factor * right[k];
        }
    }
    for (int k = n - 1; k >= 0; k--) {
        for (int c = k + 1; c < n; c++) right[k] -= matrix[k * n + c] * right[c];
        right[k] /= matrix[k * n + k];
    }
}
/* Sum of squares. */
EXID_HELPER double squares(int n, const double *x) {
    double sum = 0.0;
    for (int k = 0; k < n; k++) sum += x[k] * x[k];
    return sum;
}
";

const NUMPY_HELPERS: &str = "\
def sign(v, width):
    \"\"\"v / (|v| + width), 0 at standstill.\"\"\"
    size = np.abs(v) + width
    return v / np.where(size == 0.0, 1.0, size)


def solve(n, matrix, right):
    \"\"\"Solves n equations; right becomes the solution.\"\"\"
    right[:] = np.linalg.solve(np.reshape(matrix, (n, n)), right).tolist()


def squares(n, x):
    \"\"\"Sum of squares.\"\"\"
    return sum(v * v for v in x[:n])
";
