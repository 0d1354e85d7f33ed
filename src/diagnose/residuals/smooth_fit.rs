//! Smooth functions that take what a model leaves of a channel, chosen by cross-validation over the rows that were fitted.
//!
//! ```text
//! min_{δ, a} ‖r + J δ − C a‖² + aᵀ Λ a,   δ = B a,   B = (JᵀJ)⁻¹ Jᵀ C,   C⊥ = C − J B
//! ```
//!
//! with the hat functions C of the smooth functions in one channel, and the residual r of all channels, which is orthogonal to the
//! derivatives J of the model. A fold of successive rows is forecast by the factors a of the others; which functions are taken, and
//! how stiff each is, is what forecasts all folds best (Stone 1974; Burman, Chow and Nolan 1994 of rows that remember). C⊥ holds motions
//! alone, so that no signal of a fold is in what forecasts it but by the model.

use crate::diagnose::residuals::covariates::Covariates;
use crate::diagnose::residuals::effect_size::MATTERS;
use crate::diagnose::residuals::folds::{Apart, FoldedModel, HatProducts};
use crate::diagnose::residuals::hats::{Arguments, HatRows, Hats};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Functions at most.
const MOST: usize = 3;

/// Functions of which the stiffness is sought, the best of all with a usual one.
const CLOSER: usize = 6;

/// Ridge as a share of the mean square of a hat: what the rows do not determine stays at zero.
const RIDGE: f64 = 1e-4;

/// Weights of the roughness of functions, as shares of the mean square of a hat.
const STIFFNESSES: [f64; 6] = [1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0];

/// With which functions are compared first.
const USUAL_STIFFNESS: f64 = STIFFNESSES[3];

/// A channel of which smooth functions take what is left.
pub struct FoldedChannel<'a> {
    /// Its number.
    pub channel: usize,
    /// Of its joint, over the same rows.
    pub covariates: &'a Covariates,
    /// The model.
    pub model: &'a FoldedModel<'a>,
}

/// A smooth function along the rows.
struct Function {
    hats: Hats,
    rows: HatRows,
    roughness: DMatrix<f64>,
}

/// Functions, each with its stiffness.
struct Stiffened<'f> {
    functions: Vec<&'f Function>,
    products: Vec<HatProducts>,
    penalty: DMatrix<f64>,
    /// Mean square of what is left of folds that the others forecast, in units of the deviation of the channel.
    error: f64,
}

/// Functions that forecast better than fewer.
pub struct Chosen {
    /// At their best beside all parameters of the model, and beside the model as it is.
    pub both: [Smoothed; 2],
    /// Twice the logarithm of how many times likelier they make the folds that others forecast.
    pub gain: f64,
}

/// Functions of which the last may be of any stiffness.
struct Open<'f> {
    functions: Vec<&'f Function>,
    products: Vec<HatProducts>,
    /// Of those before the last.
    penalty: DMatrix<f64>,
    /// Mean square of a hat of the last.
    mean_square: f64,
    /// Products of C⊥ over all channels, by fold.
    fitted: Vec<Apart>,
    /// The same over its own channel.
    own: Vec<Apart>,
}

/// Smooth functions and the change of the model's unknowns beside them.
#[derive(Debug, Clone)]
pub struct Smoothed {
    /// The functions.
    pub functions: Vec<Hats>,
    /// Factors a of their hats, one function after the other.
    pub factors: DVector<f64>,
    /// δ.
    pub step: DVector<f64>,
}

impl Smoothed {
    /// What its functions are of.
    pub fn arguments(&self) -> Vec<Arguments> {
        self.functions.iter().map(|hats| hats.of).collect()
    }

    /// What they take of a residual `ŝ − s`: their values, less what the changed unknowns add, by the derivatives of the channel.
    pub fn at(&self, covariates: &Covariates, derivatives: &[Option<Vec<f64>>]) -> Vec<f64> {
        let mut taken = vec![0.0; covariates.direction.len()];
        let mut start = 0;
        for hats in &self.functions {
            let rows = hats.along(covariates);
            let own = self.factors.rows(start, rows.width);
            rows.add(own.as_slice(), &mut taken);
            start += rows.width;
        }
        let shift = self.shift(derivatives, taken.len());
        taken.iter_mut().zip(shift).for_each(|(x, by)| *x -= by);
        taken
    }

    /// What the changed unknowns add to a residual, by its derivatives.
    pub fn shift(&self, derivatives: &[Option<Vec<f64>>], rows: usize) -> Vec<f64> {
        let mut shift = vec![0.0; rows];
        for (column, step) in derivatives.iter().zip(self.step.iter()) {
            let rows = column.iter().flatten().zip(&mut shift);
            rows.for_each(|(j, x)| *x += step * j);
        }
        shift
    }
}

impl FoldedChannel<'_> {
    /// Functions of some covariates that forecast what the model leaves, one more each time for as long as that lowers the error by
    /// what matters: the last ones forecast best. Beside all parameters of the model, and beside the model as it is.
    pub fn smoothed(&self, candidates: &[Arguments]) -> Vec<Chosen> {
        let functions: Vec<Function> = candidates.iter().map(|of| self.function(*of)).collect();
        let mut chosen = self.nothing();
        let nothing = chosen.error;
        let mut all = Vec::new();
        for _ in 0..MOST {
            let next = self.grown(&chosen, &functions);
            let least = chosen.error * (1.0 - MATTERS).powi(2);
            match next.filter(|next| next.error < least) {
                Some(next) => chosen = next,
                None => break,
            }
            all.push(Chosen {
                gain: self.rows() * (nothing / chosen.error).ln(),
                both: self.both(&chosen),
            });
        }
        all
    }

    fn function(&self, of: Arguments) -> Function {
        let hats = Hats::of(of, self.covariates);
        Function {
            rows: hats.along(self.covariates),
            roughness: hats.roughness(),
            hats,
        }
    }

    fn rows(&self) -> f64 {
        self.covariates.direction.len().max(1) as f64
    }

    /// The model as it is.
    fn nothing<'f>(&self) -> Stiffened<'f> {
        let folds = self.model.of_channel(self.channel).iter();
        Stiffened {
            functions: Vec::new(),
            products: self.model.nothing(),
            penalty: DMatrix::zeros(0, 0),
            error: folds.map(|fold| fold.residual).sum::<f64>() / self.rows(),
        }
    }

    /// With the function more that forecasts best.
    fn grown<'f>(&self, known: &Stiffened<'f>, functions: &'f [Function]) -> Option<Stiffened<'f>> {
        let is_new = |f: &&Function| known.functions.iter().all(|k| k.hats.of != f.hats.of);
        let new: Vec<&Function> = functions.iter().filter(is_new).collect();
        // Products of all candidates at once would be hundreds of megabytes.
        let usual = |f: &&'f Function| {
            let error = self.error(&self.with(known, f), USUAL_STIFFNESS)?;
            Some((error, *f))
        };
        let mut ranked: Vec<(f64, &Function)> = new.par_iter().filter_map(usual).collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        ranked.truncate(CLOSER);
        let stiffened = ranked.into_par_iter().filter_map(|(_, function)| {
            let open = self.with(known, function);
            let errors = STIFFNESSES.into_iter().filter_map(|stiffness| {
                let error = self.error(&open, stiffness)?;
                Some((error, stiffness))
            });
            let (error, stiffness) = errors.min_by(|a, b| a.0.total_cmp(&b.0))?;
            Some(Stiffened {
                penalty: open.penalty(stiffness),
                functions: open.functions,
                products: open.products,
                error,
            })
        });
        stiffened.min_by(|a, b| a.error.total_cmp(&b.error))
    }

    /// Known functions and one more.
    fn with<'f>(&self, known: &Stiffened<'f>, function: &'f Function) -> Open<'f> {
        let before: Vec<&HatRows> = known.functions.iter().map(|f| &f.rows).collect();
        let products = self
            .model
            .with(self.channel, &known.products, &before, &function.rows);
        let squares = |products: &[HatProducts]| -> f64 {
            products.iter().map(|p| p.square.diagonal().sum()).sum()
        };
        let own_squares = squares(&products) - squares(&known.products);
        let steps = self.model.steps(&products);
        let own = products.iter().zip(self.model.of_channel(self.channel));
        Open {
            functions: [&known.functions[..], &[function]].concat(),
            penalty: known.penalty.clone(),
            mean_square: own_squares / function.rows.width as f64,
            fitted: self.model.apart(&products, &steps),
            own: own.map(|(p, own)| p.apart(&steps, own)).collect(),
            products,
        }
    }

    /// Mean square of what is left of each fold by the factors of the others.
    fn error(&self, open: &Open<'_>, stiffness: f64) -> Option<f64> {
        let penalty = open.penalty(stiffness);
        let whole = Apart::sum(&open.fitted);
        let mut left = 0.0;
        for (k, fold) in self.model.of_channel(self.channel).iter().enumerate() {
            let factor = (&whole.square - &open.fitted[k].square + &penalty).cholesky()?;
            let factors = factor.solve(&(&whole.right - &open.fitted[k].right));
            let own = &open.own[k];
            left += fold.residual - 2.0 * factors.dot(&own.right)
                + factors.dot(&(&own.square * &factors));
        }
        Some(left / self.rows())
    }

    /// Functions at their best, where the unknowns change by so much for each hat.
    fn at_best(&self, chosen: &Stiffened<'_>, steps: &DMatrix<f64>) -> Smoothed {
        let whole = Apart::sum(&self.model.apart(&chosen.products, steps));
        let factor = (&whole.square + &chosen.penalty).cholesky();
        let factors = factor.map_or_else(
            || DVector::zeros(whole.right.len()),
            |factor| factor.solve(&whole.right),
        );
        Smoothed {
            functions: chosen.functions.iter().map(|f| f.hats.clone()).collect(),
            step: steps * &factors,
            factors,
        }
    }

    /// Beside all parameters of the model, and beside the model as it is: what one motion does not tell of the parameters is wrong in
    /// others.
    fn both(&self, chosen: &Stiffened<'_>) -> [Smoothed; 2] {
        let steps = self.model.steps(&chosen.products);
        let none = DMatrix::zeros(steps.nrows(), steps.ncols());
        [steps, none].map(|steps| self.at_best(chosen, &steps))
    }
}

impl Open<'_> {
    /// Λ with a stiffness of the last function.
    fn penalty(&self, stiffness: f64) -> DMatrix<f64> {
        let before = self.penalty.nrows();
        let total = self.products[0].square.nrows();
        let width = total - before;
        let mut penalty = self.penalty.clone().resize(total, total, 0.0);
        if let Some(last) = self.functions.last() {
            let own = DMatrix::identity(width, width) * RIDGE + &last.roughness * stiffness;
            let mut corner = penalty.view_mut((before, before), (width, width));
            corner.copy_from(&(own * self.mean_square));
        }
        penalty
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::fit::linear_model::LinearModel;
    use crate::diagnose::residuals::covariates::Covariate;
    use crate::robot::random::{generator, symmetric};

    const ROWS: usize = 2000;

    fn drawn(seed: u64, size: f64) -> Vec<f64> {
        let mut rng = generator(seed);
        (0..ROWS).map(|_| symmetric(&mut rng, size)).collect()
    }

    /// Variables x0 to x3 over rows of their own.
    fn covariates() -> Covariates {
        let variable = |k: usize| Covariate {
            name: format!("x{k}"),
            unit: "",
            values: drawn(k as u64, 1.0),
            by_direction: false,
            other: None,
            made_of: Vec::new(),
            is_state: true,
        };
        Covariates {
            variables: (0..4).map(variable).collect(),
            direction: vec![1.0; ROWS],
        }
    }

    /// Two channels that share three unknowns; what they leave is orthogonal to their derivatives, as after a fit.
    fn fitted(left: [Vec<f64>; 2], first: &Covariates) -> LinearModel {
        let x = |k: usize| first.variables[k].values.clone();
        // What the second unknown takes of a function of x1 it adds as a function of x3.
        let second = x(1).iter().zip(x(3)).map(|(a, b)| a + b).collect();
        let own = [x(0), second, drawn(21, 1.0)];
        let other = [drawn(22, 0.5), drawn(23, 0.5), drawn(24, 0.5)];
        let stacked = |a: &[f64], b: &[f64]| DVector::from_vec([a, b].concat());
        let pairs: Vec<DVector<f64>> = own.iter().zip(&other).map(|(a, b)| stacked(a, b)).collect();
        let jacobian = DMatrix::from_columns(&pairs);
        let whole = stacked(&left[0], &left[1]);
        let solved = jacobian.clone().svd(true, true).solve(&whole, 1e-12);
        let residual = &whole - &jacobian * solved.unwrap();
        let [a, b] = [0, ROWS].map(|start| residual.rows(start, ROWS).as_slice().to_vec());
        LinearModel::of_columns(
            vec![own.map(Some).to_vec(), other.map(Some).to_vec()],
            vec![a, b],
            DMatrix::zeros(0, 3),
        )
    }

    /// Functions of all variables and all pairs of them, in the first channel.
    fn smoothed(linear: &LinearModel, covariates: &Covariates) -> Vec<Chosen> {
        let ones = (0..4).map(Arguments::One);
        let twos = (0..4).flat_map(|a| (a + 1..4).map(move |b| Arguments::Two([a, b])));
        let candidates: Vec<Arguments> = ones.chain(twos).collect();
        let model = FoldedModel::of(linear).unwrap();
        let channel = FoldedChannel {
            channel: 0,
            covariates,
            model: &model,
        };
        channel.smoothed(&candidates)
    }

    fn rms(series: &[f64]) -> f64 {
        (series.iter().map(|e| e * e).sum::<f64>() / series.len() as f64).sqrt()
    }

    /// A product of two variables of which the model has taken what it could is found as a function of these, and what is left
    /// beside all parameters is the noise.
    #[test]
    fn the_variables_of_a_misfit_are_found_beside_all_parameters() {
        const NOISE: f64 = 0.05;
        let covariates = covariates();
        let x = |k: usize| &covariates.variables[k].values;
        let law = (0..ROWS).map(|row| x(1)[row] * (2.0 * x(2)[row]).sin() + 0.8 * x(1)[row]);
        let noise = drawn(31, NOISE * 3.0_f64.sqrt());
        let with_noise = law.zip(&noise).map(|(law, noise)| law + noise);
        let left = [with_noise.collect(), drawn(32, NOISE * 3.0_f64.sqrt())];
        let linear = fitted(left, &covariates);
        let all = smoothed(&linear, &covariates);
        let [first, as_it_is] = &all[0].both;
        assert_eq!(first.functions[0].of, Arguments::Two([1, 2]));
        let taken = first.at(&covariates, &linear.columns[0]);
        let before = &linear.residual[0];
        let after: Vec<f64> = before.iter().zip(&taken).map(|(e, by)| e - by).collect();
        assert!(rms(before) > 8.0 * NOISE && rms(&after) < 1.2 * NOISE);
        // Beside the model as it is what the law has biased stays.
        let taken = as_it_is.at(&covariates, &linear.columns[0]);
        let after: Vec<f64> = before.iter().zip(&taken).map(|(e, by)| e - by).collect();
        assert!(rms(&after) > 2.0 * NOISE);
    }

    #[test]
    fn noise_is_a_function_of_nothing() {
        let covariates = covariates();
        for seed in 41..45 {
            let linear = fitted([drawn(seed, 1.0), drawn(seed + 10, 1.0)], &covariates);
            assert!(smoothed(&linear, &covariates).is_empty(), "{seed}");
        }
    }

    /// Factors and unknowns are where the penalised sum of squares over both channels is least, and folds add up to the whole.
    #[test]
    fn matches_independent_implementation_by_dense_least_squares() {
        let covariates = covariates();
        let left = [
            covariates.variables[3]
                .values
                .iter()
                .map(|x| x.abs())
                .collect(),
            drawn(52, 0.1),
        ];
        let linear = fitted(left, &covariates);
        let model = FoldedModel::of(&linear).unwrap();
        let channel = FoldedChannel {
            channel: 0,
            covariates: &covariates,
            model: &model,
        };
        let function = channel.function(Arguments::One(3));
        let open = channel.with(&channel.nothing(), &function);
        let chosen = Stiffened {
            penalty: open.penalty(0.1),
            functions: open.functions,
            products: open.products,
            error: 0.0,
        };
        let [found, still] = channel.both(&chosen);
        assert_eq!(still.step, DVector::zeros(3));
        let width = function.rows.width;
        let mut system = DMatrix::zeros(2 * ROWS, 3 + width);
        for k in 0..3 {
            let of = |c: usize| linear.columns[c][k].clone().unwrap();
            let column = DVector::from_vec([of(0), of(1)].concat());
            system.set_column(k, &column);
        }
        for k in 0..width {
            let mut factors = vec![0.0; width];
            factors[k] = -1.0;
            let mut series = vec![0.0; ROWS];
            function.rows.add(&factors, &mut series);
            system
                .view_mut((0, 3 + k), (ROWS, 1))
                .copy_from_slice(&series);
        }
        let residual = DVector::from_vec(linear.residual.concat());
        let mut normal = system.tr_mul(&system);
        let mut corner = normal.view_mut((3, 3), (width, width));
        corner += &chosen.penalty;
        let expected = normal.cholesky().unwrap().solve(&-system.tr_mul(&residual));
        assert!((expected.rows(0, 3) - &found.step).amax() < 1e-6);
        assert!((expected.rows(3, width) - &found.factors).amax() < 1e-6);
    }
}
