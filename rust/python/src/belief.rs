//! `Belief`.

use std::sync::Arc;

use beltsort_core::{Belief, SortingModel};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2};
use pyo3::prelude::*;

use crate::convert::{index, rows};
use crate::errors::{ArgumentError, to_python};
use crate::model::PySortingModel;

/// The factored belief: one distribution per belt position.
#[pyclass(name = "Belief", module = "beltsort", from_py_object)]
#[derive(Clone)]
pub struct PyBelief {
    pub belief: Belief,
    pub model: Arc<SortingModel>,
}

#[pymethods]
impl PyBelief {
    #[new]
    #[pyo3(signature = (model, probabilities=None))]
    fn new(model: &PySortingModel, probabilities: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let belief = match probabilities {
            None => Belief::new(&model.0),
            Some(value) => Belief::from_rows(&model.0, &rows("probabilities", value)?).map_err(to_python)?,
        };
        Ok(Self { belief, model: Arc::clone(&model.0) })
    }

    #[getter]
    fn model(&self) -> PySortingModel {
        PySortingModel(Arc::clone(&self.model))
    }

    #[getter]
    fn probabilities<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        Array2::from_shape_fn(self.belief.shape(), |(j, c)| self.belief.position(j)[c]).into_pyarray(py)
    }

    fn label_probabilities<'py>(
        &self,
        py: Python<'py>,
        viewpoint: i64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let viewpoint = index("viewpoint", viewpoint)?;
        let predicted = self.belief.label_probabilities(&self.model, viewpoint).map_err(to_python)?;
        Ok(Array2::from_shape_fn(self.belief.shape(), |(j, z)| predicted[(z, j)]).into_pyarray(py))
    }

    fn observe(&mut self, viewpoint: i64, labels: Vec<Option<i64>>) -> PyResult<()> {
        let labels = labels
            .into_iter()
            .map(|label| label.map(|z| index("label", z)).transpose())
            .collect::<PyResult<Vec<_>>>()?;
        self.belief.observe(&self.model, index("viewpoint", viewpoint)?, &labels).map_err(to_python)
    }

    fn advance(&mut self) {
        self.belief.advance(&self.model);
    }

    fn most_likely(&self, position: i64) -> PyResult<(usize, f64)> {
        let position = index("position", position)?;
        let positions = self.model.position_count();
        if position >= positions {
            return Err(ArgumentError::new_err(format!(
                "position {position} is out of range: 0 to {}",
                positions - 1
            )));
        }
        Ok(self.belief.most_likely(position))
    }

    fn copy(&self) -> Self {
        self.clone()
    }

    fn __repr__(&self) -> String {
        let (positions, _) = self.belief.shape();
        let rows: Vec<String> = (0..positions)
            .map(|j| {
                let row: Vec<String> = self.belief.position(j).iter().map(|p| format!("{p:.3}")).collect();
                format!("[{}]", row.join(", "))
            })
            .collect();
        format!("Belief([{}])", rows.join(", "))
    }
}
