"""Utilities: process pools, a key-value log, names, random numbers, text."""
