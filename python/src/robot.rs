//! Rigid-body functions of a robot for batches of states.
//!
//! Arrays are `(samples, joints)`, SI units, joints in the order of the robot's tree. Inertial parameters are ten per link,
//! `(m, m·cx, m·cy, m·cz, Ixx, Ixy, Iyy, Ixz, Iyz, Izz)` about the origin of the link's frame, as Pinocchio orders them.

use crate::error::Failure;
use exid::chain::base_parameters::BaseParameters;
use exid::chain::effect;
use exid::chain::parameter::Role;
use exid::problem_file::ProblemFile;
use exid::robot::batch::{RegressorBatch, Trajectory, torques as inverse_dynamics};
use exid::robot::derivative_batch::DerivativeBatch;
use exid::robot::forward_dynamics::{ForwardDynamics, SingularMass};
use exid::robot::inertia::{PER_LINK, QUANTITIES};
use exid::robot::regressor::Rows;
use exid::robot::tree::Tree;
use exid::setup;
use exid::setup::model_spec::ModelSpec;
use nalgebra::DMatrix;
use numpy::ndarray::{
    Array2, Array3, ArrayView2, ArrayViewMut, ArrayViewMut3, Axis, RemoveAxis, s,
};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;
use std::path::PathBuf;

/// Samples that are evaluated together: their rows of a regressor stay in the cache of a core.
const BLOCK: usize = 64;

type States<'py> = PyReadonlyArray2<'py, f64>;

/// A kinematic tree with the inertial parameters of its file.
#[pyclass(frozen, module = "exid._core")]
pub struct Robot {
    tree: Tree,
    parameters: Vec<f64>,
    base: BaseParameters,
    /// Column of the regressor of each parameter of the model.
    columns: Vec<Option<usize>>,
    expressions: Vec<String>,
}

/// Position, velocity and acceleration of a block of samples, `[joint][sample]`.
struct Block {
    q: Vec<Vec<f64>>,
    dq: Vec<Vec<f64>>,
    ddq: Vec<Vec<f64>>,
}

impl Block {
    fn of(q: ArrayView2<f64>, dq: ArrayView2<f64>, ddq: ArrayView2<f64>) -> Self {
        let by_joint = |states: ArrayView2<f64>| {
            let columns = states.axis_iter(Axis(1));
            columns.map(|joint| joint.to_vec()).collect()
        };
        Self {
            q: by_joint(q),
            dq: by_joint(dq),
            ddq: by_joint(ddq),
        }
    }

    fn trajectory(&self) -> Trajectory<'_> {
        Trajectory {
            q: &self.q,
            dq: &self.dq,
            ddq: &self.ddq,
        }
    }
}

/// A motion of samples of one robot.
#[derive(Clone, Copy)]
struct Motion<'a> {
    q: ArrayView2<'a, f64>,
    dq: ArrayView2<'a, f64>,
    ddq: ArrayView2<'a, f64>,
}

impl Motion<'_> {
    fn block(&self, number: usize) -> Block {
        let rows = number * BLOCK..((number + 1) * BLOCK).min(self.q.nrows());
        let of = |states: &ArrayView2<f64>| states.slice(s![rows.clone(), ..]).to_owned();
        let (q, dq, ddq) = (of(&self.q), of(&self.dq), of(&self.ddq));
        Block::of(q.view(), dq.view(), ddq.view())
    }

    /// Fills an array whose first axis is the samples, block by block on all threads; `made` makes what a thread works with.
    fn in_blocks<D: RemoveAxis, T>(
        &self,
        mut array: ArrayViewMut<'_, f64, D>,
        made: impl Fn() -> T + Send + Sync,
        fill: impl Fn(&mut T, Trajectory<'_>, ArrayViewMut<'_, f64, D>) + Send + Sync,
    ) {
        let chunks = array.axis_chunks_iter_mut(Axis(0), BLOCK);
        let chunks = chunks.into_par_iter().enumerate();
        chunks.for_each_init(made, |with, (number, out)| {
            fill(with, self.block(number).trajectory(), out);
        });
    }
}

#[pymethods]
impl Robot {
    /// Reads a robot file of a kind, `urdf`, `mjcf` or `mdh`.
    #[new]
    fn new(py: Python<'_>, kind: &str, path: PathBuf, gravity: Option<[f64; 3]>) -> PyResult<Self> {
        let read = py.detach(|| Self::read(kind, &path, gravity));
        read.map_err(|failure| failure.raise(py))
    }

    /// Names of the joints in the order of all arrays.
    #[getter]
    fn joints(&self) -> Vec<String> {
        self.tree.joints().iter().map(|j| j.name.clone()).collect()
    }

    /// Names of the links, each moved by the joint of the same position.
    #[getter]
    fn links(&self) -> Vec<String> {
        self.tree.joints().iter().map(|j| j.link.clone()).collect()
    }

    /// Gravity in the base frame, m/s².
    #[getter]
    fn gravity_vector(&self) -> [f64; 3] {
        self.tree.gravity().into()
    }

    /// Names of the columns of the regressor.
    #[getter]
    fn parameter_names(&self) -> Vec<String> {
        let links = self.tree.joints().iter();
        links
            .flat_map(|j| QUANTITIES.map(|q| format!("{}.{q}", j.link)))
            .collect()
    }

    /// Inertial parameters of the file, 10 per link.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.parameters.clone().into_pyarray(py)
    }

    /// Columns of the regressor that are the base regressor.
    #[getter]
    fn base_columns(&self) -> Vec<usize> {
        let kept = self.base.kept().into_iter();
        kept.filter_map(|parameter| self.columns[parameter])
            .collect()
    }

    /// What each base parameter is a combination of, in words.
    #[getter]
    fn base_expressions(&self) -> Vec<String> {
        self.expressions.clone()
    }

    /// Matrix K (base parameters, 10 n) with β = K π.
    #[getter]
    fn base_map<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let mut map = Array2::zeros((self.base.base.len(), self.parameters.len()));
        for (row, base) in self.base.base.iter().enumerate() {
            let kept = [(base.parameter, 1.0)];
            for &(parameter, coefficient) in kept.iter().chain(&base.others) {
                if let Some(column) = self.columns[parameter] {
                    map[(row, column)] = coefficient;
                }
            }
        }
        map.into_pyarray(py)
    }

    /// Torques τ (samples, joints) of a motion.
    fn inverse_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: States<'py>,
        dq: States<'py>,
        ddq: States<'py>,
        parameters: Option<PyReadonlyArray1<'py, f64>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let motion = self.motion(&q, &dq, &ddq)?;
        let parameters = self.chosen(parameters.as_ref())?;
        let n = self.tree.len();
        let mut torques = Array2::zeros((motion.q.nrows(), n));
        py.detach(|| {
            motion.in_blocks(
                torques.view_mut(),
                || (),
                |(), trajectory, mut out| {
                    let torque = inverse_dynamics(&self.tree, &parameters, trajectory);
                    for (joint, series) in torque.iter().enumerate() {
                        for (sample, &value) in series.iter().enumerate() {
                            out[(sample, joint)] = value;
                        }
                    }
                },
            );
        });
        Ok(torques.into_pyarray(py))
    }

    /// Regressor (samples, joints, columns), of all 10 n parameters or of the columns that are named.
    fn regressor<'py>(
        &self,
        py: Python<'py>,
        q: States<'py>,
        dq: States<'py>,
        ddq: States<'py>,
        columns: Option<Vec<usize>>,
    ) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let motion = self.motion(&q, &dq, &ddq)?;
        let columns = columns.unwrap_or_else(|| (0..self.parameters.len()).collect());
        if let Some(column) = columns.iter().find(|&&c| c >= self.parameters.len()) {
            let message = format!("the regressor has no column {column}");
            return Err(PyValueError::new_err(message));
        }
        let n = self.tree.len();
        let cells = cells(&self.tree, &columns);
        // NumPy's own memory: it asks the system for large pages, and most of the time goes into getting them.
        let regressor = PyArray3::zeros(py, [motion.q.nrows(), n, columns.len()], false);
        let mut writable = regressor.readwrite();
        let values = writable.as_array_mut();
        py.detach(|| {
            motion.in_blocks(
                values,
                || RegressorBatch::new(&self.tree, Rows::Torque, BLOCK),
                |batch, trajectory, out| {
                    batch.evaluate(&self.tree, trajectory, 0..trajectory.len());
                    scatter(batch, &cells, out);
                },
            );
        });
        drop(writable);
        Ok(regressor)
    }

    /// Mass matrices (samples, joints, joints), kg·m² (kg).
    fn mass_matrix<'py>(
        &self,
        py: Python<'py>,
        q: States<'py>,
        parameters: Option<PyReadonlyArray1<'py, f64>>,
    ) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let motion = self.motion(&q, &q, &q)?;
        let parameters = self.chosen(parameters.as_ref())?;
        let n = self.tree.len();
        let mut matrices = Array3::zeros((motion.q.nrows(), n, n));
        py.detach(|| {
            let samples = matrices.axis_iter_mut(Axis(0)).into_par_iter().enumerate();
            let still = vec![0.0; n];
            samples.for_each_init(
                || ForwardDynamics::new(&self.tree),
                |dynamics, (sample, mut out)| {
                    let at = motion.q.row(sample).to_vec();
                    let equation = dynamics.equation(&self.tree, &parameters, [&at, &still]);
                    for i in 0..n {
                        for j in 0..=i {
                            out[(i, j)] = equation.mass[i * n + j];
                            out[(j, i)] = equation.mass[i * n + j];
                        }
                    }
                },
            );
        });
        Ok(matrices.into_pyarray(py))
    }

    /// Accelerations (samples, joints) under torques.
    fn forward_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: States<'py>,
        dq: States<'py>,
        torque: States<'py>,
        parameters: Option<PyReadonlyArray1<'py, f64>>,
        rotor_inertia: Option<PyReadonlyArray1<'py, f64>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let motion = self.motion(&q, &dq, &torque)?;
        let parameters = self.chosen(parameters.as_ref())?;
        let n = self.tree.len();
        let added = match &rotor_inertia {
            Some(given) => given.as_array().to_vec(),
            None => vec![0.0; n],
        };
        if added.len() != n {
            let message = format!("{} rotor inertias for {n} joints", added.len());
            return Err(PyValueError::new_err(message));
        }
        let mut accelerations = Array2::zeros((motion.q.nrows(), n));
        let done: Result<(), SingularMass> = py.detach(|| {
            let samples = accelerations.axis_iter_mut(Axis(0)).into_par_iter();
            samples.enumerate().try_for_each_init(
                || ForwardDynamics::new(&self.tree),
                |dynamics, (sample, mut out)| {
                    let row = |states: &ArrayView2<f64>| states.row(sample).to_vec();
                    let (q, dq, torque) = (row(&motion.q), row(&motion.dq), row(&motion.ddq));
                    let mut ddq = vec![0.0; n];
                    let state = [&q[..], &dq, &torque, &added];
                    dynamics.acceleration(&self.tree, &parameters, state, &mut ddq)?;
                    out.iter_mut().zip(ddq).for_each(|(o, x)| *o = x);
                    Ok(())
                },
            )
        });
        done.map_err(|singular| PyValueError::new_err(singular.to_string()))?;
        Ok(accelerations.into_pyarray(py))
    }

    /// Derivatives of τ by q, q̇ and q̈, each (samples, joints, joints).
    fn derivatives<'py>(
        &self,
        py: Python<'py>,
        q: States<'py>,
        dq: States<'py>,
        ddq: States<'py>,
        parameters: Option<PyReadonlyArray1<'py, f64>>,
    ) -> PyResult<Vec<Bound<'py, PyArray3<f64>>>> {
        let motion = self.motion(&q, &dq, &ddq)?;
        let parameters = self.chosen(parameters.as_ref())?;
        let (samples, n) = motion.q.dim();
        let mut slopes = Array3::zeros((samples, 3 * n, n));
        py.detach(|| {
            motion.in_blocks(
                slopes.view_mut(),
                || DerivativeBatch::new(&self.tree, BLOCK),
                |batch, trajectory, mut out| {
                    let whole = 0..trajectory.len();
                    batch.evaluate(&self.tree, &parameters, trajectory, whole);
                    for order in 0..3 {
                        for row in 0..n {
                            for joint in 0..n {
                                let series = batch.slope(order, row, joint);
                                for sample in 0..trajectory.len() {
                                    out[(sample, order * n + row, joint)] = series[sample];
                                }
                            }
                        }
                    }
                },
            );
        });
        let part = |order: usize| {
            slopes
                .slice(s![.., order * n..(order + 1) * n, ..])
                .to_owned()
        };
        Ok((0..3).map(|order| part(order).into_pyarray(py)).collect())
    }
}

impl Robot {
    fn read(
        kind: &str,
        path: &std::path::Path,
        gravity: Option<[f64; 3]>,
    ) -> Result<Self, Failure> {
        let mut robot = serde_json::Map::new();
        robot.insert(kind.into(), path.display().to_string().into());
        if let Some(gravity) = gravity {
            robot.insert("gravity".into(), gravity.to_vec().into());
        }
        let table = serde_json::json!({ "robot": robot });
        let problem =
            ProblemFile::kept(std::path::Path::new("robot"), &table, &[], &effect::ids())?;
        let robot = setup::robot::open(&problem)?;
        let model = ModelSpec::without_prior(&problem, &robot)?.build()?.model;
        let known = DMatrix::zeros(0, model.parameters().len());
        let base = BaseParameters::structural(&model, &[false], &known);
        let columns = model
            .parameters()
            .iter()
            .map(|parameter| match parameter.role {
                Role::Inertial { link, quantity } => Some(PER_LINK * link + quantity),
                _ => None,
            });
        Ok(Self {
            columns: columns.collect(),
            expressions: (0..base.base.len())
                .map(|k| base.expression(&model, k))
                .collect(),
            base,
            parameters: robot.tree.parameters(),
            tree: robot.tree,
        })
    }

    /// States of as many joints as the robot has, as many samples of each.
    fn motion<'a>(
        &self,
        q: &'a States<'_>,
        dq: &'a States<'_>,
        ddq: &'a States<'_>,
    ) -> PyResult<Motion<'a>> {
        let motion = Motion {
            q: q.as_array(),
            dq: dq.as_array(),
            ddq: ddq.as_array(),
        };
        let expected = [motion.q.nrows(), self.tree.len()];
        for states in [&motion.q, &motion.dq, &motion.ddq] {
            if states.shape() != expected {
                let message = format!(
                    "an array has the shape {:?} where {expected:?} (samples, joints) is expected",
                    states.shape()
                );
                return Err(PyValueError::new_err(message));
            }
        }
        Ok(motion)
    }

    /// The parameters that are given, or those of the file.
    fn chosen(&self, given: Option<&PyReadonlyArray1<'_, f64>>) -> PyResult<Vec<f64>> {
        let Some(given) = given else {
            return Ok(self.parameters.clone());
        };
        let parameters = given.as_array().to_vec();
        match parameters.len() == self.parameters.len() {
            true => Ok(parameters),
            false => Err(PyValueError::new_err(format!(
                "{} parameters where {} are expected, ten per link",
                parameters.len(),
                self.parameters.len()
            ))),
        }
    }
}

/// A place of the regressor of one sample, and the column of a block that goes there.
struct Cell {
    place: usize,
    row: usize,
    column: usize,
}

/// The places of a regressor that are not zero whatever the motion: joints and the links that they move.
fn cells(tree: &Tree, columns: &[usize]) -> Vec<Cell> {
    let rows = 0..tree.len();
    let all = rows.flat_map(|row| {
        columns
            .iter()
            .enumerate()
            .map(move |(k, &column)| (row, k, column))
    });
    all.filter(|&(row, _, column)| tree.moves(row, column / PER_LINK))
        .map(|(row, k, column)| Cell {
            place: row * columns.len() + k,
            row,
            column,
        })
        .collect()
}

/// Copies cells of a block, sample after sample: the array, zeros before, is written in the order of its memory.
fn scatter(batch: &RegressorBatch, cells: &[Cell], mut out: ArrayViewMut3<'_, f64>) {
    let (_, rows, columns) = out.dim();
    let series: Vec<(usize, &[f64])> = cells
        .iter()
        .map(|cell| (cell.place, batch.column(cell.row, cell.column)))
        .collect();
    if let (false, Some(flat)) = (series.is_empty(), out.as_slice_mut()) {
        for (sample, to) in flat.chunks_exact_mut(rows * columns).enumerate() {
            for &(place, from) in &series {
                to[place] = from[sample];
            }
        }
    }
}
