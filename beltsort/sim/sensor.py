"""The structured-light camera and the parameters of its noise."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beltsort.errors import CellError
from beltsort.util.naming import suggests_keywords

Array = NDArray[np.float64]


@suggests_keywords
@dataclass(frozen=True)
class Camera:
    """A pinhole camera with a pattern projector beside it.

    Attributes
    ----------
    width, height
        Pixels.
    focal
        Focal length, pixels; the principal point is the middle of the image.
    baseline
        Distance of the projector from the camera along the image's x axis, metres [1]_.

    References
    ----------
    .. [1] K. Khoshelham, S. O. Elberink, "Accuracy and resolution of Kinect depth data for indoor mapping
       applications", Sensors 12 (2012) 1437-1454.
    """

    width: int = 640
    height: int = 480
    focal: float = 570.0
    baseline: float = 0.075

    def slopes(self, columns: Array, rows: Array) -> tuple[Array, Array]:
        """Return x / z of pixel columns and y / z of pixel rows."""
        x = (columns - (self.width - 1) / 2.0) / self.focal
        y = (rows - (self.height - 1) / 2.0) / self.focal
        return x, y

    def deproject(self, depth: Array, top: int = 0, left: int = 0) -> Array:
        """Return the points of a depth image, shape (h, w), metres, whose first pixel is (`top`, `left`).

        They are in the camera frame, metres, shape (h, w, 3).
        """
        rows, columns = (np.arange(n, dtype=np.float64) for n in depth.shape)
        x, y = self.slopes(left + columns, top + rows)
        return np.stack([x * depth, y[:, None] * depth, depth], axis=-1)


@suggests_keywords
@dataclass(frozen=True)
class SensorNoise:
    """Noise of a structured-light camera, with a surface model for glossy, translucent objects.

    The axial, lateral and disparity numbers are those of [1]_ and [2]_. For the others the references
    describe the effect; its size is our choice.

    Attributes
    ----------
    axial_floor, axial_growth, axial_nearest
        sigma_z = floor + growth (z - nearest)^2 [1]_, metres, 1/m, metres.
    axial_incidence
        Further sigma_z of incidence / sqrt(z) (theta / (pi/2 - theta))^2 at incidence angle theta [1]_,
        m^1.5.
    axial_window
        Side of the square over which the axial error is smooth, pixels: depth comes from matching a window of
        the pattern, so that neighbouring pixels share their error [2]_ [5]_.
    lateral_floor, lateral_incidence
        sigma_L = floor + incidence theta / (pi/2 - theta) [1]_, pixels.
    disparity_step
        Quantum of disparity, pixels [2]_.
    grazing
        Incidence angle at which half of the returns of a matt surface are lost, degrees [5]_.
    grazing_width
        Width of that logistic transition, degrees.
    mixed_jump
        Depth step between neighbouring pixels beyond which a pixel may see both surfaces, metres.
    mixed_share
        Probability that such a pixel is a flying pixel, somewhere between the two [3]_.
    gloss_loss, gloss_loss_grazing
        Share of returns that a glass surface loses at normal and at grazing incidence; it grows between them
        with (1 - cos theta)^`gloss_exponent`, after the share that is mirrored away [4]_.
    gloss_exponent
        5 for a clear, smooth surface (Schlick's approximation of Fresnel's law), less for a coated one.
    gloss_patch
        Correlation length of the losses, pixels: a lost pattern window loses all its pixels [4]_ [5]_.
    highlight
        Half angle about the mirror direction from projector to camera within which glass blinds the camera,
        degrees [5]_.
    gloss_depth
        Standard deviation of the depth error on glass, metres: the pattern is seen through the surface, on
        what lies behind it or where it scatters, in patches of `gloss_patch` [4]_.
    gloss_bias
        Mean of that error, metres; positive is too far.

    References
    ----------
    .. [1] C. V. Nguyen, S. Izadi, D. Lovell, "Modeling Kinect sensor noise for improved 3D reconstruction and
       tracking", 3DIMPVT 2012.
    .. [2] K. Khoshelham, S. O. Elberink, "Accuracy and resolution of Kinect depth data for indoor mapping
       applications", Sensors 12 (2012) 1437-1454.
    .. [3] H. Sarbolandi, D. Lefloch, A. Kolb, "Kinect range sensing: structured-light versus time-of-flight
       Kinect", Computer Vision and Image Understanding 139 (2015) 1-20.
    .. [4] I. Lysenkov, V. Eruhimov, G. Bradski, "Recognition and pose estimation of rigid transparent objects
       with a Kinect sensor", Robotics: Science and Systems 2012.
    .. [5] T. Mallick, P. P. Das, A. K. Majumdar, "Characterizations of noise in Kinect depth images: a
       review", IEEE Sensors Journal 14 (2014) 1731-1740.
    """

    axial_floor: float = 0.0012
    axial_growth: float = 0.0019
    axial_nearest: float = 0.4
    axial_incidence: float = 0.0001
    axial_window: int = 3
    lateral_floor: float = 0.8
    lateral_incidence: float = 0.035
    disparity_step: float = 0.125
    grazing: float = 80.0
    grazing_width: float = 3.0
    mixed_jump: float = 0.01
    mixed_share: float = 0.3
    gloss_loss: float = 0.27
    gloss_loss_grazing: float = 0.95
    gloss_exponent: float = 3.0
    gloss_patch: int = 9
    highlight: float = 6.0
    gloss_depth: float = 0.0035
    gloss_bias: float = 0.002

    def __post_init__(self) -> None:
        """Check that steps and widths, which are divisors, are above 0."""
        for name in ("axial_window", "disparity_step", "grazing_width", "gloss_patch"):
            value = getattr(self, name)
            if not 0.0 < value < np.inf:
                raise CellError(f"{name} is {value}, expected above 0 and finite; start from the default")

    def axial_sigma(self, z: Array, incidence: Array) -> Array:
        """Return the standard deviation of depth, metres, at depth `z` (metres) and `incidence` (radians)."""
        distance = self.axial_floor + self.axial_growth * (z - self.axial_nearest) ** 2
        return distance + self.axial_incidence / np.sqrt(z) * _steepness(incidence) ** 2

    def lateral_sigma(self, incidence: Array) -> Array:
        """Return the standard deviation of the pixel that a return is attributed to, pixels."""
        return self.lateral_floor + self.lateral_incidence * _steepness(incidence)

    def matt_loss(self, incidence: Array) -> Array:
        """Return the probability that a matt surface gives no return at `incidence` (radians)."""
        beyond = (np.degrees(incidence) - self.grazing) / self.grazing_width
        return 0.5 + 0.5 * np.tanh(beyond / 2.0)

    def glass_loss(self, incidence: Array) -> Array:
        """Return the probability that glass gives no return at `incidence` (radians)."""
        fresnel = (1.0 - np.cos(incidence)) ** self.gloss_exponent
        return self.gloss_loss + (self.gloss_loss_grazing - self.gloss_loss) * fresnel


def _steepness(incidence: Array) -> Array:
    """Return theta / (pi/2 - theta), limited to 89 degrees, beyond which there are no returns."""
    theta = np.minimum(incidence, np.radians(89.0))
    return theta / (np.pi / 2.0 - theta)
