"""What is shown of a run on a belt that never stops, and what must hold of it."""

import numpy as np

from beltsort.sorting.journal import Entry
from beltsort.sorting.moving.report import MovingReport
from beltsort.sorting.moving.state import MovingState
from beltsort.watch.moving import MovingHistory
from beltsort.watch.state import RunView


def history_of(run: list[Entry]) -> MovingHistory:
    history = MovingHistory(run[0])
    history.read(run)
    return history


def check_shown(shown: RunView, state: MovingState) -> None:
    """Check that what is shown is a state of the run."""
    moment, model = shown.moment, state.belt.model
    assert moment.viewpoint == state.viewpoint
    assert moment.object >= state.watched_exit
    assert len(moment.positions) == model.positions
    for place, position in enumerate(moment.positions):
        number = moment.object + place
        known = state.known(number)
        beyond = state.objects is not None and number >= state.objects
        assert position.object == (None if beyond else number)
        np.testing.assert_allclose(position.belief, known.kinds, atol=1e-4)
        assert position.looks == known.looks
        assert position.decided == ("" if known.bin is None else model.bins[known.bin])
    report = MovingReport.of(state)
    assert moment.tally.fates == {str(fate): n for fate, n in report.fates.items()}
    assert moment.left == report.objects
    assert [found.objects for found in moment.tally.bins] == list(report.bins)
