"""Tables with latent modes on looks of the simulated cell: `python -m benchmarks.modes`."""
