r"""Watch whether labels still follow the observation tables.

Before each look the model predicts its label: :math:`p(z) = \sum_c b(c) \, o(z \mid c)`, b being the belief
*before* the look, so the truth need not be known. If tables, arrival prior and beliefs are right, z is drawn
from p, whatever policy chose the look. For any alternative prediction q, the likelihood ratio
:math:`e = q(z) / p(z)` then has mean 1, so the product of the ratios of all looks is a martingale (a test
martingale; its value is the evidence, or a gambler's wealth), and by Ville's inequality the probability that
it ever reaches 1/alpha is at most alpha. Two alternatives are tested, with equal weights:

* noise: a share :math:`\lambda` of the labels is uniform, :math:`q(z) = (1 - \lambda) p(z) + \lambda / Z`;
* other frequencies: :math:`q(z) \propto p(z) \, r(z)`, where r is the recent frequency of z relative to the
  predicted one. It detects what noise does not: a classifier that is always wrong in the same way.

Since the time of the change is unknown, a part w(t) = 1/(t (t + 1)) of the initial value 1 enters at look t:

.. math:: M_t = (M_{t-1} + w(t)) \, e_t, \qquad \text{evidence}_t = M_t + \frac{1}{t + 1},

again a martingale. So the false-alarm probability holds for the whole life of a watch, not per look. The
price is that evidence has to grow as the square of the looks before the change: with the paper's tables,
looks from random viewpoints and a false-alarm probability of 0.01, it takes 190 scans (median of 40 runs) to
notice that 30 % of all labels have become noise if that happens after 200 scans, 380 if after 2000.

References
----------
J. Shin, A. Ramdas, A. Rinaldo, "E-detectors: a nonparametric framework for sequential change detection", New
England Journal of Statistics in Data Science 2 (2024). G. Shafer, V. Vovk, "Game-Theoretic Foundations for
Probability and Finance", Wiley 2019.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Self

import numpy as np

import beltsort
from beltsort.tables.counts import Array
from beltsort.util.defaults import FALSE_ALARM
from beltsort.util.text import counted, number_or_none

NOISE = 0.2  # lambda; from 0.1 to 0.5 the delays differ little
FORGETTING = 0.98  # factor by which earlier looks lose weight with each look
PRIOR_LOOKS = 5.0  # pseudo-looks whose labels were as predicted
LEARNT = ("seen", "expected", "excess", "variance", "looks")  # arrays of a watch, by position and viewpoint


def check_false_alarm(false_alarm: float) -> None:
    """Raise an `ArgumentError` unless `false_alarm` is between 0 and 1."""
    if not 0.0 < false_alarm < 1.0:
        raise beltsort.ArgumentError(
            f"false_alarm is {false_alarm}, expected a probability between 0 and 1, such as {FALSE_ALARM:g}"
        )


@dataclass(frozen=True)
class Alarm:
    """Labels no longer follow the tables.

    Attributes
    ----------
    position, viewpoint
        Indices; None for the test of all positions and viewpoints together.
    looks
        Looks there until the alarm.
    evidence
        Value of the test martingale, infinite after a label that the model holds impossible.
    """

    position: int | None
    viewpoint: int | None
    looks: int
    evidence: float

    def to_dict(self) -> dict[str, float | None]:
        """Return it as plain data, fit for JSON: infinite evidence is None."""
        return {**asdict(self), "evidence": number_or_none(self.evidence)}

    @classmethod
    def of_dict(cls, data: Mapping[str, Any]) -> Self:
        """Return the alarm from what `to_dict` returned."""
        return cls(**{**data, "evidence": np.inf if data["evidence"] is None else data["evidence"]})


class _TestMartingale:
    """The evidence at one position and viewpoint, or at all together: one martingale per alternative."""

    def __init__(self, looks: int = 0, at_stake: Sequence[float] = (0.0, 0.0)) -> None:
        self.looks, self.at_stake = looks, np.array(at_stake)  # M of each alternative

    def update(self, ratios: Array) -> float:
        """Multiply by the likelihood ratio q(z) / p(z) of each alternative; return the evidence."""
        self.looks += 1
        self.at_stake = (self.at_stake + 1.0 / (self.looks * (self.looks + 1))) * ratios
        return float(self.at_stake.mean()) + 1.0 / (self.looks + 1)


class DriftWatch:
    """Raises an alarm when labels come otherwise than the model predicts.

    There is a test for each position and viewpoint (a moved camera), and one for all together (a new batch of
    objects). Each raises one alarm: then look for the cause, estimate anew and begin a new watch.

    What it tests is the whole model: tables, arrival prior, and `repeat`. A class mix other than the arrival
    prior is drift, too. Labels that agree more often than predicted raise no alarm by themselves. An alarm
    names where labels were unlikely; a wrong table spoils the beliefs, so others may raise alarms as well.
    Tables estimated from few objects are wrong from the start and cause alarms: with a false-alarm
    probability of 0.05, 1500 scans raised an alarm in 5 of 60 runs with tables of 100 objects a row, in 47 of
    60 with tables of 20.

    Parameters
    ----------
    model
        Whose beliefs are watched.
    false_alarm
        Probability, at most, that a watch of whatever length ever raises an alarm while the model is right;
        between 0 and 1. Smaller delays true alarms (by a quarter from 0.05 to 0.01).

    Attributes
    ----------
    model, false_alarm
        As given.
    alarms
        All alarms so far.

    Raises
    ------
    ArgumentError
        If `false_alarm` is not between 0 and 1.

    Examples
    --------
    >>> import beltsort
    >>> table = [[[[0.8, 0.2], [0.2, 0.8]]]]
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["above"], table)
    >>> watch, sure = DriftWatch(model), beltsort.Belief(model, [[1.0, 0.0]])
    >>> while not watch.alarms:  # nuts that are always seen as bolts
    ...     _ = watch.observe(sure, 0, [1])
    >>> watch.alarms[0].looks
    11
    """

    def __init__(self, model: "beltsort.SortingModel", *, false_alarm: float = FALSE_ALARM) -> None:
        check_false_alarm(false_alarm)
        self.model, self.false_alarm = model, false_alarm
        self.alarms: list[Alarm] = []
        shape = (model.positions, len(model.viewpoints))
        self._tests: dict[tuple[int, int] | None, _TestMartingale] = {
            place: _TestMartingale() for place in [None, *np.ndindex(shape)]
        }
        self._threshold = len(self._tests) / false_alarm  # the tests share the probability (Bonferroni)
        self._seen, self._expected = np.full((2, *shape, len(model.labels)), PRIOR_LOOKS)
        self._excess, self._variance, self._looks = np.zeros((3, *shape))

    def __repr__(self) -> str:
        """Return the looks so far, and the alarms."""
        looks, alarms = counted(int(self._looks.sum()), "look"), counted(len(self.alarms), "alarm")
        return f"DriftWatch(false_alarm={self.false_alarm:g}, {looks}, {alarms})"

    def observe(
        self, belief_before: "beltsort.Belief", viewpoint: int, labels: Sequence[int | None]
    ) -> list[Alarm]:
        """Update with one scan; return the alarms that it raises.

        Parameters
        ----------
        belief_before
            The belief before the scan.
        viewpoint
            Where the camera stood.
        labels
            Label at each position, None where there is none; such positions are ignored.

        Raises
        ------
        ArgumentError
            If belief, viewpoint or labels do not fit the model.
        """
        if belief_before.model != self.model:
            raise beltsort.ArgumentError("the belief is of another model; expected the one that is watched")
        predicted = belief_before.label_probabilities(viewpoint)
        if len(labels) != len(predicted) or not set(labels) <= {None, *range(predicted.shape[1])}:
            raise beltsort.ArgumentError(
                f"labels are {list(labels)}, expected {len(predicted)} of them, each from 0 to "
                f"{predicted.shape[1] - 1} or None"
            )
        raised = [
            alarm
            for position, label in enumerate(labels)
            if label is not None
            for alarm in self._look(position, viewpoint, predicted[position], label)
        ]
        self.alarms += raised
        return raised

    def state(self) -> dict[str, Any]:
        """Return the state of the watch as plain data for JSON, without rounding."""
        return {
            "false_alarm": self.false_alarm,
            "gamblers": [
                [None if place is None else [*place], test.looks, test.at_stake.tolist()]
                for place, test in self._tests.items()
            ],
            "alarms": [alarm.to_dict() for alarm in self.alarms],
            **{name: _finite(getattr(self, f"_{name}").tolist()) for name in LEARNT},
        }

    @classmethod
    def of_state(cls, model: "beltsort.SortingModel", state: Mapping[str, Any]) -> Self:
        """Return a watch in a state that `state` returned."""
        watch = cls(model, false_alarm=state["false_alarm"])
        watch._tests = {
            None if place is None else (place[0], place[1]): _TestMartingale(looks, at_stake)
            for place, looks, at_stake in state["gamblers"]
        }
        watch.alarms = [Alarm.of_dict(alarm) for alarm in state["alarms"]]
        for name in LEARNT:
            learnt = np.array(state[name], dtype=np.float64)
            setattr(watch, f"_{name}", np.where(np.isnan(learnt), np.inf, learnt))
        return watch

    def surprise(self) -> tuple[Array, Array]:
        """Return by how much the labels' log-likelihood is below what the model predicts on average.

        Returns
        -------
        mean
            Nats per look, shape (H, K); expected 0 if the model is right; NaN where there was no look.
        standard_error
            Of `mean` if the model is right, shape (H, K).
        """
        with np.errstate(invalid="ignore", divide="ignore"):
            return self._excess / self._looks, np.sqrt(self._variance) / self._looks

    def _look(self, position: int, viewpoint: int, predicted: Array, label: int) -> list[Alarm]:
        place = (position, viewpoint)
        with np.errstate(divide="ignore"):
            information = -np.log(predicted)
        possible = predicted > 0.0
        entropy = float(predicted[possible] @ information[possible])
        self._looks[place] += 1
        self._excess[place] += information[label] - entropy
        self._variance[place] += predicted[possible] @ (information[possible] - entropy) ** 2
        ratios = self._ratios(place, predicted, label)
        alarms = []
        for where in (place, None):
            test = self._tests.get(where)
            if test is not None and (evidence := test.update(ratios)) >= self._threshold:
                del self._tests[where]
                j, k = where or (None, None)
                alarms.append(Alarm(j, k, test.looks, evidence))
        return alarms

    def _ratios(self, place: tuple[int, int], predicted: Array, label: int) -> Array:
        """Return q(z) / p(z) of both alternatives, then update the frequencies of labels."""
        if predicted[label] == 0.0:
            return np.full(2, np.inf)
        noise = 1.0 - NOISE + NOISE / (len(predicted) * predicted[label])
        ratio = self._seen[place] / self._expected[place]
        ratios = np.array([noise, ratio[label] / (predicted @ ratio)])
        came = np.eye(len(predicted))[label]
        for kept, new in ((self._seen, came), (self._expected, predicted)):
            kept[place] = PRIOR_LOOKS + FORGETTING * (kept[place] - PRIOR_LOOKS) + new
        return ratios


def _finite(numbers: Any) -> Any:
    """Return nested numbers with None for infinite ones."""
    return [*map(_finite, numbers)] if isinstance(numbers, list) else number_or_none(numbers)
