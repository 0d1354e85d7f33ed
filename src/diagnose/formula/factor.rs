//! Factors of formulas: functions of one variable of the motion, as physics has them.

use crate::diagnose::formula::rows::FittedRows;
use crate::diagnose::residuals::quantity::Quantity;

/// What a factor does with its variable x; x₀, s and n are its own parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Shape {
    /// x, x² or x³.
    Power(u8),
    /// |x|
    Magnitude,
    /// x |x|
    SignedSquare,
    /// `v/(|v| + w)` with the transition speed w of the joint.
    Direction,
    /// exp(−|x|/s)
    Decay,
    /// tanh((x − x₀)/s)
    Saturation,
    /// exp(−((x − x₀)/s)²)
    Bump,
    /// 1/(1 + ((x − x₀)/s)²), a resonance.
    Resonance,
    /// (x − x₀)/s/(1 + ((x − x₀)/s)²), what eddy currents brake with (Kloss's formula).
    Breakdown,
    /// exp(n x)
    Exponential,
    /// x − x₀, beside other factors: alone it is x and an offset.
    Shifted,
    /// max(x − x₀, 0), or its square.
    Above(u8),
    /// min(x − x₀, 0), or its square.
    Below(u8),
    /// max(x − x₀, 0) + r min(x − x₀, 0)
    Slopes,
    /// x − x₀ less ±s where it is more than s, and nothing within.
    DeadZone,
    /// sin(n x + φ)
    Wave,
    /// sin(n x)
    Sine,
    /// cos(n x)
    Cosine,
}

/// A function of one variable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factor {
    pub quantity: Quantity,
    pub shape: Shape,
    /// x₀, s or n; 0 where the shape has none.
    pub inner: f64,
    /// x₀ of a shape that has a scale too.
    pub centre: f64,
}

impl Shape {
    /// Whether it has a parameter of its own.
    pub fn has_inner(self) -> bool {
        !matches!(
            self,
            Self::Power(_) | Self::Magnitude | Self::SignedSquare | Self::Direction
        )
    }

    /// Whether it repeats.
    pub fn is_periodic(self) -> bool {
        matches!(self, Self::Wave | Self::Sine | Self::Cosine)
    }

    /// Whether it is a transition or a peak of some width.
    pub fn has_width(self) -> bool {
        Self::OF_WIDTHS.contains(&self)
    }

    /// Those that are.
    pub const OF_WIDTHS: [Self; 4] = [
        Self::Saturation,
        Self::Bump,
        Self::Resonance,
        Self::Breakdown,
    ];

    /// The two functions of a sum of which the shares are to be found.
    fn summands(self) -> Option<[Self; 2]> {
        match self {
            Self::Wave => Some([Self::Sine, Self::Cosine]),
            Self::Slopes => Some([Self::Above(1), Self::Below(1)]),
            _ => None,
        }
    }

    /// Whether it is such a sum.
    pub fn is_sum(self) -> bool {
        self.summands().is_some()
    }

    /// Whether it changes its sign with its variable; what is neither odd nor even does not.
    pub fn is_odd(self) -> bool {
        matches!(
            self,
            Self::Power(1 | 3)
                | Self::SignedSquare
                | Self::Direction
                | Self::Saturation
                | Self::Breakdown
                | Self::DeadZone
                | Self::Sine
        )
    }

    /// Power of the unit of its variable in its own.
    pub fn power(self) -> i8 {
        match self {
            Self::Power(n) | Self::Above(n) | Self::Below(n) => n as i8,
            Self::Magnitude | Self::Shifted | Self::Slopes | Self::DeadZone => 1,
            Self::SignedSquare => 2,
            Self::Direction
            | Self::Decay
            | Self::Wave
            | Self::Sine
            | Self::Cosine
            | Self::Saturation
            | Self::Bump
            | Self::Resonance
            | Self::Breakdown
            | Self::Exponential => 0,
        }
    }
}

impl Factor {
    /// A factor without a parameter of its own.
    pub fn plain(quantity: Quantity, shape: Shape) -> Self {
        Self {
            quantity,
            shape,
            inner: 0.0,
            centre: 0.0,
        }
    }

    pub fn with_inner(self, inner: f64) -> Self {
        Self { inner, ..self }
    }

    pub fn about(self, centre: f64) -> Self {
        Self { centre, ..self }
    }

    /// Whether x₀ is its own parameter: speeds and loads have their zero.
    pub fn has_centre(&self) -> bool {
        self.quantity.is_position() && (self.shape.has_width() || self.shape == Shape::DeadZone)
    }

    /// The same function of the same variable, whatever its parameter.
    pub fn is_like(&self, other: &Self) -> bool {
        self.quantity == other.quantity && self.shape == other.shape
    }

    /// Multiplies series by it: one, or of a sum either function.
    pub fn multiply(&self, rows: &FittedRows, columns: &mut Vec<Vec<f64>>) {
        let Some([first, second]) = self.shape.summands() else {
            columns
                .iter_mut()
                .for_each(|column| self.times(rows, self.shape, column));
            return;
        };
        let mut other = columns[0].clone();
        self.times(rows, first, &mut columns[0]);
        self.times(rows, second, &mut other);
        columns.push(other);
    }

    fn times(&self, rows: &FittedRows, shape: Shape, column: &mut [f64]) {
        let x = match shape {
            Shape::Direction => &rows.direction,
            _ => rows.series(self.quantity),
        };
        let of = self.function(shape);
        column.iter_mut().zip(x).for_each(|(c, x)| *c *= of(*x));
    }

    fn function(&self, shape: Shape) -> impl Fn(f64) -> f64 {
        let (a, centre) = (self.inner, self.centre);
        move |x: f64| match shape {
            Shape::Power(n) => x.powi(i32::from(n)),
            Shape::Magnitude => x.abs(),
            Shape::SignedSquare => x * x.abs(),
            Shape::Direction => x,
            Shape::Decay => (-x.abs() / a).exp(),
            Shape::Saturation => ((x - centre) / a).tanh(),
            Shape::Bump => (-((x - centre) / a).powi(2)).exp(),
            Shape::Resonance => 1.0 / (1.0 + ((x - centre) / a).powi(2)),
            Shape::Breakdown => (x - centre) / a / (1.0 + ((x - centre) / a).powi(2)),
            Shape::Exponential => (a * x).exp(),
            Shape::Shifted => x - a,
            Shape::Above(n) => (x - a).max(0.0).powi(i32::from(n)),
            Shape::Below(n) => (x - a).min(0.0).powi(i32::from(n)),
            Shape::Slopes => x - a,
            Shape::DeadZone => (x - centre - a).max(0.0) + (x - centre + a).min(0.0),
            Shape::Wave | Shape::Sine => (a * x).sin(),
            Shape::Cosine => (a * x).cos(),
        }
    }
}
