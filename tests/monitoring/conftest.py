"""The fixtures of a folder in which a cell can run."""

from tests.cli.conftest import folder, trained

__all__ = ["folder", "trained"]
