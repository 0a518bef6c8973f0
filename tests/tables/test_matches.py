"""What the classifier returned, on the disk."""

from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from beltsort.perception import Finding, Match
from beltsort.tables import MatchLog, Seen

FINITE = st.floats(-1e300, 1e300)


@st.composite
def seen(draw: st.DrawFn) -> Seen:
    finding = draw(st.sampled_from(list(Finding)))
    if draw(st.booleans()):
        return Seen(None, finding)
    classes = draw(st.integers(1, 4))
    scores = np.array(draw(st.lists(FINITE, min_size=classes, max_size=classes)))
    far = st.floats(0.0, 1e300) | st.just(np.inf)
    distances = draw(st.none() | st.lists(far, min_size=classes, max_size=classes).map(np.array))
    probabilities = draw(st.none() | st.just(np.full(classes, 1.0 / classes)))
    label = draw(st.none() | st.integers(0, classes - 1))
    return Seen(Match(label, scores, distances, probabilities), finding)


def plain(given: Seen) -> tuple[object, ...]:
    match = given.match
    if match is None:
        return (given.finding,)
    arrays = (match.scores, match.distances, match.probabilities)
    return (given.finding, match.label, *(None if a is None else a.tolist() for a in arrays))


@given(st.lists(seen(), max_size=3))
def test_what_is_written_is_read_to_the_bit(positions: list[Seen]) -> None:
    log = MatchLog()
    log.append({"scan": positions})
    assert [plain(each) for each in log.matches()["scan"]] == [plain(each) for each in positions]


def test_the_first_match_of_a_scan_is_kept(tmp_path: Path) -> None:
    MatchLog(tmp_path / "matches").append({"a": [Seen(None, Finding.EMPTY)]})  # never closed
    with MatchLog(tmp_path / "matches") as log:
        log.append({"a": [Seen(None, Finding.CUT)], "b": []})
        assert log.matches() == {"a": (Seen(None, Finding.EMPTY),), "b": ()}
