"""One attempt at having an actuator act."""

from dataclasses import dataclass, replace

from beltsort.cell.commands import Act


@dataclass(frozen=True)
class Command:
    """One attempt at an act.

    Attributes
    ----------
    id
        Unique for the device, and for the attempt.
    act
        What is to be done.
    boot_id
        Of the device before it was sent.
    arriving
        Whether it only brings the camera to where the planner takes it to be: no planner step, and no look.
    attempt
        Counts from 1.
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
