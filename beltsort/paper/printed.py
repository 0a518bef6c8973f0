"""What the paper prints of its real robot, to be shown beside what is simulated here.

References
----------
A. Mezei, L. Tamas, L. Busoniu, "Sorting objects from a conveyor belt using active perception with a POMDP
model", European Control Conference 2019.
"""

TABLES_PRINTED = ((1, "elongated"), (1, "livarno"), (2, "elongated"))
"""Position and true class of the blocks of observation tables that the paper prints, a row per viewpoint."""

CLASSES_DRAWN = ("elongated", "livarno")
"""The bulbs on the paper's belt; its planner knows of four classes."""

R_MIN = 50.0
"""The penalty at which one and two positions are compared."""

POSITIVES = {5.0: 2.0, 50.0: 5.0, 500.0: 8.0}
"""Right decisions of ten, by r_min."""

STEPS = {5.0: 20.0, 50.0: 52.0, 500.0: 70.0}
"""Planner steps for ten objects, by r_min."""

STEPS_BY_POSITIONS = {1: 75.0, 2: 42.0}
"""Planner steps for ten objects at `R_MIN`, by the number of positions seen at once."""
