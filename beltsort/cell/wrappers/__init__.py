"""What can be put around any device: limits, deadlines, a dry run, faults, a record of its calls."""
