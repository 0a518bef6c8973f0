"""What a run needs besides the devices: model, classifier and policy."""

from pathlib import Path

from beltsort import ArgumentError, MovingBelt, SortingModel, models
from beltsort.cellfile.bins import with_bins_of
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.moving import moving_policy
from beltsort.cellfile.problems import CellFileError
from beltsort.cellfile.sections import Planner
from beltsort.cellfile.simulated import trainable_config
from beltsort.errors import DatabaseError
from beltsort.perception import Classifier, PerceptionConfig, load_classifier
from beltsort.perception.classifier import check_classes
from beltsort.planning.named_policy import located_policy
from beltsort.planning.policy import MovingPolicy, Policy
from beltsort.sim.prepare import Recipe, StageProgress, prepare
from beltsort.sorting.runs import POLICY


def model_file(description: CellDescription) -> SortingModel:
    """Load the model that a cell file names."""
    return models.load(description.path(description.model or ""))


def known_model(
    description: CellDescription, model: SortingModel | None
) -> tuple[SortingModel | None, CellDescription]:
    """Return the model, and the cell file with the bins in the model's order.

    Parameters
    ----------
    description
        The cell file.
    model
        That of a run that is resumed; if None, the file's own is read, and None is returned if it has yet to
        be prepared.

    Raises
    ------
    CellFileError
        As `with_bins_of`.
    """
    if model is None and description.prepare is None:
        model = model_file(description)
    return model, description if model is None else with_bins_of(model, description)


def policy_of(description: CellDescription, model: SortingModel, resume: Path | None) -> tuple[Policy, str]:
    """Return the policy and its name: of a run that is resumed, the one with which it began."""
    planner, name = _planner_of(description, resume)
    try:
        return planner.policy_for(model, description.path("")), name
    except ArgumentError as reason:
        raise CellFileError.of("planner.policy", str(reason)) from reason


def moving_policy_of(
    description: CellDescription, belt: MovingBelt, resume: Path | None
) -> tuple[MovingPolicy, str]:
    """Return the policy of a belt that never stops, and its name, as `policy_of`."""
    planner, name = _planner_of(description, resume)
    try:
        return moving_policy(planner, belt, description.path("")), name
    except ArgumentError as reason:
        raise CellFileError.of("planner.policy", str(reason)) from reason


def _planner_of(description: CellDescription, resume: Path | None) -> tuple[Planner, str]:
    planner, folder = description.planner, description.path("")
    name = located_policy(planner.policy, folder.resolve())
    if resume is not None and (resume / POLICY).is_file():
        began = (resume / POLICY).read_text("utf-8").strip()
        if "policy" in planner.model_fields_set and began != name:
            raise CellFileError.of(
                "planner.policy",
                f'is "{name}", but the run began with "{began}": write policy = "{began}", or leave it out',
            )
        if began != name:
            name, planner = began, Planner(policy=began)
    return planner, name


def model_and_classifier(
    description: CellDescription, model: SortingModel | None, progress: StageProgress | None
) -> tuple[SortingModel, Classifier]:
    """Load the files of the cell file, or prepare a simulated cell; a model that is given is kept."""
    if description.prepare is not None:
        perception = description.perception or PerceptionConfig()
        amounts = description.prepare.model_dump()
        prepared = prepare(Recipe(trainable_config(description), perception, **amounts), progress=progress)
        own = prepared.counts.model(description.classes, description.viewpoint_names)
        return model or own, prepared.database
    classifier = classifier_of(description)
    return model or model_file(description), classifier


def classifier_of(description: CellDescription) -> Classifier:
    """Load the classifier that a cell file names.

    Raises
    ------
    CellFileError
        If it has other classes than the file, or in another order.
    BeltsortError
        If it cannot be loaded.
    """
    classifier = load_classifier(description.classifier or "", description.path(""))
    try:
        check_classes(classifier, description.classes, "the cell file's")
    except DatabaseError as reason:
        raise CellFileError.of("classifier", str(reason)) from reason
    return classifier
