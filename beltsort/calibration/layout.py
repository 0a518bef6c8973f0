"""Tables of calibration results, as rows of text."""

from collections.abc import Mapping

from beltsort.calibration.causes import Causes
from beltsort.calibration.check import Arm
from beltsort.calibration.promise import Promise
from beltsort.calibration.reliability import Reliability
from beltsort.planning.difference import Difference

Rows = list[list[str]]


def arms_rows(arms: Mapping[str, Arm]) -> Rows:
    """Return a column for each arm: means per object, and the calibration of each kind of beliefs."""
    columns = [_arm_column(arm) for arm in arms.values()]
    names = list(columns[0])
    return [["", *arms], *([name, *(column[name] for column in columns)] for name in names)]


def _arm_column(arm: Arm) -> dict[str, str]:
    column = {name: _with_error(mean.mean, mean.standard_error) for name, mean in arm.means().items()}
    for kind, curve in arm.curves.items():
        column |= {f"{what} of {kind}": text for what, text in _curve_column(curve).items()}
    return column


def _curve_column(curve: Reliability) -> dict[str, str]:
    return {
        "ECE": _with_error(curve.ece, curve.ece_error),
        "ECE by chance": f"{curve.ece_chance:.3f} (p {curve.ece_p:.3f})",
        "Brier score": _with_error(curve.brier, curve.brier_error),
        "Brier if calibrated": f"{curve.brier_expected:.3f}",
    }


def differences_rows(differences: Mapping[str, Mapping[str, Difference]]) -> Rows:
    """Return a column for each arm but the first: mean difference, its error, and both as a ratio."""
    names = list(next(iter(differences.values())))
    return [
        ["", *differences],
        *(
            [name, *(f"{d.mean:+.3f} ± {d.standard_error:.3f} ({d.z:+.1f})" for d in cells)]
            for name in names
            for cells in [[by[name] for by in differences.values()]]
        ),
    ]


def promises_rows(promises: Mapping[str, Promise]) -> Rows:
    """Return a row for each arm: right decisions of ten, promised and from depth scans."""
    return [
        ["", "promised", "from depth scans", "difference (95 % interval)"],
        *(
            [
                name,
                f"{promise.promised.mean:.2f} ± {promise.promised.standard_error:.2f}",
                f"{promise.sorted.mean:.2f} ± {promise.sorted.standard_error:.2f}",
                f"{promise.difference.mean:+.2f} ({promise.interval[0]:+.2f} to {promise.interval[1]:+.2f})",
            ]
            for name, promise in promises.items()
        ),
    ]


def dependences_rows(causes: Causes) -> Rows:
    """Return a row for each kind of pairs of looks."""
    header = ["viewpoint", "position", "repeated", "both wrong", "if independent"]
    return [
        header,
        *(
            [
                "same" if found.same_viewpoint else "other",
                "same" if found.same_position else "other",
                _with_error(found.repeated, found.repeated_error),
                f"{found.both_wrong:.3f}",
                f"{found.both_wrong_expected:.3f}",
            ]
            for found in causes.dependences
        ),
    ]


def simulated_rows(causes: Causes) -> Rows:
    """Return a row for each arm and each kind of tables that labels were drawn from."""
    return [
        ["", "truth", "ECE of decisions", "by chance"],
        *(
            [name, what, _with_error(curve.ece, curve.ece_error), f"{curve.ece_chance:.3f}"]
            for name, curves in causes.simulated.items()
            for what, curve in curves.items()
        ),
    ]


def _with_error(value: float, error: float) -> str:
    return f"{value:.3f} ± {error:.3f}"
