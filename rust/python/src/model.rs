//! `SortingModel`.

use std::path::PathBuf;
use std::sync::Arc;

use beltsort_core::{ModelSpec, SortingModel, Tables};
use numpy::ndarray::{Array2, Array4};
use numpy::{Element, IntoPyArray, PyArray1, PyArray2, PyArray4};
use pyo3::prelude::*;

use crate::convert::{scalar_or_matrix, tables};
use crate::errors::to_python;

/// The sorting POMDP: sets, observation tables, rewards and travel.
#[pyclass(frozen, eq, name = "SortingModel", module = "beltsort")]
#[derive(Clone, PartialEq)]
pub struct PySortingModel(pub Arc<SortingModel>);

impl PySortingModel {
    fn checked(spec: ModelSpec) -> PyResult<Self> {
        Ok(Self(Arc::new(SortingModel::new(spec).map_err(to_python)?)))
    }
}

#[pymethods]
impl PySortingModel {
    #[new]
    #[pyo3(signature = (classes, viewpoints, p_obs, *, r_max=10.0, r_min=50.0, motion_cost=None, discount=0.95,
                        arrival=None, travel=None, observe_after_decision=false, repeat=None, counts=None,
                        smoothing=None, note=String::new()))]
    #[allow(clippy::too_many_arguments)] // the keys of a model file
    fn new(
        classes: Vec<String>,
        viewpoints: Vec<String>,
        p_obs: &Bound<'_, PyAny>,
        r_max: f64,
        r_min: f64,
        motion_cost: Option<&Bound<'_, PyAny>>,
        discount: f64,
        arrival: Option<Vec<f64>>,
        travel: Option<Vec<Vec<usize>>>,
        observe_after_decision: bool,
        repeat: Option<&Bound<'_, PyAny>>,
        counts: Option<&Bound<'_, PyAny>>,
        smoothing: Option<f64>,
        note: String,
    ) -> PyResult<Self> {
        let mut spec = ModelSpec::new(classes, viewpoints, tables("p_obs", p_obs)?);
        if let Some(cost) = motion_cost {
            spec.motion_cost = scalar_or_matrix("motion_cost", cost)?;
        }
        spec.r_max = r_max;
        spec.r_min = r_min;
        spec.discount = discount;
        spec.arrival = arrival;
        spec.travel = travel;
        spec.observe_after_decision = observe_after_decision;
        spec.repeat = repeat.map(|value| scalar_or_matrix("repeat", value)).transpose()?;
        spec.counts = counts.map(|value| tables("counts", value)).transpose()?;
        spec.smoothing = smoothing;
        spec.note = note;
        Self::checked(spec)
    }

    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        Self::checked(ModelSpec::load(&path).map_err(to_python)?)
    }

    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        Self::checked(ModelSpec::from_json(text).map_err(to_python)?)
    }

    fn to_json(&self) -> PyResult<String> {
        self.0.spec().to_json().map_err(to_python)
    }

    fn save(&self, path: PathBuf) -> PyResult<()> {
        self.0.spec().save(&path).map_err(to_python)
    }

    #[getter]
    fn classes(&self) -> Vec<String> {
        self.0.spec().classes.clone()
    }

    #[getter]
    fn viewpoints(&self) -> Vec<String> {
        self.0.spec().viewpoints.clone()
    }

    #[getter]
    fn positions(&self) -> usize {
        self.0.position_count()
    }

    #[getter]
    fn p_obs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray4<f64>>> {
        array(py, &self.0.spec().p_obs)
    }

    #[getter]
    fn counts<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray4<u64>>>> {
        self.0.spec().counts.as_ref().map(|counts| array(py, counts)).transpose()
    }

    #[getter]
    fn r_max(&self) -> f64 {
        self.0.spec().r_max
    }

    #[getter]
    fn r_min(&self) -> f64 {
        self.0.spec().r_min
    }

    #[getter]
    fn discount(&self) -> f64 {
        self.0.discount()
    }

    #[getter]
    fn smoothing(&self) -> Option<f64> {
        self.0.spec().smoothing
    }

    #[getter]
    fn note(&self) -> &str {
        &self.0.spec().note
    }

    #[getter]
    fn arrival<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.arrival().iter().copied().collect::<Vec<_>>().into_pyarray(py)
    }

    #[getter]
    fn motion_cost<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let k = self.0.viewpoint_count();
        Array2::from_shape_fn((k, k), |(from, to)| self.0.motion_cost(from, to)).into_pyarray(py)
    }

    #[getter]
    fn travel(&self) -> Vec<Vec<usize>> {
        (0..self.0.viewpoint_count()).map(|from| self.0.legal_moves(from).to_vec()).collect()
    }

    fn with_positions(&self, positions: usize) -> PyResult<Self> {
        Ok(Self(Arc::new(self.0.with_positions(positions).map_err(to_python)?)))
    }

    fn __repr__(&self) -> String {
        let spec = self.0.spec();
        format!(
            "SortingModel(classes={:?}, viewpoints={:?}, positions={}, r_max={}, r_min={}, discount={})",
            spec.classes,
            spec.viewpoints,
            self.0.position_count(),
            spec.r_max,
            spec.r_min,
            spec.discount
        )
    }

    fn __reduce__(&self, py: Python<'_>) -> PyResult<(Py<PyAny>, (String,))> {
        let from_json = py.get_type::<Self>().getattr("from_json")?.unbind();
        Ok((from_json, (self.to_json()?,)))
    }
}

/// Tables as a read-only array.
fn array<'py, T: Element + Copy>(py: Python<'py>, tables: &Tables<T>) -> PyResult<Bound<'py, PyArray4<T>>> {
    let shape = (tables.len(), tables[0].len(), tables[0][0].len(), tables[0][0][0].len());
    let array = Array4::from_shape_fn(shape, |(j, v, c, z)| tables[j][v][c][z]).into_pyarray(py);
    array.call_method1("setflags", (false,))?;
    Ok(array)
}
