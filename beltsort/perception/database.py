"""The file of a database: a .npz without pickled objects, checked before it is used.

A member is read only if the sizes that the archive and the array's header declare agree and are within
bounds, so a damaged or hostile file cannot make memory overflow.
"""

import json
from collections.abc import Mapping
from io import BytesIO
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import ZIP_DEFLATED, ZIP_STORED, ZipFile

import numpy as np
from numpy.typing import NDArray

from beltsort.errors import DatabaseError
from beltsort.perception.descriptor import LONGEST

VERSION = 3
READABLE = (1, 2, 3)
"""Version 1 had one neighbour, the chi-square distance and no rejection; 2 VFHs only, and no coefficients."""

MOST_ENTRIES = 100_000
LONGEST_HEADER = 2**20  # bytes
LARGEST_COEFFICIENTS = 2**26  # bytes
NPY_PREAMBLE = 2**14  # bytes, at most, before the values of an array


class Stored(NamedTuple):
    """The content of a file.

    Attributes
    ----------
    descriptors, labels
        Shapes (n, m) and (n,).
    header
        Settings.
    coefficients
        Of a kernel ridge classifier, shape (n, L); None in the file of a nearest-neighbour classifier.
    """

    descriptors: NDArray[np.float64]
    labels: NDArray[np.int64]
    header: dict[str, Any]
    coefficients: NDArray[np.float64] | None


def write_database(
    path: str | PathLike[str],
    descriptors: NDArray[np.float64],
    labels: NDArray[np.int64],
    header: Mapping[str, Any],
    coefficients: NDArray[np.float64] | None = None,
) -> None:
    """Write arrays as in `Stored`, and a header that is written as JSON.

    Raises
    ------
    DatabaseError
        If the file cannot be written.
    """
    text = json.dumps({"version": VERSION, **header}, allow_nan=False)
    arrays: dict[str, NDArray[Any]] = {"descriptors": descriptors, "labels": labels, "header": np.array(text)}
    if coefficients is not None:
        arrays["coefficients"] = coefficients
    try:
        with Path(path).open("wb") as file:
            np.savez_compressed(file, allow_pickle=False, **arrays)
    except OSError as reason:
        raise DatabaseError(f"cannot write {path}: {reason}; choose a writable path") from reason


def read_database(path: str | PathLike[str]) -> Stored:
    """Read what `write_database` wrote, in this version or an earlier one of `READABLE`.

    Raises
    ------
    Exception
        Of any kind, if the file is missing, damaged, of another version, or no database.
    """
    with ZipFile(Path(path)) as archive:
        header = json.loads(str(_member(archive, "header", "U", LONGEST_HEADER)))
        if header["version"] not in READABLE:
            raise ValueError(f"its version is {header['version']!r}, expected one of {READABLE}")
        descriptors = _member(archive, "descriptors", "f8", 8 * MOST_ENTRIES * LONGEST)
        labels = _member(archive, "labels", "i8", 8 * MOST_ENTRIES)
        coefficients = None
        if "coefficients.npy" in archive.namelist():
            coefficients = _member(archive, "coefficients", "f8", LARGEST_COEFFICIENTS)
    return Stored(descriptors, labels, header, coefficients)


def _member(archive: ZipFile, name: str, kind: str, most: int) -> NDArray[Any]:
    """Return one array of numbers or text, of at most `most` bytes."""
    entry = archive.getinfo(f"{name}.npy")
    if entry.compress_type not in (ZIP_STORED, ZIP_DEFLATED):
        raise ValueError(f"{name} is packed by method {entry.compress_type}, expected plain or deflated")
    if entry.file_size > most + NPY_PREAMBLE:
        raise ValueError(f"{name} unpacks to {entry.file_size} bytes, expected at most {most}")
    file = BytesIO(archive.read(entry))
    shape, fortran_order, dtype = _array_header(file)
    if not dtype.str[1:].startswith(kind):
        raise ValueError(f"{name} holds {dtype}, expected {kind!r} and never pickled objects")
    values = np.frombuffer(file.getbuffer()[file.tell() :], dtype)
    return values.reshape(shape, order="F" if fortran_order else "C")


def _array_header(file: BytesIO) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    version = np.lib.format.read_magic(file)
    if version == (1, 0):
        return np.lib.format.read_array_header_1_0(file)
    if version == (2, 0):
        return np.lib.format.read_array_header_2_0(file)
    raise ValueError(f"an array of format {version}, expected (1, 0) or (2, 0)")
