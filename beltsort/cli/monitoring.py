"""The log file and the metrics of `beltsort run`."""

from argparse import ArgumentParser, Namespace
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from beltsort.cli.output import print_status

if TYPE_CHECKING:
    from beltsort.cell.wrappers.recorder import Recorded
    from beltsort.cellfile.moving_run import MovingRun
    from beltsort.cellfile.run import CellRun
    from beltsort.monitoring.log_file import LogFile
    from beltsort.monitoring.metrics import RunMetrics


def add_monitoring(parser: ArgumentParser) -> None:
    """Add the options, a group of their own."""
    group = parser.add_argument_group(
        "for runs of weeks", "docs/monitoring.md describes the lines of the log, and every metric."
    )
    group.add_argument("--log", type=Path, metavar="FILE", help="log to a file, which is rotated")
    group.add_argument(
        "--log-format", choices=["text", "json"], default="text", help="lines of text (default) or JSON"
    )
    group.add_argument(
        "--log-level",
        choices=["debug", "info", "warning", "error"],
        default="info",
        help="the lowest level that is logged (default: info); debug has every entry of the journal",
    )
    group.add_argument(
        "--metrics",
        type=int,
        metavar="PORT",
        help="serve metrics for Prometheus on a port of this computer, 0 for any that is free (extra "
        "`metrics`)",
    )


@dataclass
class Monitoring:
    """What listens to a run."""

    log: "LogFile | None" = None
    metrics: "RunMetrics | None" = None

    @property
    def listeners(self) -> "tuple[LogFile | RunMetrics | None, ...]":
        """Listeners of the journal."""
        return self.log, self.metrics

    def called(self, recorded: "Recorded") -> None:
        """Hear of a call of a device."""
        if self.metrics is not None:
            self.metrics.called(recorded)

    def opened(self, run: "CellRun | MovingRun") -> None:
        """Hear which run it is."""
        if self.metrics is not None:
            self.metrics.folder = run.folder
        if run.broken_off is None:
            return
        if self.log is not None:
            self.log.entries.resume(run.broken_off)
        if self.metrics is not None:
            self.metrics.resume(run.broken_off)


@contextmanager
def monitoring(arguments: Namespace) -> Iterator[Monitoring]:
    """Open the log file, and serve the metrics, that the options ask for."""
    found = Monitoring()
    with ExitStack() as stack:
        if arguments.log is not None:
            from beltsort.monitoring.log_file import LogFile

            settings = {"format": arguments.log_format, "level": arguments.log_level}
            found.log = stack.enter_context(LogFile(arguments.log, print_status, **settings))
        if arguments.metrics is not None:
            from beltsort.monitoring.metrics import MetricsServer, RunMetrics

            found.metrics = RunMetrics()
            server = stack.enter_context(MetricsServer(found.metrics, arguments.metrics))
            print_status(f"metrics: {server.url}")
        yield found


def monitoring_words(arguments: Namespace) -> list[str]:
    """Return the options as given, for the command that resumes the run."""
    words = [] if arguments.log is None else ["--log", str(arguments.log)]
    for option, default in (("log_format", "text"), ("log_level", "info")):
        if arguments.log is not None and getattr(arguments, option) != default:
            words += [f"--{option.replace('_', '-')}", getattr(arguments, option)]
    return words if arguments.metrics is None else [*words, "--metrics", str(arguments.metrics)]
