"""Whether an output that a page shows is what was printed."""

import re

NUMBER = re.compile(r"\d+(?:\.\d+)?")


def alike(shown: str, printed: str) -> bool:
    """Whether two lines agree, but for what another processor's rounding may change."""

    def form(line: str) -> str:
        return NUMBER.sub("N", line.replace("from the cache", "estimated now"))

    def near(a: str, b: str) -> bool:
        return abs(float(a) - float(b)) <= (0.1 if "." in a else 0.3 * float(a))

    numbers = zip(NUMBER.findall(shown), NUMBER.findall(printed), strict=False)
    return form(shown) == form(printed) and all(near(a, b) for a, b in numbers)


def shows(shown: list[str], printed: list[str]) -> bool:
    """Whether the shown lines are the printed ones, in order, with `...` for one or more left out."""
    if not shown:
        return not printed
    first, *rest = shown
    if first == "...":
        return any(shows(rest, printed[left_out:]) for left_out in range(1, len(printed) + 1))
    return bool(printed) and alike(first, printed[0]) and shows(rest, printed[1:])
