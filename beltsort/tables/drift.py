r"""Watch whether labels still come as the tables say.

Before each look the model predicts its label: :math:`p(z) = \sum_c b(c) \, o(z \mid c)`, b being the belief
*before* the look, so the truth need not be known. If tables, arrival prior and beliefs are right, z is drawn
from p, whatever policy chose the look. Whoever bets on another prediction q multiplies his wealth by
:math:`e = q(z) / p(z)`, whose mean under p is 1: his wealth is a martingale, and by Ville's inequality it
ever reaches 1/alpha with probability alpha at most. A gambler here has two bets, of equal stakes:

* noise: a share :math:`\lambda` of the labels is uniform, :math:`q(z) = (1 - \lambda) p(z) + \lambda / L`;
* other shares: :math:`q(z) \propto p(z) \, r(z)`, r being how much oftener than predicted z came of late. It
  finds what noise does not: a classifier that is wrong but sure, and so never contradicts itself.

Since nobody knows when the change comes, a part w(t) = 1/(t (t + 1)) of one unit starts to bet at look t:

.. math:: M_t = (M_{t-1} + w(t)) \, e_t, \qquad \text{wealth}_t = M_t + \frac{1}{t + 1},

again a martingale. So an alarm's false-alarm probability holds for the whole life of a watch, not per look.
The price is that evidence has to grow as the square of the looks before the change: with the paper's tables,
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
from beltsort.util.text import number_or_none

NOISE = 0.2  # lambda; from 0.1 to 0.5 the delays differ little
MEMORY = 0.98  # what shares of labels keep of their weight from look to look
CAUTION = 5.0  # looks that are taken to have come as predicted before the first
LEARNT = ("seen", "expected", "excess", "variance", "looks")  # arrays of a watch, by position and viewpoint


def check_false_alarm(false_alarm: float) -> None:
    """Refuse what is no probability of an alarm, with an `ArgumentError`."""
    if not 0.0 < false_alarm < 1.0:
        raise beltsort.ArgumentError(
            f"false_alarm is {false_alarm}, expected a probability between 0 and 1, such as 0.01"
        )


@dataclass(frozen=True)
class Alarm:
    """The tables no longer hold.

    Attributes
    ----------
    position, viewpoint
        Where; None for both: everywhere, taken together.
    looks
        Looks there until the alarm.
    evidence
        The gambler's wealth, infinite after a label that the model holds impossible.
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
        """Return the alarm that `to_dict` told of."""
        return cls(**{**data, "evidence": np.inf if data["evidence"] is None else data["evidence"]})


class _Gambler:
    """One wealth process: two bets."""

    def __init__(self, looks: int = 0, at_stake: Sequence[float] = (0.0, 0.0)) -> None:
        self.looks, self.at_stake = looks, np.array(at_stake)  # by bet

    def bet(self, factors: Array) -> float:
        """Take in one look, a factor for each bet; return the wealth."""
        self.looks += 1
        self.at_stake = (self.at_stake + 1.0 / (self.looks * (self.looks + 1))) * factors
        return float(self.at_stake.mean()) + 1.0 / (self.looks + 1)


class DriftWatch:
    """Raises an alarm when labels come otherwise than the model predicts.

    There is a gambler for each position and viewpoint (a moved camera), and one for all together (a new batch
    of objects). Each alarms once: after an alarm, look for the cause, estimate anew and begin a new watch.

    What it tests is the whole model: tables, arrival prior, and `repeat`. A class mix other than the arrival
    prior is drift, too. Labels that agree more often than predicted raise no alarm by themselves. An alarm
    tells where labels surprised; since one wrong table spoils the beliefs, others may come under suspicion.
    Tables estimated from few objects are wrong from the start, and said to be so: with a false-alarm
    probability of 0.05, 1500 scans raised an alarm in 5 of 60 runs with tables of 100 objects a row, in 47 of
    60 with tables of 20.

    Parameters
    ----------
    model
        Whose beliefs are watched.
    false_alarm
        Probability, at most, that a watch of whatever length ever raises an alarm while the model is right;
        between 0 and 1. Smaller delays true alarms (by a quarter from 0.05 to 0.01), larger cries wolf.

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

    def __init__(self, model: "beltsort.SortingModel", *, false_alarm: float = 0.01) -> None:
        check_false_alarm(false_alarm)
        self.model, self.false_alarm = model, false_alarm
        self.alarms: list[Alarm] = []
        shape = (model.positions, len(model.viewpoints))
        self._gamblers: dict[tuple[int, int] | None, _Gambler] = {
            place: _Gambler() for place in [None, *np.ndindex(shape)]
        }
        self._enough = len(self._gamblers) / false_alarm  # each has its share of the probability
        self._seen, self._expected = np.full((2, *shape, len(model.classes)), CAUTION)
        self._excess, self._variance, self._looks = np.zeros((3, *shape))

    def observe(
        self, belief_before: "beltsort.Belief", viewpoint: int, labels: Sequence[int | None]
    ) -> list[Alarm]:
        """Take in one scan; return the alarms that it raises.

        Parameters
        ----------
        belief_before
            The belief before the scan.
        viewpoint
            Where the camera stood.
        labels
            Label at each position, None where there is none: that tells nothing here.

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
        """Return all that the watch has learnt, as plain data, fit for JSON and exact."""
        return {
            "false_alarm": self.false_alarm,
            "gamblers": [
                [None if place is None else [*place], gambler.looks, gambler.at_stake.tolist()]
                for place, gambler in self._gamblers.items()
            ],
            "alarms": [alarm.to_dict() for alarm in self.alarms],
            **{name: _finite(getattr(self, f"_{name}").tolist()) for name in LEARNT},
        }

    @classmethod
    def of_state(cls, model: "beltsort.SortingModel", state: Mapping[str, Any]) -> Self:
        """Return the watch that `state` told of; it goes on as that one would."""
        watch = cls(model, false_alarm=state["false_alarm"])
        watch._gamblers = {
            None if place is None else (place[0], place[1]): _Gambler(looks, at_stake)
            for place, looks, at_stake in state["gamblers"]
        }
        watch.alarms = [Alarm.of_dict(alarm) for alarm in state["alarms"]]
        for name in LEARNT:
            learnt = np.array(state[name], dtype=np.float64)
            setattr(watch, f"_{name}", np.where(np.isnan(learnt), np.inf, learnt))
        return watch

    def surprise(self) -> tuple[Array, Array]:
        """Return by how much the log-likelihood of the labels fell short of what the model predicts.

        Returns
        -------
        mean
            Nats per look, shape (H, K); 0 in the mean if the model is right, NaN where nothing was seen.
        standard_error
            Of it, if the model is right.
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
        factors = self._factors(place, predicted, label)
        return [alarm for where in (place, None) if (alarm := self._bet(where, factors)) is not None]

    def _factors(self, place: tuple[int, int], predicted: Array, label: int) -> Array:
        """Return q(z) / p(z) of both bets, then learn from the label how often each comes."""
        if predicted[label] == 0.0:
            return np.full(2, np.inf)
        noise = 1.0 - NOISE + NOISE / (len(predicted) * predicted[label])
        ratio = self._seen[place] / self._expected[place]
        factors = np.array([noise, ratio[label] / (predicted @ ratio)])
        came = np.eye(len(predicted))[label]
        for kept, new in ((self._seen, came), (self._expected, predicted)):
            kept[place] = CAUTION + MEMORY * (kept[place] - CAUTION) + new
        return factors

    def _bet(self, place: tuple[int, int] | None, factors: Array) -> Alarm | None:
        gambler = self._gamblers.get(place)
        if gambler is None or (wealth := gambler.bet(factors)) < self._enough:
            return None
        del self._gamblers[place]
        position, viewpoint = place or (None, None)
        return Alarm(position, viewpoint, gambler.looks, wealth)


def _finite(numbers: Any) -> Any:
    """Return nested numbers with None for infinite ones."""
    return [*map(_finite, numbers)] if isinstance(numbers, list) else number_or_none(numbers)
