//! Formulas for what has no name: a short law in the variables of the motion that takes the place of a misfit, as a `[[law]]`.
//!
//! ```text
//! τ_f = Σ_k c_k Π_j g_kj(x_kj),   x of q, v, acc, tau of the joint, q and v of others
//! g of x, x², x³, |x|, x|x|, sign(v), exp(−|v|/s), max(q − q₀, 0), min(q − q₀, 0) and their squares, sin(n q + φ)
//!   and tanh(u), exp(−u²), 1/(1 + u²), u/(1 + u²) with u = (x − x₀)/s, exp(n x), sin(n x + φ), x beyond x₀ ± s,
//!   max(x − x₀, 0) + r min(x − x₀, 0), and x − x₀ of positions beside another factor
//! ```
//!
//! Where a smooth correction says of which few variables the misfit is a function, terms are all products of two shapes of these. Those
//! that physics has, of all variables, of the shapes of the first line and with waves of speeds and loads, are tried too, and then all
//! products of the variables of the best formula of these that has few.
//!
//! Terms are chosen one after the other by what they take from the fitted rows beyond what every parameter of the model can
//! take (orthogonal matching pursuit: Pati, Rezaiifar and Krishnaprasad 1993), several formulas at a time; their orders, touches and
//! scales are refined, and factors are dropped, exchanged and added (symbolic regression: Schmidt and Lipson 2009). What is left is
//! looked at in all channels, as a law bends parameters that several of them have. Each parameter is charged as by Schwarz (1978),
//! and each term with the number of those that it was chosen from (Chen and Chen 2008).
//! The foremost formulas are built as laws of one's own and fitted with all parameters of the model, to the fitted rows and those
//! that choose models. How well parts of these are forecast from the others puts them in order (cross-validation: Stone 1974), fewer
//! variables before more where these take hardly more, and the first that rows confirm which no choice has seen, against nothing and
//! against a smooth correction, is proposed.

pub mod dissipation;
pub mod factor;
pub mod grammar;
pub mod law;
pub mod named;
pub mod proposal;
pub mod rows;
pub mod search;
pub mod seeking;
pub mod solved;
pub mod term;
pub mod units;
pub mod words;
