"""The cell file (TOML): its description and validation, composition of the cell, runs and checks."""
