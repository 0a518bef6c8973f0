"""Results as tables of pandas, which is imported only here and need not be installed."""

import math
from types import ModuleType
from typing import TYPE_CHECKING

from beltsort._core import Evaluation
from beltsort.planning.difference import Difference, PairedStatistics
from beltsort.util.extras import extra

if TYPE_CHECKING:
    import pandas as pd


def evaluation_frame(evaluation: Evaluation) -> "pd.DataFrame":
    """Return the outcomes of an evaluation, a row per batch.

    Raises
    ------
    MissingExtraError
        If pandas is not installed.
    """
    pandas = _pandas()
    columns = {metric: getattr(evaluation, metric) for metric in evaluation.summary()}
    return pandas.DataFrame(columns).rename_axis(index="batch")


def comparison_frame(found: PairedStatistics) -> "pd.DataFrame":
    """Return means and differences of a comparison, a row per policy and metric.

    Raises
    ------
    MissingExtraError
        If pandas is not installed.
    """
    pandas = _pandas()
    rows = {}
    for name, summary in found.summary.items():
        for metric in found.metrics:
            none = Difference(math.nan, math.nan)
            difference = found.differences[name][metric] if name in found.differences else none
            rows[name, metric] = {
                **summary[metric],
                "difference": difference.mean,
                "difference_standard_error": difference.standard_error,
                "z": difference.z,
            }
    frame = pandas.DataFrame.from_dict(rows, orient="index")
    return frame.rename_axis(index=["policy", "metric"])


def _pandas() -> ModuleType:
    with extra("pandas"):
        import pandas
    module: ModuleType = pandas
    return module
