"""The node by which `beltsort run` publishes a run on ROS 2."""

from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING

from beltsort.cli.output import print_status

if TYPE_CHECKING:
    from beltsort.cellfile.run import CellRun
    from beltsort.ros2.run_node import RunNode


def ros2_node(run: "CellRun") -> "AbstractContextManager[RunNode | None]":
    """Return the node of a run, which runs as long as the context; nothing unless the cell file has one."""
    if run.description.ros2 is None:
        return nullcontext()
    from beltsort.cellfile.paths import resolved
    from beltsort.ros2.markers import Scene
    from beltsort.ros2.run_node import Parameter, RunDescription, RunNode

    description, model = run.description, run.model
    options = resolved(run.description.ros2, description)
    parameters: dict[str, Parameter] = {
        "run": run.folder.name,
        "policy": run.policy_name,
        "objects": description.objects or 0,
        "classes": list(model.classes),
        "bins": list(model.bins),
        "viewpoints": list(model.viewpoints),
        "positions": model.positions,
        "frame": options.frame,
    }
    told = RunDescription(run.folder, parameters, Scene.of(run.cell), model.labels, run.broken_off)
    return RunNode(options, told, print_status)
