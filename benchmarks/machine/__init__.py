"""Benchmarks of planning and perception on a machine."""
