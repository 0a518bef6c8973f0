"""How many levels of confidence labels should have, judged by objects that the tables have not seen.

More levels say more of each look, but leave fewer looks for each entry of a table, and they exaggerate what
dependent looks agree on. Which wins depends on the number of objects, so it is measured: a belief is computed
for every object from tables of the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import beltsort
from beltsort.perception.classifier import Classifier
from beltsort.perception.kernel_ridge import KernelRidge
from beltsort.perception.label_edges import fit_label_rule
from beltsort.perception.label_rule import MOST_LEVELS, LabelRule, Score
from beltsort.perception.leave_one_out import leave_one_out
from beltsort.perception.nearest import NearestNeighbour
from beltsort.tables.counts import Look, count
from beltsort.tables.matches import MatchedScan
from beltsort.tables.pooling import pooled_prior
from beltsort.tables.scans import LabelledScan
from beltsort.util.extras import extra

with extra("perception"):
    from scipy.special import log_softmax

Array = NDArray[np.float64]

FOLDS = 5


@dataclass(frozen=True)
class RuleChoice:
    """A rule chosen among several.

    Attributes
    ----------
    rule
        The first one that is about as good as the best: their mean difference over the objects is at most its
        standard error.
    log_losses
        Mean negative logarithm of the belief in the true class, in the order of the rules, nats.
    """

    rule: LabelRule
    log_losses: tuple[float, ...]


def fit_levels(
    classifier: Classifier,
    scans: Sequence[MatchedScan],
    viewpoints: int,
    *,
    levels: int | None = None,
    smoothing: float | None = None,
) -> RuleChoice:
    """Fit a rule of labels with confidence: its edges, and the number of levels unless it is given.

    The score is the margin, or the probability of the best class from a `KernelRidge` or a classifier without
    distances. Its edges are quantiles: for a trained classifier, of its own entries' scores by leaving one
    out, otherwise of the scores in the scans.

    Parameters
    ----------
    classifier, scans, viewpoints, smoothing
        The classifier, and the rest as in `choose_rule`.
    levels
        Number of levels, from 1 to 4; None: chosen by `choose_rule`.

    Raises
    ------
    ArgumentError, DatabaseError
        As `fit_label_rule` and `choose_rule`.
    """
    if isinstance(classifier, NearestNeighbour | KernelRidge):
        matches, true = leave_one_out(classifier), classifier.labels.tolist()
    else:
        seen = [pair for scan in scans for pair in zip(scan.seen, scan.true, strict=True)]
        known = [(each.match, c) for each, c in seen if each.match is not None and c is not None]
        matches, true = [match for match, _ in known], [c for _, c in known]
    with_distances = all(match.distances is not None for match in matches)
    by_distance = with_distances and not isinstance(classifier, KernelRidge)
    score: Score = "margin" if by_distance else "probability"
    numbers = range(1, MOST_LEVELS + 1) if levels is None else [levels]
    rules = [fit_label_rule(classifier.classes, matches, true, n, score=score) for n in numbers]
    return choose_rule(rules, scans, viewpoints, smoothing=smoothing)


def choose_rule(
    rules: Sequence[LabelRule],
    scans: Sequence[MatchedScan],
    viewpoints: int,
    *,
    smoothing: float | None = None,
    seed: int = 0,
) -> RuleChoice:
    """Choose the rule whose labels predict the classes of new objects best.

    Objects are divided at random into five parts. Tables are estimated from four of them, and beliefs about
    the objects of the fifth from one look at each in every table row where it was seen, by Bayes' rule from
    equal beliefs in all classes. So scan objects as often as they will be seen: looks at one object depend on
    each other, and then fewer levels are best.

    Parameters
    ----------
    rules
        Candidates with the same classes, the simplest first: of 1, 2, 3 and 4 levels by `fit_label_rule`.
    scans
        With known classes; the classifier must not be trained on their objects. An object without a name is
        another one in every scan.
    viewpoints
        K.
    smoothing
        As in `Counts.probabilities`.
    seed
        Of the division.

    Raises
    ------
    ArgumentError
        If there is no rule, rules have different classes, or there are fewer than two objects.
    DatabaseError
        If a rule does not fit the classifier.

    References
    ----------
    L. Breiman, J. H. Friedman, R. A. Olshen, C. J. Stone, "Classification and Regression Trees", Wadsworth
    1984, section 3.4.3: the simplest within a standard error of the best.

    Examples
    --------
    >>> from beltsort.perception import Match
    >>> from beltsort.tables import Seen
    >>> rng = np.random.default_rng(0)
    >>> def match(true, sure):  # right if sure, else a guess
    ...     label = true if sure else int(rng.integers(2))
    ...     return Match(label, np.ones(2), np.array([0.25 if sure else 0.75, 1.0])[:: 1 - 2 * label])
    >>> scans = [
    ...     MatchedScan(0, (i % 2,), (f"object {i}",), (Seen(match(i % 2, i % 3 > 0)),))
    ...     for i in range(120)
    ... ]
    >>> rules = [LabelRule(("nut", "bolt"), edges) for edges in ((), (0.3,))]
    >>> choose_rule(rules, scans, viewpoints=1).rule.labels
    ('nut, unsure', 'nut, sure', 'bolt, unsure', 'bolt, sure')
    """
    if not rules or any(rule.classes != rules[0].classes for rule in rules):
        raise beltsort.ArgumentError(
            f"the rules have the classes {sorted({rule.classes for rule in rules})}, expected at least one "
            "rule, and the same classes in all: fit them with one classifier"
        )
    losses = np.array([_held_out_losses(rule, scans, viewpoints, smoothing, seed) for rule in rules])
    excess = losses - losses[losses.mean(axis=1).argmin()]  # (rules, objects)
    as_good = excess.mean(axis=1) <= excess.std(axis=1, ddof=1) / np.sqrt(excess.shape[1])
    return RuleChoice(rules[int(as_good.argmax())], tuple(losses.mean(axis=1).tolist()))


def _held_out_losses(
    rule: LabelRule, scans: Sequence[MatchedScan], viewpoints: int, smoothing: float | None, seed: int
) -> Array:
    """Return the loss of each object with tables of the other parts, shape (objects,)."""
    objects = _looks_by_object([scan.labelled(rule) for scan in scans])
    if len(objects) < 2:
        raise beltsort.ArgumentError(
            f"there are {len(objects)} objects of known class, expected at least 2, better hundreds: scan "
            "more"
        )
    positions = len(scans[0].true)
    part = np.random.default_rng(seed).permutation(len(objects)) % FOLDS
    losses = np.zeros(len(objects))
    for fold in range(min(FOLDS, len(objects))):
        fitted = [look for n, looks in enumerate(objects) if part[n] != fold for look in looks]
        counts = count(fitted, positions, viewpoints, len(rule.classes), rule.label_classes)
        prior = pooled_prior(counts) if smoothing is None else smoothing
        log_p = np.log(counts.probabilities(prior))
        for n in np.flatnonzero(part == fold):
            losses[n] = _loss(log_p, objects[n])
    return losses


def _looks_by_object(scans: Sequence[LabelledScan]) -> list[list[Look]]:
    """Return the first look at each object in every table row, by object."""
    rows: dict[tuple[int, str | int], dict[tuple[int, int], Look]] = {}
    for number, scan in enumerate(scans):
        seen = zip(scan.true, scan.objects, scan.observed, strict=True)
        for position, (true, name, label) in enumerate(seen):
            if true is not None:
                key = number * len(scan.true) + position if name is None else name
                look = Look(position, scan.viewpoint, true, label)
                rows.setdefault((true, key), {}).setdefault((position, scan.viewpoint), look)
    return [list(looks.values()) for looks in rows.values()]


def _loss(log_p: Array, looks: Sequence[Look]) -> float:
    """Return the loss of an object after all of its looks, with logarithms of the tables, (H, K, L, Z)."""
    seen = [
        log_p[look.position, look.viewpoint, :, look.observed] for look in looks if look.observed is not None
    ]
    belief: Array = log_softmax(np.sum(seen, axis=0) if seen else np.zeros(log_p.shape[2]))
    return -float(belief[looks[0].true])
