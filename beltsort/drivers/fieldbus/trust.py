"""The folder of the certificates that one side trusts."""

from pathlib import Path

from beltsort.errors import CellError


def trusted(folder: Path) -> list[Path]:
    """Return the certificates in a folder: .pem and .der files, by name.

    Raises
    ------
    CellError
        If there is none: then nobody could be talked to.
    """
    files = sorted(path for path in folder.glob("*") if path.suffix in (".pem", ".der"))
    if not files:
        raise CellError(
            f"{folder} holds no certificate, expected at least one .pem or .der file; copy the other side's "
            "there"
        )
    return files
