"""`beltsort show`: print a run."""

from argparse import ArgumentParser, Namespace
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path

from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json, print_status
from beltsort.sorting.audit import StepReader, with_steps, write_csv
from beltsort.sorting.entry_text import EntryFormatter
from beltsort.sorting.first_entry import model_of
from beltsort.sorting.journal import Entry, entries_of_journal, read_journal
from beltsort.sorting.moving.reading import is_moving, moving_state_in
from beltsort.sorting.moving.report import MovingReport
from beltsort.sorting.progress import Progress
from beltsort.sorting.run_state import LATEST
from beltsort.sorting.runs import journal_of, plain_decision

EXAMPLE = "beltsort show runs/2026-01-31T12-00-00.000000Z"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "show",
        help="print a run",
        description="Print the events of a run, which may still be in progress. The numbers in front are "
        "planner steps, as `beltsort explain --step` takes them and `beltsort watch` shows them.",
    )
    add_run(parser)
    parser.add_argument("--csv", type=Path, metavar="FILE", help="also write all entries to a CSV file")
    add_json(parser)
    parser.set_defaults(run=run)


def add_run(parser: ArgumentParser) -> None:
    """Add the run's folder."""
    help = "a run's folder, its journal.sqlite, or a folder of runs for the newest; `latest` is that of runs/"
    parser.add_argument("folder", metavar="RUN", type=Path, help=help)


def run(arguments: Namespace) -> int:
    """Read and print, and write the CSV file if requested.

    The entries are read one after the other, except for JSON, which has all of them.
    """
    journal = journal_of(arguments.folder)
    if arguments.csv is not None:
        written = write_csv(entries_of_journal(journal), arguments.csv)
        print_status(f"{written} entries written to {arguments.csv}")
    if is_moving(journal):
        show_moving(journal, as_json=arguments.json)
    elif arguments.json:
        print_json(as_json(read_journal(journal)))
    else:
        show(entries_of_journal(journal))
    return 0


def as_json(entries: Sequence[Entry]) -> dict[str, object]:
    """Return a run as plain data."""
    progress = Progress.after(entries, keep=None)
    return {
        "run": progress.run,
        "steps": progress.steps,
        "objects": progress.objects,
        "at_belt_end": progress.index,
        "decisions": [
            {**plain_decision(decision, progress.model.bins), **asdict(decision)}
            for decision in progress.decisions
        ],
        "skipped": progress.skipped,
        "drift": [alarm.to_dict() for alarm in progress.drift.alarms],
        "pose_faults": progress.pose_faults,
        "entries": [{**entry.plain(), "step": step} for entry, step in with_steps(entries)],
    }


def show_moving(journal: Path, *, as_json: bool) -> None:
    """Print a run on a belt that never stops, as text or JSON."""
    state = moving_state_in(journal)
    report, bins = MovingReport.of(state), state.belt.model.bins
    fates = {str(fate): number for fate, number in report.fates.items()}
    if as_json:
        print_json(
            {
                "run": state.run,
                "objects": state.objects,
                "left_belt": report.objects,
                "fates": fates,
                "bins": dict(zip(bins, report.bins, strict=True)),
                "scans": report.scans,
                "entries": [entry.plain() for entry in entries_of_journal(journal)],
            }
        )
        return
    formatter = EntryFormatter()
    print("time (UTC)")
    for entry in entries_of_journal(journal):
        if (line := formatter.format(entry)) is not None:
            print(f"{entry.time[:19].replace('T', ' ')}  {line}")
    left = "" if state.objects is None else f", {state.objects - report.objects} left"
    counts = ", ".join(f"{number} {fate}" for fate, number in fates.items() if number) or "none has left"
    print(f"{counts}{left}; {report.scans} scans")


def show(entries: Iterable[Entry]) -> None:
    """Print a line for each displayed entry, and what the run has come to."""
    formatter, reader = EntryFormatter(), None
    print("  step  time (UTC)")
    for entry in entries:
        reader = reader or StepReader(model_of([entry]), keep=LATEST)
        step = reader.step_of(entry)
        line = formatter.format(entry)
        if line is not None:
            print(f"{step or '':>6}  {entry.time[:19].replace('T', ' ')}  {line}")
    if reader is not None:
        show_progress(reader.progress)


def show_progress(progress: Progress) -> None:
    """Print what a run has come to."""
    done = f"{progress.counts.sorted} sorted, {progress.counts.skipped} empty"
    if progress.drift.alarms:
        print(f"{len(progress.drift.alarms)} drift alarms: labels no longer fit the observation tables")
    for fault, scans in progress.pose_faults.items():
        print(f"{scans} scans do not show the belt where their pose says; likely: {fault}")
    left = "" if progress.left is None else f", {progress.left} left"
    print(f"{done}{left}; {progress.steps} steps")
