"""Reproduce one point of the paper's Fig. 6 with the functions of `beltsort.paper`."""

from beltsort import paper


def main() -> None:
    """Sort with one and two positions at r_min = 50; labels are drawn from the paper's tables."""
    points = [
        paper.label_point(paper.QUICK, 0, paper.PAPER.model.with_positions(n), paper.FOUR, batches=50)
        for n in (1, 2)
    ]
    one, two = (point | paper.simulate_labels(point) for point in points)
    for row in paper.plain_table([one, two]):
        print(f"{row['positions']} position(s): {row['steps']:.1f} ± {row['steps_standard_error']:.1f} steps")
    saved = paper.saving(two["steps"], one["steps"])
    lower, upper = saved.interval
    print(f"saved: {100 * saved.value:.1f} % ({100 * lower:.1f} to {100 * upper:.1f} %)")


if __name__ == "__main__":
    main()
