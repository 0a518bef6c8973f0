"""Compare planners on the same objects: paired differences need few batches."""

import beltsort
from beltsort.models import paper


def main() -> None:
    """Compare DESPOT and a threshold policy with the offline solution."""
    model = paper()
    solution = beltsort.solve(model, seconds=2.0)
    policies: dict[str, beltsort.Policy] = {
        "solution": solution,
        "DESPOT": beltsort.Despot(model, trials=50),
        "threshold 0.9": beltsort.Threshold(model, 0.9),
    }
    metrics = ["steps", "correct", "discounted_regrets"]
    print(beltsort.compare(model, policies, batches=100, seed=1, reference=solution, metrics=metrics))
    print(f"the best possible value is between {solution.lower:.2f} and {solution.upper:.2f}")


if __name__ == "__main__":
    main()
