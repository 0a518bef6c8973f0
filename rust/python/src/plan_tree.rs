//! The searched tree as plain data.

use beltsort_core::{Action, Bin, Label, TreeAction, TreeBranch, TreeNode, Viewpoint};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::convert::Whole;
use crate::errors::ArgumentError;

/// Planner steps to show, if not given.
pub const DEFAULT_DEPTH: usize = 2;
/// As deep as a search goes.
const DEEPEST: usize = 1000;

/// A number of steps below the root.
pub fn depth(value: Whole) -> PyResult<usize> {
    usize::try_from(value).ok().filter(|depth| *depth <= DEEPEST).ok_or_else(|| {
        ArgumentError::new_err(format!(
            "depth = {value}; give the planner steps to show, 0 to {DEEPEST}, {DEFAULT_DEPTH} for example"
        ))
    })
}

/// A belief and all below it.
pub fn to_python<'py>(py: Python<'py>, node: &TreeNode) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("viewpoint", node.viewpoint.0)?;
    dict.set_item("belief", &node.belief)?;
    dict.set_item("value", node.value)?;
    dict.set_item("lower", node.lower)?;
    dict.set_item("upper", node.upper)?;
    dict.set_item("scenarios", node.scenarios)?;
    dict.set_item("actions", list(py, &node.actions, compared)?)?;
    Ok(dict)
}

fn compared<'py>(py: Python<'py>, action: &TreeAction) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("action", named(py, action.action)?)?;
    dict.set_item("value", action.value)?;
    dict.set_item("lower", action.lower)?;
    dict.set_item("upper", action.upper)?;
    dict.set_item("branches", list(py, &action.branches, branch)?)?;
    Ok(dict)
}

fn branch<'py>(py: Python<'py>, branch: &TreeBranch) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("probability", branch.probability)?;
    dict.set_item("labels", branch.labels.as_deref().map(indices))?;
    dict.set_item("node", to_python(py, &branch.node)?)?;
    Ok(dict)
}

fn indices(labels: &[Label]) -> Vec<usize> {
    labels.iter().map(|label| label.0).collect()
}

/// An action in the journal's form.
fn named(py: Python<'_>, action: Action) -> PyResult<Bound<'_, PyDict>> {
    let dict = PyDict::new(py);
    match action {
        Action::Move(Viewpoint(viewpoint)) => dict.set_item("move", viewpoint)?,
        Action::Decide(Bin(label)) => dict.set_item("decide", label)?,
    }
    Ok(dict)
}

fn list<'py, T>(
    py: Python<'py>,
    items: &[T],
    to_dict: impl Fn(Python<'py>, &T) -> PyResult<Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyList>> {
    let list = PyList::empty(py);
    for item in items {
        list.append(to_dict(py, item)?)?;
    }
    Ok(list)
}
