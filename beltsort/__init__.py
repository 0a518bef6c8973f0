"""Sorting objects from a conveyor belt by active perception."""
