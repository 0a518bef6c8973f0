"""The notebooks of the documentation, executed; `python -m tests.docs.notebooks` writes their outputs."""

import os
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbformat import NotebookNode
from traitlets.config import Config

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
ENVIRONMENT = {"PYTHONPATH": str(ROOT), "OPEN3D_DISABLE_WEB_VISUALIZER": "true"}
SECONDS = 300
"""Longest time for a cell, on a machine under load."""


def executed(path: Path) -> NotebookNode:
    """Return the notebook with the outputs of this machine."""
    notebook = nbformat.read(path, as_version=4)
    os.environ |= ENVIRONMENT  # which the kernel inherits
    settings = Config({"KernelManager": {"transport": "ipc"}})  # TCP would be open to other users
    NotebookClient(notebook, config=settings, timeout=SECONDS, record_timing=False).execute()
    return notebook


def texts(cell: NotebookNode) -> list[str]:
    """Return the lines that a cell prints or shows; none for pictures."""
    lines: list[str] = []
    for output in cell.get("outputs", []):
        if output.output_type == "stream":
            lines += output.text.splitlines()
        elif "image/png" not in output.data:
            lines += output.data["text/plain"].splitlines()
    return lines


def pictures(cell: NotebookNode) -> int:
    """Return the number of pictures of a cell."""
    return sum("image/png" in output.get("data", {}) for output in cell.get("outputs", []))


if __name__ == "__main__":
    for notebook_path in NOTEBOOKS:
        nbformat.write(executed(notebook_path), notebook_path)
