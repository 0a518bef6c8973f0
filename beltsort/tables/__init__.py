"""From labels of many scans to observation tables and a model, and whether the tables still hold."""

from beltsort.tables.confidence import RuleChoice, choose_rule, fit_levels
from beltsort.tables.counts import Counts, Look, count
from beltsort.tables.drift import Alarm, DriftWatch
from beltsort.tables.estimate import Estimate, estimate
from beltsort.tables.label import label_recording, match_recording
from beltsort.tables.layout import agreement_text, table_one, table_two
from beltsort.tables.log import LabelLog
from beltsort.tables.matches import MatchedScan, MatchLog, Seen
from beltsort.tables.mode_choice import ModeChoice, choose_modes
from beltsort.tables.modes import ModeSettings, ModeTables, fit_modes
from beltsort.tables.pooling import pooled_prior
from beltsort.tables.recording import read_recording
from beltsort.tables.repeated_looks import LooksAtObject, RepeatedLooks, TableShape, looks_at_objects
from beltsort.tables.scans import LabelledScan

__all__ = [
    "Alarm",
    "Counts",
    "DriftWatch",
    "Estimate",
    "LabelLog",
    "LabelledScan",
    "Look",
    "LooksAtObject",
    "MatchLog",
    "MatchedScan",
    "ModeChoice",
    "ModeSettings",
    "ModeTables",
    "RepeatedLooks",
    "RuleChoice",
    "Seen",
    "TableShape",
    "agreement_text",
    "choose_modes",
    "choose_rule",
    "count",
    "estimate",
    "fit_levels",
    "fit_modes",
    "label_recording",
    "looks_at_objects",
    "match_recording",
    "pooled_prior",
    "read_recording",
    "table_one",
    "table_two",
]
