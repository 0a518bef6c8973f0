from collections.abc import Sequence
from typing import Any, final

from numpy.typing import ArrayLike

from beltsort._stubs.actions import DecideAt, Move, Wait
from beltsort._stubs.belief import Belief
from beltsort._stubs.model import SortingModel

@final
class MovingPlanner:
    def __new__(
        cls,
        model: SortingModel,
        *,
        ticks_per_place: int,
        reach: int = 1,
        move_ticks: ArrayLike | None = None,
        scan_ticks: int = 0,
        sort_ticks: int = 0,
        missed: Sequence[float] | None = None,
        seconds: float | None = None,
        trials: int | None = None,
        scenarios: int = ...,
        seed: int = 0,
        depth: int = ...,
        optimism: float = ...,
    ) -> MovingPlanner: ...
    def plan(
        self,
        belief: Belief,
        viewpoint: int | str = 0,
        *,
        decided: Sequence[int] = (),
        offset: int = 0,
        to_come: int | None = None,
        seconds: float | None = None,
        trials: int | None = None,
    ) -> MovingPlan: ...
    def thresholds(self, label: int, viewpoint: int | str = 0) -> list[float | None]: ...
    @property
    def shares(self) -> list[float]: ...
    @property
    def model(self) -> SortingModel: ...
    @property
    def settings(self) -> dict[str, Any]: ...
    def __getnewargs_ex__(self) -> tuple[tuple[SortingModel], dict[str, Any]]: ...

@final
class MovingPlan:
    @property
    def action(self) -> Move | Wait | DecideAt: ...
    @property
    def values(self) -> dict[Move | Wait | DecideAt, float]: ...
    @property
    def lower(self) -> float: ...
    @property
    def upper(self) -> float: ...
    @property
    def trials(self) -> int: ...
    @property
    def seconds(self) -> float: ...
    @property
    def expansions(self) -> int: ...
    @property
    def nodes(self) -> int: ...
