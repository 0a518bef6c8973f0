"""Sorting from depth scans on a belt that never stops."""
