"""Write a policy of your own: any object with a method `act` can be simulated and compared."""

import beltsort
from beltsort.models import paper


class Rounds:
    """Look from each viewpoint in turn until one class is likely enough."""

    def __init__(self, model: beltsort.SortingModel, threshold: float) -> None:
        self.viewpoints, self.threshold = len(model.viewpoints), threshold

    def act(self, belief: beltsort.Belief, viewpoint: int) -> beltsort.Move | beltsort.Decide:
        """Return the next action."""
        label, probability = belief.most_likely(0)
        if probability >= self.threshold:
            return beltsort.Decide(label)
        return beltsort.Move((viewpoint + 1) % self.viewpoints)


def main() -> None:
    """Simulate it on the paper's instance."""
    model = paper()
    summary = beltsort.evaluate(model, Rounds(model, 0.94), batches=50).summary()
    for name in ("steps", "correct"):
        print(f"{name}: {summary[name]['mean']:.2f} ± {summary[name]['standard_error']:.2f}")


if __name__ == "__main__":
    main()
