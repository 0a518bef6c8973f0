"""Whether an arm reaches a camera pose: inverse kinematics of a URDF through pinocchio (the extra `ik`)."""

from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beltsort import ArgumentError
from beltsort.errors import ViewpointError
from beltsort.geometry import Pose
from beltsort.util.extras import extra

DAMPING = 1e-6  # least damping, so that a singular arm still gets a bounded step


@dataclass(frozen=True)
class Arm:
    """An arm that carries the camera, its frame the frame `tip` of the URDF.

    Each step solves (J J^T + mu I) y = e and turns the joints by J^T y, where e is the remaining twist of the
    tip (the logarithm of the rigid motion that is left) and J its derivative by the joints [1]_; the damping
    mu = |e|^2 / 2 + 1e-6 vanishes as the tip arrives [2]_. Joints are kept within their limits after every
    step. A search that does not arrive starts again from another random configuration.

    False is no proof that a pose is out of reach: more restarts may find a configuration. True says nothing
    about collisions, neither there nor on the way. The camera's roll about its optical axis is not free: the
    world's z is up in its image (`geometry.look_at`).

    Attributes
    ----------
    urdf
        The robot's description; its meshes are not read.
    tip
        Name of the camera's frame in it: x right, y down, z forward.
    base
        Where the URDF's root stands: x, y, z from the belt end, metres, and the yaw about z, degrees.
    tolerance
        Largest |e| that counts as reached: metres and radians together, as the norm of the twist.
    restarts
        Searches before a pose counts as unreachable.
    iterations
        Steps of one search.
    seed
        Of the random configurations: the result for a pose is a function of the pose and these attributes.

    Raises
    ------
    ArgumentError
        If a number is out of range.
    ViewpointError
        If pinocchio is missing, the URDF cannot be read, has no such frame, or has joints without limits.

    References
    ----------
    .. [1] pinocchio's documentation, "Inverse kinematics (CLIK)".
    .. [2] T. Sugihara, "Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt method", IEEE
       Transactions on Robotics 27 (2011) 984-991.
    """

    urdf: Path
    tip: str
    base: tuple[float, float, float, float]
    tolerance: float = 1e-4
    restarts: int = 20
    iterations: int = 60
    seed: int = 0

    def __post_init__(self) -> None:
        """Check the numbers."""
        if not np.isfinite(self.base).all():
            raise ArgumentError(f"base is {self.base}, expected finite x, y, z (metres) and yaw (degrees)")
        if not 0.0 < self.tolerance < np.inf:
            raise ArgumentError(f"tolerance is {self.tolerance}, expected a number above 0, 1e-4 for example")
        if min(self.restarts, self.iterations) < 1:
            raise ArgumentError(
                f"{self.restarts} restarts of {self.iterations} iterations, expected at least 1 each"
            )

    def __call__(self, world_from_camera: Pose) -> bool:
        """Whether the camera can be brought to a pose, shape (4, 4)."""
        return self.joints(world_from_camera) is not None

    def joints(self, world_from_camera: Pose) -> NDArray[np.float64] | None:
        """Return a configuration within the joint limits that brings the camera there, or None."""
        pin, (model, _data, _frame) = load_pinocchio(), self._loaded
        target = pin.SE3(np.linalg.inv(self._world_from_base) @ world_from_camera)
        pin.seed(self.seed)
        for _ in range(self.restarts):
            found = self._search(target, pin.randomConfiguration(model))
            if found is not None:
                return found
        return None

    def camera_at(self, joints: NDArray[np.float64]) -> Pose:
        """Return `world_from_camera` of a configuration, shape (4, 4)."""
        model, data, frame = self._loaded
        load_pinocchio().framesForwardKinematics(model, data, joints)
        pose: Pose = self._world_from_base @ data.oMf[frame].homogeneous
        return pose

    def _search(self, target: Any, joints: NDArray[np.float64]) -> NDArray[np.float64] | None:
        pin, (model, data, frame) = load_pinocchio(), self._loaded
        for _ in range(self.iterations):
            pin.framesForwardKinematics(model, data, joints)
            left = data.oMf[frame].actInv(target)
            twist = pin.log6(left).vector
            size = twist @ twist
            if size < self.tolerance**2:
                return joints
            jacobian = pin.Jlog6(left.inverse()) @ pin.computeFrameJacobian(model, data, joints, frame)
            damped = jacobian @ jacobian.T + (0.5 * size + DAMPING) * np.eye(6)
            turned = pin.integrate(model, joints, jacobian.T @ np.linalg.solve(damped, twist))
            joints = np.clip(turned, model.lowerPositionLimit, model.upperPositionLimit)
        return None

    @cached_property
    def _world_from_base(self) -> Pose:
        x, y, z, yaw = self.base
        c, s = np.cos(np.radians(yaw)), np.sin(np.radians(yaw))
        return np.array([[c, -s, 0.0, x], [s, c, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]])

    @cached_property
    def _loaded(self) -> tuple[Any, Any, int]:
        """Return pinocchio's model, its data, and the index of the camera's frame."""
        pin = load_pinocchio()
        try:
            model = pin.buildModelFromUrdf(str(self.urdf))
        except ValueError as reason:
            raise ViewpointError(f"the URDF {self.urdf} cannot be read: {reason}") from reason
        try:
            pin.randomConfiguration(model)
        except RuntimeError as reason:
            raise ViewpointError(
                f"{self.urdf} has a joint without limits ({reason}), expected limits to draw configurations "
                "within: give every joint its own, or fix it"
            ) from reason
        if not model.existFrame(self.tip):
            names = [frame.name for frame in model.frames if frame.type == pin.FrameType.BODY]
            nearest = ", ".join(get_close_matches(self.tip, names, n=5, cutoff=0.0))
            raise ViewpointError(f"{self.urdf} has no frame {self.tip!r}; it has {nearest}, among others")
        return model, model.createData(), model.getFrameId(self.tip)


def load_pinocchio() -> Any:
    """Return the package pinocchio, which is imported on first use only.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    with extra("ik"):
        import pinocchio
    return pinocchio
