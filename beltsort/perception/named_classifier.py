"""Classifiers by name: a database's file, an object in a Python module, or an installed package's.

A package offers a classifier by an entry point::

    [project.entry-points."beltsort.classifier"]
    acme = "acme_beltsort:CLASSIFIER"

The object is a `Classifier` or a `ProbabilityClassifier`, or it returns one when it is called without
arguments: a class, or a function that loads a network.
"""

from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, cast

from beltsort.errors import DatabaseError
from beltsort.perception.classifier import Classifier
from beltsort.perception.kernel_ridge import load_trained
from beltsort.perception.probabilities import FromProbabilities, ProbabilityClassifier
from beltsort.util import references
from beltsort.util.references import loaded, object_of

GROUP = "beltsort.classifier"
DATABASE = ".npz"
WHAT = "classifier"


def load_classifier(name: str, folder: Path | None = None) -> Classifier:
    """Return a classifier by its name.

    Parameters
    ----------
    name
        The path of a file that `beltsort train` wrote, `module:object`, or the name of an entry point.
    folder
        Where relative paths start, and where modules are found that are not installed; default: the working
        folder. It stays at the end of `sys.path`, since modules may import others later.

    Raises
    ------
    DatabaseError
        If the file cannot be read, the module or the object in it cannot be loaded, or it is no classifier.

    Examples
    --------
    >>> load_classifier("beltsort.perception:Missing")
    Traceback (most recent call last):
    ...
    beltsort.errors.DatabaseError: the classifier 'beltsort.perception:Missing' cannot be loaded: \
module 'beltsort.perception' has no attribute 'Missing'; expected module:object, both of them there: \
correct the name, or install what it needs
    """
    folder = folder or Path()
    if (folder / name).exists():
        return load_trained(folder / name)
    if is_reference(name):
        return _classifier(object_of(name, folder, WHAT, DatabaseError), name)
    installed = {entry.name: entry for entry in entry_points(group=GROUP)}
    if name in installed:
        return _classifier(loaded(installed[name], WHAT, DatabaseError), name)
    return load_trained(folder / name)


def is_reference(name: str) -> bool:
    """Whether a name is of the form `module:object`, rather than a file's or an entry point's.

    Examples
    --------
    >>> [is_reference(name) for name in ("nets.bulbs:CLASSIFIER", "bulbs.npz", "C:bulbs.npz", "acme")]
    [True, False, False, False]
    """
    return not name.endswith(DATABASE) and references.is_reference(name)


def _classifier(found: Any, name: str) -> Classifier:
    if callable(found) and (isinstance(found, type) or not _is_classifier(found)):
        try:
            found = found()
        except Exception as reason:  # whatever the function that loads a network raises
            raise DatabaseError(
                f"the classifier {name!r} cannot be loaded: {type(reason).__name__}: {reason}; expected a "
                "classifier, or an object that returns one when it is called without arguments: correct it"
            ) from reason
    return as_classifier(found, name)


def as_classifier(given: Classifier | ProbabilityClassifier, name: str | None = None) -> Classifier:
    """Return a classifier as it is, or one that returns probabilities as a `Classifier`.

    Parameters
    ----------
    given
        The classifier; one that has both methods stays as it is.
    name
        Its name in messages.

    Raises
    ------
    DatabaseError
        If it is no classifier, or its classes are not names, each once.
    """
    shown = f"the classifier {name!r}" if name else "the classifier"
    if not _is_classifier(given):
        raise DatabaseError(
            f"{shown} is {given!r}, expected an attribute `classes` and a method `classify` or "
            "`probabilities`: add them"
        )
    classes = given.classes
    named = not isinstance(classes, str) and all(isinstance(each, str) for each in classes)
    if not named or len(classes) == 0 or len(set(classes)) < len(classes):
        raise DatabaseError(
            f"{shown} has the classes {classes!r}, expected at least one name, none twice: correct `classes`"
        )
    if callable(getattr(given, "classify", None)):
        return cast(Classifier, given)
    return FromProbabilities(cast(ProbabilityClassifier, given))


def _is_classifier(given: object) -> bool:
    return hasattr(given, "classes") and any(
        callable(getattr(given, method, None)) for method in ("classify", "probabilities")
    )
