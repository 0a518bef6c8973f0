"""Renders what the camera of cell_node.py sees, with the simulated cell of beltsort: `renderer.py CELL.toml`.

For each line of JSON on standard input, the state of the cell, it writes a line of JSON, the camera's
parameters and the classes of the objects that it sees, and then the depths, metres, float32 row by row, 0
where nothing returns. With a real camera you need none of this.
"""

import json
import sys

import numpy as np

from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.simulated import SimulatedOptions, config_of, true_labels
from beltsort.drivers.ros.joints import standing_at
from beltsort.sim.cell import SimulatedCell

TOLERANCE = 0.02
"""Radians from a viewpoint's taught joints; elsewhere nothing is seen."""


class Renderer:
    """The simulated cell in front of the camera; `cell` is the cell file."""

    def __init__(self, cell):
        options = SimulatedOptions(draw_from=("elongated", "livarno"), seed=0)
        further = true_labels(options, cell)  # without end: a second run goes on with the objects that follow
        self.simulated = SimulatedCell([], config_of(cell, options), options.seed, further=further)
        self.viewpoints, self.taught = cell.viewpoint_names, cell.options_of("arm")["taught"]
        self.scans = 0

    def names(self):
        """Return the classes of the objects that are seen, from the belt end on."""
        first, seen = self.simulated.position(), self.simulated.layout.positions
        return [self.simulated.classes[self.simulated.true_class(first + place)] for place in range(seen)]

    def depths(self, joints, number, taken):
        """Return depths, metres, shape (height, width)."""
        self.simulated.follow(number, self.simulated.clock)
        if taken:
            self.simulated.sort(0, f"sort-{number}")
        viewpoint = standing_at(self.taught, joints, TOLERANCE)
        if viewpoint is None:
            return np.zeros((self.simulated.config.camera.height, self.simulated.config.camera.width))
        self.scans += 1
        move = self.simulated.move_to(self.viewpoints.index(viewpoint), f"move-{self.scans}")
        return np.nan_to_num(self.simulated.scan(not_before=move).points[..., 2])


def main():
    """Serve until standard input ends."""
    renderer = Renderer(CellDescription.load(sys.argv[1]))
    for line in sys.stdin:
        state = json.loads(line)
        depths = renderer.depths(state["joints"], state["object"], state["taken"])
        height, width = depths.shape
        focal = renderer.simulated.config.camera.focal
        camera = {"height": height, "width": width, "focal": focal, "classes": renderer.names()}
        sys.stdout.buffer.write(json.dumps(camera).encode() + b"\n" + depths.astype("<f4").tobytes())
        sys.stdout.buffer.flush()


if __name__ == "__main__":
    main()
