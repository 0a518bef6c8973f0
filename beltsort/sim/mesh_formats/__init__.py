"""Readers of mesh files, one module for each format: every face is read, or the file is refused.

Libraries lose faces without a word: Open3D those of an OBJ file with more than three corners, trimesh those
missing at the end of a PLY or OFF file, and OBJ faces behind a tab. glTF is read by Open3D, and what it lost
is counted.
"""
