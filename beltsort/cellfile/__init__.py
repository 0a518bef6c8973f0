"""The cell file (TOML): what it says, whether that fits together, and the cell and the run it describes."""
