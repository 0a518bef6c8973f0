"""Wrappers of devices: validation, timeouts, dry runs, camera poses, bin numbers, a log of calls."""
