"""The looks at one object of a run, and what became of it."""

from collections.abc import Sequence
from dataclasses import dataclass

from beltsort import Decide, SortingModel
from beltsort.errors import JournalError
from beltsort.sorting.audit import Step, steps_of
from beltsort.sorting.entries import Decided, Scanned, Skipped
from beltsort.sorting.first_entry import model_of
from beltsort.sorting.journal import Entry
from beltsort.sorting.progress import Progress
from beltsort.util.text import position_number


@dataclass(frozen=True, eq=False)
class Look:
    """A look at one object.

    Attributes
    ----------
    entry
        The scan.
    step
        The planner step of the scan.
    viewpoint, position
        Indices of where the camera was, and of the object's position: 0 is the belt end.
    label
        Index of the label, or None if the object got none.
    finding
        What perception found there.
    belief
        Probability of each class after the look, shape (L,).
    """

    entry: Entry
    step: int
    viewpoint: int
    position: int
    label: int | None
    finding: str
    belief: list[float]


@dataclass(frozen=True, eq=False)
class ObjectHistory:
    """What is known of one object of a run.

    Attributes
    ----------
    number
        The object's number.
    progress
        The state of the run after its last entry.
    looks
        All looks at the object, in order.
    outcome
        Its decision, or that its cup was skipped as empty; None if it has not come to that.
    step
        The planner step that chose the decision; None if there is none.
    """

    number: int
    progress: Progress
    looks: list[Look]
    outcome: Decided | Skipped | None
    step: Step | None

    @property
    def model(self) -> SortingModel:
        """The model of the run."""
        return self.progress.model

    @property
    def undecided(self) -> str:
        """A sentence on why there is no outcome."""
        number, progress = self.number, self.progress
        position = number - progress.index
        if number >= progress.end:
            return (
                f"It is behind the last object of this run, which sorts {objects_in_words(progress)}: it was "
                "seen, and is not decided."
            )
        if number in progress.passed:
            return "It passed the belt end unsorted, and is lost to the run."
        if position == 0:
            return "It has not been decided: it is at the belt end."
        return (
            f"It has not been decided: it is at position {position_number(position)}, object "
            f"{progress.index} at the belt end."
        )


def object_history(entries: Sequence[Entry], number: int) -> ObjectHistory:
    """Return the looks at an object, and its decision.

    Raises
    ------
    JournalError
        If no entry is about this object; the error names those that it has.
    """
    progress = Progress.at_start(model_of(entries), keep=None)
    looks: list[Look] = []
    outcome: Decided | Skipped | None = None
    seen: set[int] = set()
    for entry in entries:
        content = entry.content
        if isinstance(content, Decided | Skipped) and progress.index == number:
            outcome = content
        progress.apply(entry)
        if isinstance(content, Scanned):
            seen.update(range(progress.index, progress.index + progress.model.positions))
            position = number - progress.index
            if 0 <= position < progress.model.positions:
                found = content.labels[position], content.findings[position]
                belief = progress.belief.probabilities[position].tolist()
                looks.append(Look(entry, progress.steps, content.viewpoint, position, *found, belief))
        elif isinstance(content, Decided | Skipped):
            seen.add(entry.object if entry.object is not None else progress.index)
    seen.update(progress.passed)
    if number not in seen:
        raise JournalError(_not_seen(number, seen, progress))
    chosen = [step for step in steps_of(entries) if step.entry.object == number]
    decided = bool(chosen) and isinstance(outcome, Decided) and isinstance(chosen[-1].action, Decide)
    return ObjectHistory(number, progress, looks, outcome, chosen[-1] if decided else None)


def objects_in_words(progress: Progress) -> str:
    """Return how many objects a run sorts, and their numbers.

    Examples
    --------
    >>> import beltsort
    >>> progress = Progress.at_start(beltsort.models.paper())
    >>> progress.objects = 10
    >>> objects_in_words(progress)
    '10 objects, numbered 0 to 9'
    """
    if progress.objects == 1:
        return f"1 object, number {progress.first}"
    return f"{progress.objects} objects, numbered {progress.first} to {progress.end - 1}"


def _not_seen(number: int, seen: set[int], progress: Progress) -> str:
    """Say why the journal has nothing about an object."""
    has = f"objects {min(seen)} to {max(seen)}" if seen else "no objects"
    text = f"there is no object {number}; the journal has {has}"
    if number < progress.first or number >= progress.end:
        return f"{text}, and the run sorts {objects_in_words(progress)}"
    if number < progress.index:
        return f"{text}: it left the belt before the oldest entry that is still kept"
    return f"{text}: it has not been seen yet, object {progress.index} is at the belt end"
