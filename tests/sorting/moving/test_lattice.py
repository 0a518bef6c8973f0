import math

from hypothesis import given
from hypothesis import strategies as st

from beltsort.sorting.moving.lattice import Lattice

LATTICES = st.builds(
    Lattice, spacing=st.floats(0.05, 0.5), origin=st.floats(-1.0, 1.0), first=st.integers(0, 10_000)
)


@given(LATTICES, st.integers(0, 1000), st.floats(-0.49, 0.49))
def test_an_object_near_its_place_has_the_number_of_that_place(
    lattice: Lattice, further: int, off: float
) -> None:
    number = lattice.first + further
    assert lattice.number(lattice.coordinate(number) + off * lattice.spacing) == number


@given(LATTICES, st.floats(-1.0, 200.0), st.integers(1, 20))
def test_the_object_at_the_exit_and_the_offset_follow_from_the_travel(
    lattice: Lattice, travel: float, ticks: int
) -> None:
    number, offset = lattice.at_exit(travel), lattice.offset(travel, ticks)
    x = lattice.coordinate(number) - travel
    assert -lattice.spacing / 2.0 - 1e-9 < x <= lattice.spacing / 2.0 + 1e-9
    assert 0 <= offset < ticks
    left = x + lattice.spacing / 2.0  # metres until the object has passed the exit
    assert math.isclose((ticks - offset) * lattice.spacing / ticks, left, abs_tol=lattice.spacing / ticks)


@given(
    st.floats(0.0, 50.0),
    st.floats(0.05, 0.5),
    st.lists(st.integers(-3, 3), min_size=1, max_size=6, unique=True),
    st.floats(-0.1, 0.1),
)
def test_the_lattice_through_cups_has_all_of_them(
    travel: float, spacing: float, steps: list[int], off: float
) -> None:
    cups = [travel + spacing * (step + off) for step in steps]
    lattice = Lattice.through(cups, travel, spacing, 7)
    assert lattice.at_exit(travel) == 7
    for cup, step in zip(cups, steps, strict=True):
        assert math.isclose(lattice.coordinate(lattice.number(cup)), cup, abs_tol=1e-6)
        assert lattice.number(cup) == 7 + step


@given(st.floats(0.0, 1.0), st.floats(-0.02, 0.02), st.integers(1, 50))
def test_no_two_objects_have_the_same_number_for_the_controller(
    origin: float, error: float, later: int
) -> None:
    one = Lattice(spacing=0.18, origin=origin, first=0)
    other = Lattice(spacing=0.18, origin=origin + later * 0.18 + error, first=0)
    marks = [one.mark(number) for number in range(later)] + [other.mark(number) for number in range(50)]
    assert len(set(marks)) == len(marks)
