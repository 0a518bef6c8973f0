"""Changes of a model that may make a belt sortable."""

from collections.abc import Iterator, Sequence
from itertools import count

import numpy as np
from numpy.typing import NDArray

from beltsort._core import SortingModel
from beltsort.planning.separation import Separation, cheapest_look

MANUAL = 0.5
"""Loss in the bin of the proposed manual bin, as a share of the cost of the cheapest look.

Below 1, looking for ever is never optimal: it costs more than to send every object there unseen.
"""

MOST_KINDS = 64  # of a model with a further viewpoint, whose modes are pairs of modes


def changed_models(model: SortingModel, worst: Separation | None) -> Iterator[tuple[str, SortingModel]]:
    """Yield what may help, in words, and the changed models."""
    if worst is not None:
        if (more := with_viewpoint_like(model, worst.viewpoint)) is not None:
            yield f"another viewpoint as good as {worst.viewpoint}", more
        if (merged := with_common_bin(model, worst.classes)) is not None:
            yield f"one bin for {' and '.join(worst.classes)}", merged
    if model.reward.min(axis=1).max() < -cheapest_look(model):
        loss = MANUAL * cheapest_look(model)
        yield f"a manual bin that costs {loss:g} per object", with_manual_bin(model, loss)


def with_manual_bin(model: SortingModel, loss: float) -> SortingModel:
    """Return the model with one more bin, which costs `loss` for every class."""
    row = np.full((1, len(model.classes)), -loss)
    return _with_bins(model, [*model.bins, _unused("manual", model.bins)], [*model.reward, *row])


def with_common_bin(model: SortingModel, classes: tuple[str, str]) -> SortingModel | None:
    """Return the model with one bin in place of the best bins of two classes.

    It is worth what the better of the two is for these classes, and what the worse is for others. None if
    they have one bin already, or no other bin is worth anything.
    """
    pair = [model.classes.index(name) for name in classes]
    bins = model.reward[:, pair].argmax(axis=0).tolist()
    rest = [i for i in range(len(model.bins)) if i not in bins]
    if bins[0] == bins[1] or not (model.reward[rest] > 0.0).any():
        return None
    both = model.reward[bins]
    common = both.min(axis=0)
    common[pair] = both[:, pair].max(axis=0)
    names = [model.bins[i] for i in rest]
    name = _unused(" or ".join(model.bins[i] for i in bins), names)
    return _with_bins(model, [*names, name], [*model.reward[rest], common])


def with_viewpoint_like(model: SortingModel, name: str) -> SortingModel | None:
    """Return the model with one more viewpoint, equal to another but independent of all given the class.

    Its mode is drawn apart from that of the others, so the modes of a class become pairs. None if these are
    more than `MOST_KINDS`.
    """
    k, modes = model.viewpoints.index(name), [np.asarray(own) for own in model.modes]
    if sum(len(own) ** 2 for own in modes) > MOST_KINDS:
        return None
    starts = np.cumsum([0, *(len(own) for own in modes)]).tolist()
    kinds = [np.arange(start, start + len(own)) for start, own in zip(starts, modes, strict=False)]
    of_others = np.concatenate([np.repeat(own, len(own)) for own in kinds])
    of_new = np.concatenate([np.tile(own, len(own)) for own in kinds])
    tables = [model.p_obs[:, :, of_others], model.p_obs[:, k : k + 1, of_new]]
    viewpoints = [*range(len(model.viewpoints)), k]  # what each of the viewpoints is like
    new = len(model.viewpoints)
    travel = [[*ends, new] if k in ends else ends for ends in (model.travel[v] for v in viewpoints)]
    return model.replace(
        viewpoints=[*model.viewpoints, _unused(f"another {name}", model.viewpoints)],
        p_obs=np.concatenate(tables, axis=1),
        modes=[np.outer(own, own).ravel().tolist() for own in modes],
        motion_cost=model.motion_cost[np.ix_(viewpoints, viewpoints)],
        travel=travel,
        repeat=model.repeat[:, viewpoints],
    )


def _with_bins(model: SortingModel, bins: list[str], reward: list[NDArray[np.float64]]) -> SortingModel:
    return model.replace(bins=bins, reward=np.stack(reward), r_max=None, r_min=None)


def _unused(name: str, names: Sequence[str]) -> str:
    """Return the name, with a number if it is taken."""
    numbered = (f"{name} {number}" for number in count(2))
    return name if name not in names else next(each for each in numbered if each not in names)
