"""Policies by name, their comparison, and why a plan chose what it did."""
