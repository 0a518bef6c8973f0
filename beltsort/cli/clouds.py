"""What the commands about clouds share."""

from argparse import ArgumentParser, ArgumentTypeError
from math import isfinite

ORIGIN = (0.0, 0.0, 0.0)


def add_viewpoint(parser: ArgumentParser) -> None:
    """Add the camera's position."""
    parser.add_argument(
        "--viewpoint",
        type=position,
        metavar="X,Y,Z",
        help="the camera's position in the frame of every cloud, metres (default: the frame's origin; the "
        "VIEWPOINT of a PCD file is not used). Before a minus sign write --viewpoint=X,Y,Z",
    )


def position(text: str) -> tuple[float, ...]:
    """Read three numbers separated by commas."""
    try:
        numbers = tuple(float(word) for word in text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) != 3 or not all(map(isfinite, numbers)):
        raise ArgumentTypeError(f"{text!r}: expected three finite numbers X,Y,Z, such as 0,0,0.7")
    return numbers
