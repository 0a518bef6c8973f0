"""Entries of a run on a belt that never stops as text, one line each."""

from beltsort import MovingBelt, SortingModel
from beltsort.perception import Finding
from beltsort.planning.decisions import class_probabilities, likeliest_in_words
from beltsort.sorting.moving.entries import (
    Anchored,
    DiversionTold,
    Diverting,
    EncoderJumped,
    Fate,
    FoundEmpty,
    Looked,
    MovingContent,
    MovingResumed,
    MovingSnapshot,
    MovingStarted,
    ObjectLeft,
    SeenObject,
)
from beltsort.util.text import counted


class MovingFormatter:
    """Formats the entries of one run on a belt that never stops.

    Attributes
    ----------
    belt
        Model, times and prices; None before the first entry.
    """

    def __init__(self) -> None:
        self.belt: MovingBelt | None = None
        self._decided: dict[int, str] = {}  # the bin of each object on the belt, by its number

    @property
    def model(self) -> SortingModel:
        """The model, after the first entry."""
        assert self.belt is not None
        return self.belt.model

    def text(self, content: MovingContent) -> str | None:
        """Return the text of an entry, or None for an entry that is not shown."""
        match content:
            case MovingResumed():
                return "resumed"
            case Anchored(first=number, uncounted=uncounted):
                missing = f"; up to {uncounted} passed before, uncounted" if uncounted else ""
                return f"object {number} and those behind it are tracked{missing}"
            case Looked() as look:
                return self._look(look)
            case Diverting(number=number, name=name, belief=belief, looks=looks):
                self._decided[number] = name
                return f"object {number:>2}  decide {name}  (belief {belief:.3f}, {counted(looks, 'look')})"
            case FoundEmpty(number, belief, looks):
                return f"object {number:>2}  empty cup  (belief {belief:.3f}, {counted(looks, 'look')})"
            case DiversionTold(number=number, state=state, reason=reason) if state not in ("queued", "done"):
                return f"object {number:>2}  the belt says: {state}{f', {reason}' if reason else ''}"
            case EncoderJumped(reason=reason):
                return f"the encoder jumped: {reason}"
            case ObjectLeft(number, fate, reason):
                left = self._left(fate, self._decided.pop(number, ""))
                return f"object {number:>2}  {left}{f': {reason}' if reason else ''}"
        return None

    def start(self, first: MovingStarted | MovingSnapshot | MovingResumed) -> str:
        """Return the text of the first entry, which has the names."""
        self.belt = MovingBelt.from_json(first.belt)
        number = "" if isinstance(first, MovingResumed) or first.objects is None else f"{first.objects} "
        return f"sorting {number}objects on a belt that never stops: {', '.join(self.model.classes)}"

    def _left(self, fate: Fate, bin: str) -> str:
        match fate:
            case Fate.IN_BIN:
                return f"in bin {bin}".rstrip()
            case Fate.EMPTY:
                return "empty cup"
        return fate.upper()

    def _look(self, look: Looked) -> str:
        if self.belt is None:
            return f"look: {counted(len(look.seen), 'object')}"
        seen = " | ".join(self._seen(each) for each in look.seen) or "no undecided object"
        return f"look from {self.belt.model.viewpoints[look.viewpoint]}: {seen}"

    def _seen(self, seen: SeenObject) -> str:
        model = self.model
        if seen.label is None:
            return f"object {seen.number} {self.seen(seen)}"
        classes = class_probabilities(model, seen.kinds or ())
        likely = f"{likeliest_in_words(classes, list(model.classes))} {max(classes):.2f}"
        return f"object {seen.number} {self.seen(seen)} -> {likely}"

    def seen(self, seen: SeenObject) -> str:
        """Return the label that a scan gave an object, `?` for none, or why there is none."""
        if seen.label is not None:
            return self.model.labels[seen.label]
        return "?" if seen.finding == Finding.OBJECT else seen.finding
