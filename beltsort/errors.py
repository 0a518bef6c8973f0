"""Every error that beltsort raises on purpose descends from `BeltsortError`."""

from beltsort._core import BeltsortError


class CloudError(BeltsortError):
    """A point cloud that cannot be read, or from which no descriptor can be computed."""


class InUseError(BeltsortError):
    """Another process works on the same run, or drives the same device."""


class CellError(BeltsortError):
    """A robot cell was asked for something it cannot do."""


class DatabaseError(BeltsortError):
    """A classifier's database cannot be built, read or used."""


class JournalError(BeltsortError):
    """The record of a run cannot be written or read."""


class JournalNotWrittenError(JournalError):
    """An entry could not be written: the disk is full, or gone."""


class ViewpointError(BeltsortError):
    """Viewpoints cannot be chosen, reached or read."""


class RecordingError(BeltsortError):
    """Recorded scans, or the labels of them, cannot be read or written."""


class SweepError(BeltsortError):
    """A point of a sweep failed, or its rows cannot be read or written."""
