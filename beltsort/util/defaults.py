"""Default values of settings that several packages have.

They are here, since a command's help and a cell file's description name them without importing what computes
with them.
"""

UNIFORM_PRIOR = 1.0
"""Pseudo-counts of each entry of an observation table: a uniform Dirichlet prior."""

TARGET_ERROR = 0.03
"""Target standard error of each entry of an observation table."""

FALSE_ALARM = 0.01
"""Largest probability that drift detection ever raises an alarm while the model is right."""
