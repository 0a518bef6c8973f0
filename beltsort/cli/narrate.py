"""Journal entries in plain words, one line each."""

from typing import Any

from beltsort import SortingModel
from beltsort.perception import Finding
from beltsort.sorting.journal import Entry


class Narrator:
    """Turns the entries of one run into lines of text; entries that say nothing new give none.

    Attributes
    ----------
    classes, viewpoints
        Names, known once the first entry has come.
    belief
        Belief after the last entry, rows of probabilities, the belt end first.
    """

    def __init__(self) -> None:
        self.classes: list[str] = []
        self.viewpoints: list[str] = []
        self.belief: list[list[float]] = []
        self._arrival: list[float] = []

    def line(self, entry: Entry) -> str | None:
        """Return what `entry` tells."""
        match entry.kind:
            case "start" | "snapshot" | "resume" if not self.classes:
                text = self._start(entry.data)
            case "state" if entry.data["state"] in ("Held", "Aborted"):
                text = f"{entry.data['state'].lower()}: {entry.data['reason']}"
            case "resume":
                text = "resumed"
            case "outcome" if "error" in entry.data:
                text = f"{entry.data['command_id']} {entry.data['outcome']}: {entry.data['error']}"
            case "scan":
                text = self._scan(entry.data)
            case "drift":
                text = self._drift(entry.data)
            case "bad_scan":
                text = f"unusable scan: {entry.data['error']}"
            case "wrong_viewpoint":
                text = self._wrong_viewpoint(entry.data)
            case "decision":
                text = self._decision(entry.data)
            case "skip":
                text = self._skip()
            case _:
                return None
        return text if entry.object is None else f"object {entry.object:>2}  {text}"

    def why(self, plan: dict[str, Any]) -> str:
        """Return the reason of a plan: the values of its best action and of the next best."""
        if "values" not in plan:
            return str(plan.get("why", ""))
        best, *others = sorted(plan["values"], key=lambda action: -action["value"])
        if not others:
            return f"{self.name(best)} is the only legal action"
        return " ".join(
            [
                f"{self.name(best)} is worth {best['value']:.2f},",
                f"{self.name(others[0])} {others[0]['value']:.2f}",
            ]
        )

    def name(self, action: dict[str, Any]) -> str:
        """Return an action as the journal keeps it, `{"move": 2}`, in words."""
        if "move" in action:
            return f"look from {self.viewpoints[action['move']]}"
        return f"decide {self.classes[action['decide']]}"

    def likely(self, row: list[float]) -> str:
        """Return the most likely class of one position and its probability."""
        best = max(range(len(row)), key=row.__getitem__)
        return f"{self.classes[best]} {row[best]:.2f}"

    def _start(self, data: dict[str, Any]) -> str:
        model = SortingModel.from_json(data["model"])
        self.classes, self.viewpoints = list(model.classes), list(model.viewpoints)
        self._arrival = model.arrival.tolist()
        self.belief = [self._arrival] * model.positions
        return f"sorting {data['objects']} objects: {', '.join(self.classes)}"

    def _scan(self, data: dict[str, Any]) -> str:
        seen = [
            finding if finding != Finding.OBJECT else "?" if label is None else self.classes[label]
            for label, finding in zip(data["labels"], data["findings"], strict=True)
        ]
        self.belief = data["belief"]
        beliefs = " | ".join(self.likely(row) for row in self.belief)
        return f"look from {self.viewpoints[data['viewpoint']]}: {' | '.join(seen)}  ->  {beliefs}"

    def _wrong_viewpoint(self, data: dict[str, Any]) -> str:
        there = data["stands_at"]
        where = "elsewhere" if there is None else f"at {self.viewpoints[there]}"
        return (
            f"wrong viewpoint: the camera stands {where}, {data['angle']:.1f} degrees and "
            f"{data['distance']:.0f} mm from {self.viewpoints[data['viewpoint']]}; the scan is dropped"
        )

    def _drift(self, data: dict[str, Any]) -> str:
        where = ""
        if data["viewpoint"] is not None:
            where = f" at position {data['position'] + 1} from {self.viewpoints[data['viewpoint']]}"
        return f"warning: labels{where} no longer come as the tables say; estimate them anew"

    def _decision(self, data: dict[str, Any]) -> str:
        what = "reject" if data["label"] is None else f"decide {self.classes[data['label']]}"
        forced = f", forced by {data['forced']}" if data["forced"] else ""
        self._shift()
        return f"{what}  (belief {data['belief']:.3f}, {data['looks']} looks{forced})"

    def _skip(self) -> str:
        self._shift()
        return "nothing there, skipped"

    def _shift(self) -> None:
        self.belief = [*self.belief[1:], self._arrival]
