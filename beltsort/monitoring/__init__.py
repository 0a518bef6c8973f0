"""For whoever looks after runs of weeks: a log file, and metrics for Prometheus (docs/monitoring.md).

Both are fed by the entries of the journal and never end a run.
"""
