"""From labels of many scans to observation tables and a model."""

from beltsort.tables.collect import collect_counts, collect_training
from beltsort.tables.counts import Counts, Look, count
from beltsort.tables.layout import agreement_text, table_one, table_two

__all__ = [
    "Counts",
    "Look",
    "agreement_text",
    "collect_counts",
    "collect_training",
    "count",
    "table_one",
    "table_two",
]
