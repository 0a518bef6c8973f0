"""Commands of a run, with an id for each attempt."""

from dataclasses import dataclass, replace

from beltsort.cell.commands import Act


@dataclass(frozen=True)
class Command:
    """One attempt to have a device do something.

    Attributes
    ----------
    id
        Unique for device and attempt.
    act
        The motion or sort to be done.
    boot_id
        The device's boot id before the command was sent.
    arriving
        Whether the command only returns the camera to the viewpoint at which the planner has it. That is no
        planner step, and no scan follows.
    attempt
        Number of the attempt, from 1.
    """

    id: str
    act: Act
    boot_id: str
    arriving: bool = False
    attempt: int = 1

    def again(self, boot_id: str) -> "Command":
        """Return the next attempt. Its id is new: a device acts on an id at most once.

        Examples
        --------
        >>> from beltsort.cell.commands import SortInto
        >>> first = Command("5e-sort-3", SortInto(2), boot_id="a")
        >>> first.again("a").id, first.again("a").again("b").id
        ('5e-sort-3.2', '5e-sort-3.3')
        """
        base = self.id.removesuffix(f".{self.attempt}") if self.attempt > 1 else self.id
        attempt = self.attempt + 1
        return replace(self, id=f"{base}.{attempt}", boot_id=boot_id, attempt=attempt)
