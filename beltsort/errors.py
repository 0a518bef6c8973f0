"""Exceptions. All of them are subclasses of `BeltsortError`."""

from beltsort._core import BeltsortError


class CloudError(BeltsortError):
    """A point cloud cannot be read, or no descriptor can be computed from it."""


class InUseError(BeltsortError):
    """Another process uses the same run or the same device."""


class CellError(BeltsortError):
    """A cell, a device or a cell file cannot do what was requested."""


class DatabaseError(BeltsortError):
    """A classifier's database cannot be built, read or used."""


class JournalError(BeltsortError):
    """The journal of a run cannot be written or read."""


class JournalNotWrittenError(JournalError):
    """A journal entry could not be written, because the disk is full, for example."""


class ViewpointError(BeltsortError):
    """Viewpoints cannot be chosen, reached or read."""


class MissingExtraError(BeltsortError, ImportError):
    """A package is missing that one of the extras provides."""


class RecordingError(BeltsortError):
    """Recorded scans or their labels cannot be read or written."""


class SweepError(BeltsortError):
    """A point of a sweep failed, or its rows cannot be read or written."""


class TrackingError(BeltsortError):
    """Objects on a moving belt cannot be tracked with these readings, scans or settings."""
