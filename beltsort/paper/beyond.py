"""Experiments that the paper does not have, with labels drawn from tables."""

from beltsort.paper.design import Design
from beltsort.paper.instances import (
    FOUR,
    PAPER,
    TWO,
    sharpened,
    with_arrival,
    with_more_positions,
)
from beltsort.paper.labels import label_point
from beltsort.paper.outcomes import Point

BONUS, POSITIONS, SHARPNESS, ARRIVAL = "information bonus", "positions seen", "wrong table", "arrival prior"
STUDIES = {
    BONUS: "reward per nat of information",
    POSITIONS: "belt positions seen at once",
    SHARPNESS: "exponent of the believed tables (1: right)",
    ARRIVAL: "share of the prior on the two classes",
}
"""Names of the studies, and of what each varies."""


def beyond_points(design: Design, seed: int) -> list[Point]:
    """Return the points of all studies, at the paper's middle penalty."""
    return [
        *_bonuses(design, seed),
        *_positions(design, seed),
        *_wrong_tables(design, seed),
        *_arrivals(design, seed),
    ]


def _bonuses(design: Design, seed: int) -> list[Point]:
    return [
        label_point(
            design, seed, PAPER.model.replace(information_gain=bonus), FOUR, study=BONUS, setting=bonus
        )
        for bonus in design.bonuses
    ]


def _positions(design: Design, seed: int) -> list[Point]:
    return [
        label_point(
            design,
            seed,
            with_more_positions(PAPER.model, number),
            FOUR,
            study=POSITIONS,
            setting=float(number),
        )
        for number in design.positions
    ]


def _wrong_tables(design: Design, seed: int) -> list[Point]:
    return [
        label_point(
            design,
            seed,
            sharpened(truth, exponent),
            FOUR,
            study=SHARPNESS,
            setting=exponent,
            truth=truth.to_json(),
        )
        for truth in (PAPER.model.with_positions(1), PAPER.model)
        for exponent in design.sharpness
    ]


def _arrivals(design: Design, seed: int) -> list[Point]:
    return [
        label_point(design, seed, with_arrival(model, TWO, share), TWO, study=ARRIVAL, setting=share)
        for model in (PAPER.model.with_positions(1), PAPER.model)
        for share in design.arrivals
    ]
