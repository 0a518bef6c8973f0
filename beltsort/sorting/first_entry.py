"""What the first entry of a journal tells."""

from collections.abc import Sequence

from beltsort._core import SortingModel
from beltsort.errors import JournalError
from beltsort.sorting.entries import Snapshot, Started
from beltsort.sorting.journal import Entry
from beltsort.sorting.moving.entries import MovingContent


def model_of(entries: Sequence[Entry]) -> SortingModel:
    """Return the model of a run, from its entries.

    Raises
    ------
    JournalError
        If the first one is neither a start nor a snapshot, or of a run on a belt that never stops.
    """
    first = entries[0]
    if isinstance(first.content, MovingContent):
        raise JournalError(
            "the run is of a belt that never stops, expected one of a belt that stops: read it with "
            "`beltsort show`, `beltsort status` or `beltsort watch`"
        )
    if not isinstance(first.content, Started | Snapshot):
        raise JournalError(
            f"the journal begins with {first.kind!r}, expected 'start' or 'snapshot': it is damaged"
        )
    return SortingModel.from_json(first.content.model)
