"""The built-in back-ends for real cells."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from beltsort.cellfile.paths import resolved
from beltsort.cellfile.registry import Backend, backend_of
from beltsort.cellfile.validation import validated
from beltsort.drivers import modbus, opcua, replay, ros1, ros2

if TYPE_CHECKING:
    from beltsort.cellfile.description import CellDescription


def with_viewpoints(given: Mapping[str, object], cell: "CellDescription") -> Mapping[str, object]:
    """Return the options in the cell file, with the cell's viewpoints as the default of `viewpoints`."""
    return {"viewpoints": list(cell.viewpoint_names), **given}


OPCUA = backend_of(opcua.OpcuaOptions, lambda options, cell: opcua.make(resolved(options, cell)), shared=True)
MODBUS = backend_of(
    modbus.ModbusOptions, lambda options, cell: modbus.make(resolved(options, cell)), shared=True
)
OPCUA_DIVERTER = backend_of(
    opcua.OpcuaOptions, lambda options, cell: opcua.make_diverter(resolved(options, cell))
)
MODBUS_DIVERTER = backend_of(
    modbus.ModbusOptions, lambda options, cell: modbus.make_diverter(resolved(options, cell))
)
ROS1_CAMERA = backend_of(ros1.Ros1CameraOptions, lambda options, _cell: ros1.Ros1Camera(options))
ROS1_BELT = backend_of(ros1.Ros1BeltOptions, lambda options, _cell: ros1.Ros1Belt(options))
ROS1_SORTER = backend_of(ros1.Ros1SorterOptions, lambda options, _cell: ros1.Ros1Sorter(options))
ROS1_ARM = Backend(
    lambda given, cell: ros1.Ros1Arm(validated(ros1.Ros1ArmOptions, with_viewpoints(given, cell)))
)
ROS2_CAMERA = backend_of(
    ros2.Ros2CameraOptions, lambda options, cell: ros2.Ros2Camera(resolved(options, cell))
)
ROS2_BELT = Backend(
    lambda given, cell: (
        ros2.Ros2ServiceBelt(resolved(validated(ros2.Ros2ServiceBeltOptions, given), cell))
        if "advance_service" in given
        else ros2.Ros2Belt(resolved(validated(ros2.Ros2BeltOptions, given), cell))
    )
)
ROS2_SORTER = Backend(
    lambda given, cell: (
        ros2.Ros2ServiceSorter(resolved(validated(ros2.Ros2ServiceSorterOptions, given), cell))
        if "services" in given
        else ros2.Ros2Sorter(resolved(validated(ros2.Ros2SorterOptions, given), cell))
    )
)
ROS2_ARM = Backend(
    lambda given, cell: ros2.Ros2Arm(
        resolved(validated(ros2.Ros2ArmOptions, with_viewpoints(given, cell)), cell)
    )
)
ROS2_DIVERTER = backend_of(
    ros2.Ros2DiverterOptions, lambda options, cell: ros2.Ros2Diverter(resolved(options, cell))
)
REPLAY = Backend(
    lambda given, cell: replay.Replay(
        resolved(validated(replay.ReplayOptions, with_viewpoints(given, cell)), cell)
    ),
    shared=True,
    harmless=True,
)
