"""Policies by name, comparison of policies, explanation of plans."""
