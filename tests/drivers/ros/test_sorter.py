"""A sorter on ROS: its keys, and what its record tells."""

from collections.abc import Iterator

import pytest

from beltsort.cell import CommandError, EmergencyStopError, Outcome
from beltsort.drivers.ros.sorter import RosSorter
from tests.drivers.ros.fixtures import an_id
from tests.drivers.ros.rig import PeerRig, await_ready

pytestmark = pytest.mark.process


@pytest.fixture(scope="module")
def shared_sorter(shared: PeerRig) -> Iterator[RosSorter]:
    with shared.sorter() as sorter:
        yield sorter


@pytest.fixture
def sorter(rig: PeerRig, shared_sorter: RosSorter) -> RosSorter:
    await_ready(shared_sorter)
    return shared_sorter


def test_a_refused_sort_is_sent_again_as_the_next_attempt(rig: PeerRig, sorter: RosSorter) -> None:
    bins, one = rig.tell(full=True)["bins"], an_id()
    for attempt in (1, 2):
        with pytest.raises(CommandError, match=f"'{one}/{attempt}'.*the bin is full") as error:
            sorter.sort(2, one)
        assert error.value.outcome is sorter.outcome_of(one) is Outcome.NOT_DONE
    rig.mend()
    sorter.sort(2, one)
    assert rig.tell()["bins"] == [*bins[:2], bins[2] + 1, *bins[3:]]


def test_another_program_learns_what_became_of_a_sort(rig: PeerRig, sorter: RosSorter) -> None:
    one, two = an_id(), an_id()
    sorter.sort(1, one)
    with rig.sorter() as restarted:
        await_ready(restarted)
        assert restarted.outcome_of(one) is Outcome.DONE
        assert restarted.outcome_of(two) is Outcome.UNKNOWN
        bins = rig.tell()["bins"]
        restarted.sort(1, one)
        assert rig.tell()["bins"] == bins


def test_a_sort_that_was_stopped_on_the_way_is_broken_off(rig: PeerRig, sorter: RosSorter) -> None:
    rig.tell(sort=60.0)
    one = an_id()
    stopping = rig.when_busy("sorter", sorter.stop)
    with pytest.raises(CommandError, match=rf"'{one}/1'.*stopped on the way") as error:
        sorter.sort(1, one, timeout=10.0)
    stopping.join()
    assert error.value.outcome is sorter.outcome_of(one) is Outcome.BROKEN_OFF


def test_the_emergency_stop(rig: PeerRig, sorter: RosSorter) -> None:
    rig.tell(sort=60.0)
    pressing = rig.when_busy("sorter", lambda: rig.tell(emergency=True))
    one = an_id()
    with pytest.raises(EmergencyStopError) as error:
        sorter.sort(1, one, timeout=10.0)
    pressing.join()
    assert error.value.outcome is Outcome.UNKNOWN
    with pytest.raises(EmergencyStopError) as error:
        sorter.sort(1, one)
    assert error.value.outcome is Outcome.UNKNOWN, "the first attempt may have acted"
    with pytest.raises(EmergencyStopError) as error:
        sorter.sort(1, an_id())
    assert error.value.outcome is Outcome.NOT_DONE
