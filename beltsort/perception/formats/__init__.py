"""Readers of cloud files, one module for each format.

Open3D is not used for it: it fills up truncated text and PLY files with zeros or uninitialised memory, only
prints a warning, and allocates whatever size a header declares. Here declared sizes are compared with the
bytes that are there before memory is allocated, and what is not understood is an `UnreadableError`.
"""
