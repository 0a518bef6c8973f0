"""What an actuator is told to do."""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Command:
    """One attempt at an actuator command.

    Attributes
    ----------
    id
        Unique for the device, and for the attempt.
    name
        `move`, `sort` or `advance`.
    target
        Viewpoint, bin or object at the belt end.
    boot_id
        Of the device before it was sent.
    arriving
        Whether it only brings the camera to where the planner takes it to be: no planner step, and no look.
    attempt
        Counts from 1.
    """

    id: str
    name: str
    target: int
    boot_id: str
    arriving: bool = False
    attempt: int = 1

    def again(self, boot_id: str) -> "Command":
        """Return the next attempt. Its id is new: a device acts on an id at most once.

        Examples
        --------
        >>> first = Command("5e-sort-3", "sort", target=2, boot_id="a")
        >>> first.again("a").id, first.again("a").again("b").id
        ('5e-sort-3.2', '5e-sort-3.3')
        """
        base = self.id.removesuffix(f".{self.attempt}") if self.attempt > 1 else self.id
        attempt = self.attempt + 1
        return replace(self, id=f"{base}.{attempt}", boot_id=boot_id, attempt=attempt)
