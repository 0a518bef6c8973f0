"""The devices of a cell, by their roles."""

ROLES = ("arm", "camera", "belt", "sorter")
"""The devices of a cell whose belt stops; each is a table of the cell file."""
DIVERTER = "diverter"
"""A belt that never stops, with diverters, which is the table [belt] of a cell file with [moving]."""
MOVING_ROLES = ("arm", "camera", DIVERTER)
"""The devices of a cell whose belt never stops."""
TABLES = {role: role for role in ROLES} | {DIVERTER: "belt"}
"""The table of the cell file of each role."""
