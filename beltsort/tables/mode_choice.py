"""Choose how many modes the classes have, by the log-loss of held-out objects."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np

from beltsort.tables.held_out import Candidate, Fitted, Prediction, cross_validated, stratified_folds
from beltsort.tables.independence import repetition_p_value
from beltsort.tables.modes import ModeSettings, ModeTables, fit_modes, one_mode_reasons
from beltsort.tables.repeated_looks import Array, RepeatedLooks
from beltsort.tables.sticky import fit_sticky_labels
from beltsort.util.extras import extra

with extra("perception"):
    from scipy.special import entr

MOST_MODES = 8
MOST_KINDS = 512
"""Kinds of sticky labels, in all classes, that planners still handle; there are Z^K for each class."""
FOLDS = 5
NEGLIGIBLE = 0.01  # share of the best log-loss
DEPENDENT = 0.01  # p-value below which looks at an object are known to repeat each other
ONE_MODE, STICKY, NAMED = "one mode", "sticky labels", "the named modes"


@dataclass(frozen=True)
class Score:
    """How well one candidate predicts held-out objects.

    Attributes
    ----------
    name
        Of the candidate.
    kinds
        Kinds in a belief, if fitted to all objects.
    log_loss, error
        Mean log-loss of the true class, nats, over objects and `STAGES`, and its standard error.
    calibration_error
        See `Prediction`.
    excess, excess_error
        Log-loss minus that of the best candidate, and the standard error of this difference between the same
        objects.
    """

    name: str
    kinds: int
    log_loss: float
    error: float
    calibration_error: float
    excess: float
    excess_error: float

    @property
    def is_as_good(self) -> bool:
        """Whether it is no worse than the best: within one standard error, or by a negligible difference.

        Two candidates that hardly differ have a difference of hardly any standard error.
        """
        return self.excess <= max(self.excess_error, NEGLIGIBLE * (self.log_loss - self.excess))


@dataclass(frozen=True)
class Gain:
    """By how much the chosen candidate's log-loss fell as its looks doubled.

    Attributes
    ----------
    doubled
        "objects" or "looks at each object".
    gain, error
        Log-loss when fitted to half of them minus that when fitted to all, and its standard error.
    """

    doubled: str
    gain: float
    error: float

    def __str__(self) -> str:
        """Return a sentence."""
        outlook = "more would help" if self.gain > 2.0 * self.error else "no clear gain"
        return (
            f"Doubling the {self.doubled} has lowered the log-loss by {self.gain:.3f} +- {self.error:.3f}: "
            f"{outlook}."
        )


@dataclass(frozen=True, eq=False)
class ModeChoice:
    """The chosen tables, and why.

    Attributes
    ----------
    name
        Of the chosen candidate.
    fitted
        The chosen tables, fitted to all objects.
    scores
        Of all candidates, fewest kinds first; empty if there was only one mode to choose.
    gains
        What more objects, and more looks at each, have brought; empty if there was nothing to choose.
    reasons
        For each class why it has one mode whatever the candidate, or None.
    repetition
        p-value of the looks at an object agreeing no more often than looks at others of its class
        (`beltsort.tables.independence.repetition_p_value`); None if there was nothing to choose.
    unseen
        Log-loss of the classes' shares among the objects, without a look.
    """

    name: str
    fitted: Fitted
    scores: tuple[Score, ...]
    gains: tuple[Gain, ...]
    reasons: tuple[str | None, ...]
    repetition: float | None = None
    unseen: float = np.inf

    @property
    def tables(self) -> ModeTables:
        """The chosen tables as tables of kinds."""
        return self.fitted.as_modes()

    def to_dict(self) -> dict[str, Any]:
        """Return what was chosen, the scores of all candidates and the gains as plain data for JSON."""
        return {
            "chosen": self.name,
            "weights": [list(each) for each in self.tables.weights],
            "scores": [asdict(score) for score in self.scores],
            "gains": [asdict(gain) for gain in self.gains],
            "reasons": list(self.reasons),
            "repetition": self.repetition,
        }

    def __str__(self) -> str:
        """Say in one sentence what was chosen and why."""
        if not self.scores and self.tables.kinds > len(self.reasons):
            return f"Tables of {self.name} per class, {self.tables.kinds} kinds, as given."
        if not self.scores:
            reason = next(iter(dict.fromkeys(filter(None, self.reasons))), "a single object")
            return f"One mode per class: {reason}."
        chosen = next(score for score in self.scores if score.name == self.name)
        best = min(self.scores, key=lambda score: score.log_loss)
        own = f"log-loss {chosen.log_loss:.3f} +- {chosen.error:.3f}"
        others = [score for score in self.scores if score.name == ONE_MODE and score is not chosen]
        than = "".join(f", {score.log_loss:.3f} with {ONE_MODE}" for score in others)
        why = "the lowest"
        if chosen is not best:
            within = "one standard error" if chosen.excess <= chosen.excess_error else f"{NEGLIGIBLE:.0%}"
            why = (
                f"the fewest kinds within {within} of the best, {best.name} ({best.log_loss:.3f}, "
                f"{chosen.excess:.3f} +- {chosen.excess_error:.3f} lower)"
            )
        text = f"Chosen on held-out objects: {self.name}, {chosen.kinds} kinds ({own}{than}), {why}."
        if chosen.log_loss + chosen.error > self.unseen:
            text += (
                f" Warning: without a look it is {self.unseen:.3f}, so these tables say little about objects "
                "that they were not fitted to."
            )
        return text


def fixed_modes(looks: RepeatedLooks, modes: int, settings: ModeSettings | None = None) -> ModeChoice:
    """Fit tables with a given number of modes; a class with too few objects or looks has one, and why."""
    fitted = fit_modes(looks.without_modes(), modes, settings or ModeSettings())
    return ModeChoice(f"{modes} modes", fitted, (), (), one_mode_reasons(looks))


def candidates(looks: RepeatedLooks, settings: ModeSettings, most: int = MOST_MODES) -> Iterator[Candidate]:
    """Yield what there is to choose from: one mode, sticky labels, 2 to `most` modes, the named modes.

    Sticky labels of more than `MOST_KINDS` kinds are left out.
    """
    yield Candidate(ONE_MODE, partial(fit_modes, modes=1, settings=settings))
    if all(reason is not None for reason in one_mode_reasons(looks)):
        return
    shape = looks.shape
    if shape.classes * shape.labels**shape.viewpoints <= MOST_KINDS:
        yield Candidate(STICKY, partial(fit_sticky_labels, smoothing=settings.smoothing))
    for modes in range(2, most + 1):
        yield Candidate(f"{modes} modes", partial(_latent, modes=modes, settings=settings))
    if looks.known:
        yield Candidate(NAMED, partial(fit_modes, modes=2, settings=settings))


def choose_modes(
    looks: RepeatedLooks,
    *,
    most: int = MOST_MODES,
    folds: int = FOLDS,
    settings: ModeSettings | None = None,
    seed: int = 0,
) -> ModeChoice:
    """Fit tables with as many modes as predict the class of held-out objects best.

    Each candidate is fitted to all folds but one and predicts the objects of that fold after a third, two
    thirds and all of their looks in random order (`STAGES`). Chosen is the one with the fewest kinds whose
    log-loss is within one standard error of the lowest: kinds are what a planner pays for. The standard error
    is that of the *difference* between the two on the same objects. The log-loss itself varies far more, from
    object to object, so by its standard error one mode would almost always do. A difference of 1 % is
    negligible, whatever its standard error.

    With few objects the difference has a large standard error, and one mode is as good as any. But
    independent looks are an assumption that can be tested (`repetition_p_value`), and where it fails, a
    belief grows certain of whatever the first labels were. So if it is rejected with p < 0.01, one mode is
    chosen only if its log-loss is the lowest.

    Parameters
    ----------
    looks
        At objects of known class, three or more looks at each.
    most
        Largest number of modes per class.
    folds
        Number of folds; objects of each class are dealt evenly.
    settings
        See `ModeSettings`.
    seed
        Of the folds and the order of looks.

    Raises
    ------
    ArgumentError
        If `folds` is below 2.
    """
    settings = settings or ModeSettings()
    choices = list(candidates(looks, settings, most))
    reasons = one_mode_reasons(looks)
    if len(choices) == 1:
        return ModeChoice(ONE_MODE, choices[0].fit(looks), (), (), reasons)
    shuffled = looks.shuffled(seed)
    dealt = stratified_folds(looks.true, folds, seed)
    predictions = [cross_validated(choice, shuffled, dealt) for choice in choices]
    fits = [choice.fit(looks) for choice in choices]
    scores = _scores(choices, fits, predictions)
    order = sorted(range(len(scores)), key=lambda i: scores[i].kinds)
    repetition = repetition_p_value(looks, seed)
    chosen = next(
        i
        for i in order
        if scores[i].is_as_good
        and (scores[i].name != ONE_MODE or repetition >= DEPENDENT or scores[i].excess == 0.0)
    )
    half_objects = cross_validated(choices[chosen], shuffled, dealt, partial(_half_of_objects, seed=seed))
    half_looks = cross_validated(choices[chosen], shuffled, dealt, partial(RepeatedLooks.first, share=0.5))
    gains = (
        _gain("objects", half_objects, predictions[chosen]),
        _gain("looks at each object", half_looks, predictions[chosen]),
    )
    shares = np.bincount(looks.true, minlength=looks.shape.classes) / len(looks)
    return ModeChoice(
        scores[chosen].name,
        fits[chosen],
        tuple(scores[i] for i in order),
        gains,
        reasons,
        repetition,
        float(entr(shares).sum()),
    )


def _latent(looks: RepeatedLooks, modes: int, settings: ModeSettings) -> ModeTables:
    """Fit modes as if none of them were known."""
    return fit_modes(looks.without_modes(), modes, settings)


def _half_of_objects(looks: RepeatedLooks, seed: int) -> RepeatedLooks:
    return looks.of_objects(np.flatnonzero(stratified_folds(looks.true, 2, seed) == 0))


def _scores(
    choices: Sequence[Candidate], fits: Sequence[Fitted], predictions: Sequence[Prediction]
) -> list[Score]:
    losses = [prediction.losses for prediction in predictions]
    best = min(losses, key=lambda each: float(each.mean()))
    return [
        Score(choice.name, fitted.kinds, *_mean(own), prediction.calibration_error, *_mean(own - best))
        for choice, fitted, prediction, own in zip(choices, fits, predictions, losses, strict=True)
    ]


def _gain(doubled: str, half: Prediction, whole: Prediction) -> Gain:
    return Gain(doubled, *_mean(half.losses - whole.losses))


def _mean(values: Array) -> tuple[float, float]:
    """Return the mean and its standard error."""
    return float(values.mean()), float(values.std(ddof=1) / np.sqrt(len(values)))
