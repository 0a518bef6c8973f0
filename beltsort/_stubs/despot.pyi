from typing import Any, Literal, final

from beltsort._stubs.actions import Decide, Move
from beltsort._stubs.belief import Belief
from beltsort._stubs.model import SortingModel
from beltsort._stubs.plan import Plan
from beltsort._stubs.solution import Solution

@final
class Despot:
    """Plan online by an anytime search in a tree of beliefs, determinised by sampled scenarios.

    A scenario fixes the classes of the objects and a stream of observation randoms. There are two variants:

    * "beliefs", the recommended one: the belief at each node is exact, and scenarios only choose which label
      vectors get a branch. A branch weighs its exact probability; the labels that no scenario gives follow
      the default policy, the best conditional plan for one object after the other. Solving for those plans is
      what makes the constructor take a moment.
    * "scenarios": DESPOT as published, to compare with. The search knows nothing but its scenarios: rewards
      and probabilities are averages over those that come to a node.

    A trial expands one leaf of the tree, or as many as the published algorithm says. With a budget of trials
    a plan is a pure function of model, belief, viewpoint, seed and settings, bit by bit the same for any
    number of `threads`; with a budget of time it depends on the machine too.

    Repeated labels and scans after decisions are planned for where the model has them; so is a bonus for
    information, by the variant "beliefs".

    Parameters
    ----------
    model : SortingModel
        The problem. A scan has L^H outcomes: each further position multiplies the tree by up to L.
    scenarios : int, default 500
        Number of scenarios. Too few leave likely labels without a branch, or, of the variant "scenarios", are
        overfitted; too many leave the tree shallow under a budget of time.
    seed : int
        Seed of the scenarios.
    threads : int, optional
        Threads that share the work of a plan of the variant "scenarios"; all cores if missing. Plans of less
        than 2 ms, or of at most 256 trials, are made on the calling thread, as are all of the variant
        "beliefs".
    seconds : float, optional
        Wall-clock budget of a plan in seconds, 0.01 if neither budget is given.
    trials : int, optional
        Budget of a plan in trials, in place of `seconds`. Memory grows with it.
    regularization : float, optional
        `lambda` of the DESPOT paper: cost of a policy node, in the unit of `r_max`; 0 if missing. Only the
        variant "scenarios" has one: too small, and it overfits its scenarios; too large, and nothing but the
        default policy is worth its nodes.
    depth : int, optional
        Planner steps to look ahead; if missing, as many as the discount leaves 1 % of a reward after.
    solution : Solution, optional
        A solution of the model, for the variant "beliefs": the planner is ready at once and gives the same
        plans, with a `certified_upper` as tight as the solution's own.
    variant : {"beliefs", "scenarios"}
        Which planner.

    Raises
    ------
    ArgumentError
        For a count or budget of 0 or below, both budgets, a negative regularisation, an unknown variant, an
        argument that the variant does not take, the solution of another model, or, of the variant
        "scenarios", an L^H above 2^64.
    ModelError
        For a model with `information_gain` and the variant "scenarios".

    References
    ----------
    Ye, Somani, Hsu & Lee, "DESPOT: Online POMDP planning with regularization", JAIR 58, 2017.

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> planner = beltsort.Despot(model, trials=100)
    >>> planner.plan(beltsort.Belief(model)).action
    Move(viewpoint=0)
    >>> planner.plan(beltsort.Belief(model, [[0.01, 0.99]])).action
    Decide(label=1)
    """

    def __new__(
        cls,
        model: SortingModel,
        *,
        scenarios: int = ...,
        seed: int = 0,
        threads: int | None = None,
        seconds: float | None = None,
        trials: int | None = None,
        regularization: float | None = None,
        depth: int | None = None,
        solution: Solution | None = None,
        variant: Literal["beliefs", "scenarios"] = "beliefs",
    ) -> Despot: ...
    @property
    def model(self) -> SortingModel:
        """The model planned for."""
    @property
    def settings(self) -> dict[str, Any]:
        """What plans depend on, as keywords of the constructor.

        They are scenarios, seed, seconds, trials, regularization, depth, variant.
        """
    def plan(
        self,
        belief: Belief,
        viewpoint: int | str = 0,
        *,
        seconds: float | None = None,
        trials: int | None = None,
    ) -> Plan:
        """Plan the next action.

        Parameters
        ----------
        belief : Belief
            What is known of the objects; made for the planner's model, or an equal one.
        viewpoint : int or str
            Where the camera stands: index or name.
        seconds, trials : optional
            In place of the planner's own budget; at most one of them.

        Returns
        -------
        Plan
            The action, the value of every legal one, and bounds.

        Raises
        ------
        ArgumentError
            For a belief of another model, an unknown viewpoint, both budgets, or one of 0 or below.
        """
    def act(self, belief: Belief, viewpoint: int | str) -> Move | Decide:
        """Return the action of a plan with the planner's own budget: a planner is a policy.

        Parameters
        ----------
        belief : Belief
            What is known of the objects.
        viewpoint : int or str
            Where the camera stands: index or name.

        Returns
        -------
        Move or Decide
            `plan(belief, viewpoint).action`.

        Raises
        ------
        ArgumentError
            For a belief of another model or an unknown viewpoint.
        """
    def _repr_html_(self) -> str:
        """Return HTML for notebooks."""
    def __copy__(self) -> Despot: ...
    def __deepcopy__(self, _memo: object) -> Despot: ...
    def __getnewargs_ex__(self) -> tuple[tuple[SortingModel], dict[str, Any]]: ...
