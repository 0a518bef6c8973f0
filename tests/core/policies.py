"""Policies to test with."""

from beltsort import Belief, Decide, Move, Policy


class LookThenDecide:
    """Looks from one viewpoint, a fixed number of times at each object, and notes its decisions."""

    def __init__(self, viewpoint: int = 0, looks: int = 1) -> None:
        self.viewpoint, self.looks = viewpoint, looks
        self.seen = 0
        self.decided: list[int] = []

    def act(self, belief: Belief, viewpoint: int) -> Move | Decide:
        if self.seen < self.looks:
            self.seen += 1
            return Move(self.viewpoint)
        self.seen = 0
        self.decided.append(belief.most_likely(0)[0])
        return Decide(self.decided[-1])


class Always:
    def __init__(self, action: Move | Decide) -> None:
        self.action = action

    def act(self, belief: Belief, viewpoint: int) -> Move | Decide:
        return self.action


class Recorded:
    """Does what another policy does, and notes what it was asked and what it said."""

    def __init__(self, policy: Policy) -> None:
        self.policy = policy
        self.asked: list[tuple[Belief, int]] = []
        self.answered: list[Move | Decide] = []

    def act(self, belief: Belief, viewpoint: int) -> Move | Decide:
        self.asked.append((belief.copy(), viewpoint))
        self.answered.append(self.policy.act(belief, viewpoint))
        return self.answered[-1]
