"""Labels of the scans that `beltsort estimate` is given, and the logs beside its model."""

import warnings
from argparse import Namespace
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TypeVar

from beltsort import ArgumentError
from beltsort.cli.output import print_status
from beltsort.cli.progress import tenths
from beltsort.cli.table_source import SIMULATED, SimulatedSource, digest, fingerprint, source_of
from beltsort.sim.config import TABLE_OBJECTS
from beltsort.util.keyed_log import KeyedLog

Log = TypeVar("Log", bound=KeyedLog)

if TYPE_CHECKING:
    from beltsort.perception import Classifier, LabelRule
    from beltsort.tables.findings import FindingCounts
    from beltsort.tables.log import LabelLog
    from beltsort.tables.matches import MatchedScan, MatchLog
    from beltsort.tables.recording import Recording
    from beltsort.tables.scans import LabelledScan

SEED = 0


class Labelled(NamedTuple):
    """Labelled scans, the names of classes and viewpoints, and the rule that made the labels, if any.

    `found` counts what the scans showed, with classes as the labels.
    """

    classes: list[str]
    viewpoints: list[str]
    scans: "list[LabelledScan]"
    rule: "LabelRule | None"
    named_modes: dict[str, str]
    found: "FindingCounts"


def labelled_scans(arguments: Namespace) -> Labelled:
    """Label the scans of the cell, and print a line for each kind of problem with them.

    Raises
    ------
    RecordingError
        If no object got a label.
    """
    from beltsort.perception import PoseWarning

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PoseWarning)  # `tell_findings` prints them
        return label_cell(arguments)


def label_cell(arguments: Namespace) -> Labelled:
    """Label the scans of the cell."""
    source = source_of(arguments)
    if isinstance(source, Path):
        from beltsort.tables.recording import read_recording

        check_recorded(arguments)
        return from_recording(read_recording(source), load(arguments), arguments)
    train_if_missing(source, arguments)
    objects = TABLE_OBJECTS if arguments.objects is None else arguments.objects
    seed = SEED if arguments.seed is None else arguments.seed
    if arguments.record is None:
        return from_simulation(load(arguments), source, arguments, objects, seed)
    from beltsort.sim.record import record_simulated

    recording = record_simulated(
        arguments.record,
        source.config,
        objects=objects,
        seed=seed,
        passages=several_modes(arguments),
        workers=arguments.workers,
        progress=tenths("recording"),
    )
    return from_recording(recording, load(arguments), arguments)


def several_modes(arguments: Namespace) -> bool:
    """Return whether more than one mode may be fitted, which takes several looks at each object."""
    return arguments.modes not in (None, "1")


def check_recorded(arguments: Namespace) -> None:
    """Reject options that do not apply to a folder of recorded scans, and require a classifier."""
    for name in ("record", "objects", "seed"):
        if (given := getattr(arguments, name)) is not None:
            raise ArgumentError(
                f"--{name} {given} does not apply to {arguments.cell!r}, a folder of recorded scans; leave "
                "it out"
            )
    if arguments.classifier is None:
        raise ArgumentError(
            "--classifier is missing, expected a trained classifier, with which to label "
            "the recorded scans; `beltsort train` writes one"
        )


def train_if_missing(source: SimulatedSource, arguments: Namespace) -> None:
    """Make sure that a classifier is given: the cell file's, or one that is trained once and saved."""
    if arguments.classifier is None:
        arguments.classifier = source.classifier
    name = classifier_name(arguments)
    if arguments.classifier is None and not Path(name).exists():
        source.train().save(name)
        print_status(f"classifier: {name}")


def load(arguments: Namespace) -> "Classifier":
    """Load the classifier."""
    from beltsort.perception import load_classifier

    return load_classifier(classifier_name(arguments))


def classifier_name(arguments: Namespace) -> str:
    """Return the name of the classifier, of which a file need not exist yet."""
    return arguments.classifier or str(arguments.output.with_suffix(".classifier.npz"))


def from_simulation(
    database: "Classifier", source: SimulatedSource, arguments: Namespace, objects: int, seed: int
) -> Labelled:
    """Label scans of a simulated cell."""
    from beltsort.sim.collect import collect_matches, collect_scans

    config = source.config
    settings = {"cell": SIMULATED, "seed": str(seed), "config": source.fingerprint()}
    given = {
        "objects": objects,
        "seed": seed,
        "passages": several_modes(arguments),
        "workers": arguments.workers,
        "progress": tenths("scans"),
    }
    viewpoints = [viewpoint.name for viewpoint in config.viewpoints]
    if arguments.levels is None:
        with log_beside(arguments, settings) as log:
            scans = collect_scans(database, config, log=log, **given)
        return without_levels(scans, list(config.classes), viewpoints, {})
    with match_log_beside(arguments, settings) as matches:
        matched = collect_matches(database, config, log=matches, **given)
    return with_levels(database, matched, viewpoints, {}, arguments)


def from_recording(recording: "Recording", database: "Classifier", arguments: Namespace) -> Labelled:
    """Label recorded scans."""
    from beltsort.tables.label import label_recording, match_recording

    header = recording.header
    settings = {"cell": "recorded", "layout": fingerprint(asdict(header.layout))}
    given = {"workers": arguments.workers, "progress": tenths("scans")}
    classes, viewpoints = list(header.classes), list(header.viewpoints)
    if arguments.levels is None:
        with log_beside(arguments, settings) as log:
            scans = label_recording(recording, database, log=log, **given)
        return without_levels(scans, classes, viewpoints, recording.modes())
    with match_log_beside(arguments, settings) as matches:
        matched = match_recording(recording, database, log=matches, **given)
    return with_levels(database, matched, viewpoints, recording.modes(), arguments)


def without_levels(
    scans: "list[LabelledScan]", classes: list[str], viewpoints: list[str], named_modes: dict[str, str]
) -> Labelled:
    """Return scans whose labels are the classes."""
    return Labelled(classes, viewpoints, scans, None, named_modes, tell_findings(scans, viewpoints))


def tell_findings(scans: "list[LabelledScan]", viewpoints: list[str]) -> "FindingCounts":
    """Count what scans found, and print a line for each kind of problem.

    Raises
    ------
    RecordingError
        If no object got a label.
    """
    from beltsort.tables.findings import FindingCounts

    found = FindingCounts.of(scans, viewpoints)
    found.check_labelled()
    for warning in found.warnings():
        print_status(f"Warning: {warning}.")
    return found


def with_levels(
    database: "Classifier",
    scans: "list[MatchedScan]",
    viewpoints: list[str],
    named_modes: dict[str, str],
    arguments: Namespace,
) -> Labelled:
    """Label scans with a rule of so many levels, and print how it was chosen."""
    from beltsort.perception import LabelRule
    from beltsort.tables.confidence import fit_levels

    classes = tuple(database.classes)
    found = tell_findings([scan.labelled(LabelRule(classes)) for scan in scans], viewpoints)
    levels = None if arguments.levels == "auto" else int(arguments.levels)
    choice = fit_levels(database, scans, len(viewpoints), levels=levels, smoothing=arguments.smoothing)
    losses = ", ".join(f"{loss:.3f}" for loss in choice.log_losses)
    print_status(f"levels of confidence: {choice.rule.levels} (held-out log-loss {losses})")
    labelled = [scan.labelled(choice.rule) for scan in scans]
    return Labelled(list(classes), viewpoints, labelled, choice.rule, named_modes, found)


def log_beside(arguments: Namespace, settings: dict[str, str]) -> "LabelLog":
    """Open the log of labels beside the model, and print the number of scans in it."""
    from beltsort.tables.log import LabelLog

    return _opened(LabelLog, "labelled", arguments, settings)


def match_log_beside(arguments: Namespace, settings: dict[str, str]) -> "MatchLog":
    """Open the log of matches beside the model, and print the number of scans in it."""
    from beltsort.tables.matches import MatchLog

    return _opened(MatchLog, "classified", arguments, settings)


def _opened(kind: type[Log], done: str, arguments: Namespace, settings: dict[str, str]) -> Log:
    path = arguments.output.with_suffix(f".{kind.contents}")
    log = kind(path, settings | classifier_settings(arguments))
    if known := len(log.values()):
        print_status(f"{known} scans are already {done} in {path}")
    return log


def classifier_settings(arguments: Namespace) -> dict[str, str]:
    """Return what a log is known to belong to: a database's content, or the name of another classifier."""
    name = classifier_name(arguments)
    return {"classifier": digest(Path(name).read_bytes() if Path(name).exists() else name.encode())}
