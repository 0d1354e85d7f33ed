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

use crate::diagnose::fit::linear_model::LinearModel;
use crate::diagnose::residuals::covariates::Covariates;
use crate::diagnose::residuals::effect_size::MATTERS;
use crate::diagnose::residuals::hats::{Arguments, HatRows, Hats};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;
use std::ops::Range;

/// Folds of the fitted rows.
const FOLDS: usize = 5;

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

/// Share of the squares of a derivative that is rounding.
const ROUNDING: f64 = 1e-12;

/// Products of derivatives and residuals of a model over each fold.
pub struct FoldedModel<'a> {
    linear: &'a LinearModel,
    folds: Vec<Range<usize>>,
    /// `[channel][fold]`.
    channels: Vec<Vec<OwnProducts>>,
    /// Over all channels, by fold.
    all: Vec<OwnProducts>,
    whole: Cholesky<f64, Dyn>,
}

/// Products of derivatives J and residual r.
#[derive(Clone)]
struct OwnProducts {
    /// JᵀJ.
    square: DMatrix<f64>,
    /// Jᵀr.
    right: DVector<f64>,
    /// rᵀr.
    residual: f64,
}

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

/// Products of the hats of some functions over one fold.
#[derive(Clone)]
struct HatProducts {
    /// CᵀC.
    square: DMatrix<f64>,
    /// CᵀJ.
    by_model: DMatrix<f64>,
    /// Cᵀr.
    right: DVector<f64>,
}

/// Functions, each with its stiffness.
#[derive(Clone)]
struct Chosen<'a> {
    functions: Vec<&'a Function>,
    products: Vec<HatProducts>,
    penalty: DMatrix<f64>,
    /// Mean square of what is left of folds that the others forecast, in units of the deviation of the channel.
    error: f64,
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
        for (column, step) in derivatives.iter().zip(self.step.iter()) {
            let rows = column.iter().flatten().zip(&mut taken);
            rows.for_each(|(j, x)| *x -= step * j);
        }
        taken
    }
}

impl<'a> FoldedModel<'a> {
    /// Of a model along rows of which every channel has as many; `None` where its derivatives are not finite.
    pub fn of(linear: &'a LinearModel) -> Option<Self> {
        let rows = linear.residual.iter().map(Vec::len).max().unwrap_or(0);
        let fold = |k: usize| k * rows / FOLDS..(k + 1) * rows / FOLDS;
        let folds: Vec<Range<usize>> = (0..FOLDS).map(fold).collect();
        let of_channel = |c: usize| -> Vec<OwnProducts> {
            let of = |fold: &Range<usize>| OwnProducts::of(linear, c, fold.clone());
            folds.iter().map(of).collect()
        };
        let numbers = (0..linear.residual.len()).into_par_iter();
        let channels: Vec<Vec<OwnProducts>> = numbers.map(of_channel).collect();
        let over = |k: usize| {
            let mut each = channels.iter().map(|folds| folds[k].clone());
            let first = each.next()?;
            Some(each.fold(first, OwnProducts::plus))
        };
        let all: Vec<OwnProducts> = (0..FOLDS).map(over).collect::<Option<_>>()?;
        let mut square = linear.known_square();
        all.iter().for_each(|fold| square += &fold.square);
        let largest = square.diagonal().amax();
        for k in 0..square.nrows() {
            // An unknown that nothing depends on stays as it is.
            square[(k, k)] += match square[(k, k)] > 0.0 {
                true => ROUNDING * square[(k, k)],
                false => largest.max(1.0),
            };
        }
        Some(Self {
            linear,
            folds,
            channels,
            all,
            whole: square.cholesky()?,
        })
    }
}

impl OwnProducts {
    fn of(linear: &LinearModel, channel: usize, rows: Range<usize>) -> Self {
        let own = &linear.columns[channel];
        let residual = linear.residual[channel]
            .get(rows.clone())
            .unwrap_or_default();
        let mut columns = DMatrix::zeros(residual.len(), own.len());
        for (k, column) in own.iter().enumerate() {
            if let Some(column) = column {
                columns.column_mut(k).copy_from_slice(&column[rows.clone()]);
            }
        }
        let residual = DVector::from_column_slice(residual);
        Self {
            square: columns.tr_mul(&columns),
            right: columns.tr_mul(&residual),
            residual: residual.norm_squared(),
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            square: self.square + other.square,
            right: self.right + other.right,
            residual: self.residual + other.residual,
        }
    }
}

impl FoldedChannel<'_> {
    /// Functions of some covariates that forecast what the model leaves, one more each time for as long as that lowers the error by
    /// what matters; beside all parameters of the model, and beside the model as it is.
    pub fn smoothed(&self, candidates: &[Arguments]) -> Vec<Smoothed> {
        let functions: Vec<Function> = candidates.iter().map(|of| self.function(*of)).collect();
        let mut chosen = self.nothing();
        let mut all = Vec::new();
        for _ in 0..MOST {
            let next = self.grown(&chosen, &functions);
            let least = chosen.error * (1.0 - MATTERS).powi(2);
            match next.filter(|next| next.error < least) {
                Some(next) => chosen = next,
                None => break,
            }
            all.extend(self.both(&chosen));
        }
        all
    }

    fn own(&self) -> &[OwnProducts] {
        &self.model.channels[self.channel]
    }

    fn function(&self, of: Arguments) -> Function {
        let hats = Hats::of(of, self.covariates);
        Function {
            rows: hats.along(self.covariates),
            roughness: hats.roughness(),
            hats,
        }
    }

    /// The model as it is.
    fn nothing<'f>(&self) -> Chosen<'f> {
        let unknowns = self.model.whole.l_dirty().nrows();
        let none = HatProducts {
            square: DMatrix::zeros(0, 0),
            by_model: DMatrix::zeros(0, unknowns),
            right: DVector::zeros(0),
        };
        let rows = self.covariates.direction.len().max(1) as f64;
        Chosen {
            functions: Vec::new(),
            products: vec![none; FOLDS],
            penalty: DMatrix::zeros(0, 0),
            error: self.own().iter().map(|fold| fold.residual).sum::<f64>() / rows,
        }
    }

    /// With the function more that forecasts best.
    fn grown<'f>(&self, known: &Chosen<'f>, functions: &'f [Function]) -> Option<Chosen<'f>> {
        let is_new = |f: &&Function| known.functions.iter().all(|k| k.hats.of != f.hats.of);
        let open: Vec<&Function> = functions.iter().filter(is_new).collect();
        let usual = |f: &&'f Function| {
            let products = self.products(known, f);
            let chosen = self.with(known, f, &products, USUAL_STIFFNESS)?;
            Some((chosen, products))
        };
        let mut ranked: Vec<_> = open.par_iter().filter_map(usual).collect();
        ranked.sort_by(|a, b| a.0.error.total_cmp(&b.0.error));
        ranked.truncate(CLOSER);
        let stiffened = ranked.into_par_iter().flat_map_iter(|(usual, products)| {
            let function = usual.functions.last().copied();
            let others = STIFFNESSES.into_iter().filter(|s| *s != USUAL_STIFFNESS);
            let with = |stiffness| self.with(known, function?, &products, stiffness);
            let others: Vec<Chosen<'f>> = others.filter_map(with).collect();
            std::iter::once(usual).chain(others)
        });
        stiffened.min_by(|a, b| a.error.total_cmp(&b.error))
    }

    /// Products of known functions and one more, by fold.
    fn products(&self, known: &Chosen<'_>, function: &Function) -> Vec<HatProducts> {
        let linear = self.model.linear;
        let scale = linear.scale[self.channel];
        let columns = &linear.columns[self.channel];
        let residual = &linear.residual[self.channel];
        let folds = self.model.folds.iter().zip(&known.products);
        let of = |(fold, before): (&Range<usize>, &HatProducts)| {
            let rows = &function.rows;
            let own = HatProducts {
                square: rows.cross(rows, fold.clone()) / (scale * scale),
                by_model: rows.against_columns(columns, fold.clone()) / scale,
                right: rows.against(residual, fold.clone()) / scale,
            };
            let cross: Vec<DMatrix<f64>> = known
                .functions
                .iter()
                .map(|f| f.rows.cross(rows, fold.clone()) / (scale * scale))
                .collect();
            before.with(own, &cross)
        };
        folds.map(of).collect()
    }

    /// Known functions and one more with a stiffness, and how they forecast each fold.
    fn with<'f>(
        &self,
        known: &Chosen<'f>,
        function: &'f Function,
        products: &[HatProducts],
        stiffness: f64,
    ) -> Option<Chosen<'f>> {
        let width = function.rows.width;
        let squares: f64 = products.iter().map(|p| p.square.diagonal().sum()).sum();
        let before: f64 = known
            .products
            .iter()
            .map(|p| p.square.diagonal().sum())
            .sum();
        let mean_square = (squares - before) / width as f64;
        let own = DMatrix::identity(width, width) * RIDGE + &function.roughness * stiffness;
        let place = known.penalty.nrows();
        let mut penalty = known
            .penalty
            .clone()
            .resize(place + width, place + width, 0.0);
        let mut corner = penalty.view_mut((place, place), (width, width));
        corner.copy_from(&(own * mean_square));
        let chosen = Chosen {
            functions: [&known.functions[..], &[function]].concat(),
            products: products.to_vec(),
            penalty,
            error: 0.0,
        };
        let error = self.cross_validated(&chosen)?;
        Some(Chosen { error, ..chosen })
    }

    /// B.
    fn steps(&self, products: &[HatProducts]) -> DMatrix<f64> {
        let mut sum = products[0].by_model.transpose();
        for fold in &products[1..] {
            sum += fold.by_model.transpose();
        }
        self.model.whole.solve(&sum)
    }

    /// Mean square of what is left of each fold by the factors of the others.
    fn cross_validated(&self, chosen: &Chosen<'_>) -> Option<f64> {
        let steps = self.steps(&chosen.products);
        let folds = chosen.products.iter().zip(&self.model.all);
        let fitted: Vec<Apart> = folds.map(|(p, all)| p.apart(&steps, all)).collect();
        let whole = Apart::sum(&fitted);
        let mut left = 0.0;
        for (k, products) in chosen.products.iter().enumerate() {
            let factor = (&whole.square - &fitted[k].square + &chosen.penalty).cholesky()?;
            let factors = factor.solve(&(&whole.right - &fitted[k].right));
            let own = products.apart(&steps, &self.own()[k]);
            left += self.own()[k].residual - 2.0 * factors.dot(&own.right)
                + factors.dot(&(&own.square * &factors));
        }
        let rows = self.covariates.direction.len().max(1) as f64;
        Some(left / rows)
    }

    /// Functions at their best, where the unknowns change by so much for each hat.
    fn at_best(&self, chosen: &Chosen<'_>, steps: &DMatrix<f64>) -> Smoothed {
        let folds = chosen.products.iter().zip(&self.model.all);
        let fitted: Vec<Apart> = folds.map(|(p, all)| p.apart(steps, all)).collect();
        let whole = Apart::sum(&fitted);
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
    fn both(&self, chosen: &Chosen<'_>) -> [Smoothed; 2] {
        let steps = self.steps(&chosen.products);
        let none = DMatrix::zeros(steps.nrows(), steps.ncols());
        [steps, none].map(|steps| self.at_best(chosen, &steps))
    }
}

/// Products of C⊥ over one fold.
struct Apart {
    square: DMatrix<f64>,
    right: DVector<f64>,
}

impl Apart {
    fn sum(all: &[Self]) -> Self {
        let mut square = all[0].square.clone();
        let mut right = all[0].right.clone();
        for one in &all[1..] {
            square += &one.square;
            right += &one.right;
        }
        Self { square, right }
    }
}

impl HatProducts {
    /// With a function more, of which the products with each known one are `cross`.
    fn with(&self, own: Self, cross: &[DMatrix<f64>]) -> Self {
        let (before, width) = (self.square.nrows(), own.square.nrows());
        let total = before + width;
        let mut square = self.square.clone().resize(total, total, 0.0);
        square
            .view_mut((before, before), (width, width))
            .copy_from(&own.square);
        let mut start = 0;
        for product in cross {
            let rows = product.nrows();
            square
                .view_mut((start, before), (rows, width))
                .copy_from(product);
            let mut lower = square.view_mut((before, start), (width, rows));
            lower.copy_from(&product.transpose());
            start += rows;
        }
        let unknowns = own.by_model.ncols();
        let mut by_model = self.by_model.clone().resize(total, unknowns, 0.0);
        by_model.rows_mut(before, width).copy_from(&own.by_model);
        let mut right = self.right.clone().resize_vertically(total, 0.0);
        right.rows_mut(before, width).copy_from(&own.right);
        Self {
            square,
            by_model,
            right,
        }
    }

    /// Of C⊥ = C − J B, with the products of J.
    fn apart(&self, steps: &DMatrix<f64>, own: &OwnProducts) -> Apart {
        let across = &self.by_model * steps;
        Apart {
            square: &self.square - &across - across.transpose()
                + steps.tr_mul(&(&own.square * steps)),
            right: &self.right - steps.tr_mul(&own.right),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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

    fn candidates() -> Vec<Arguments> {
        let ones = (0..4).map(Arguments::One);
        let twos = (0..4).flat_map(|a| (a + 1..4).map(move |b| Arguments::Two([a, b])));
        ones.chain(twos).collect()
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
        let model = FoldedModel::of(&linear).unwrap();
        let channel = FoldedChannel {
            channel: 0,
            covariates: &covariates,
            model: &model,
        };
        let all = channel.smoothed(&candidates());
        let first = &all[0];
        assert_eq!(first.functions[0].of, Arguments::Two([1, 2]));
        let taken = first.at(&covariates, &linear.columns[0]);
        let before = &linear.residual[0];
        let after: Vec<f64> = before.iter().zip(&taken).map(|(e, by)| e - by).collect();
        assert!(rms(before) > 8.0 * NOISE && rms(&after) < 1.2 * NOISE);
        // Beside the model as it is what the law has biased stays.
        let taken = all[1].at(&covariates, &linear.columns[0]);
        let after: Vec<f64> = before.iter().zip(&taken).map(|(e, by)| e - by).collect();
        assert!(rms(&after) > 2.0 * NOISE);
    }

    #[test]
    fn noise_is_a_function_of_nothing() {
        let covariates = covariates();
        for seed in 41..45 {
            let linear = fitted([drawn(seed, 1.0), drawn(seed + 10, 1.0)], &covariates);
            let model = FoldedModel::of(&linear).unwrap();
            let channel = FoldedChannel {
                channel: 0,
                covariates: &covariates,
                model: &model,
            };
            assert!(channel.smoothed(&candidates()).is_empty(), "{seed}");
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
        let products = channel.products(&channel.nothing(), &function);
        let chosen = channel.with(&channel.nothing(), &function, &products, 0.1);
        let chosen = chosen.unwrap();
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
