"""Belt and sorter by services on ROS 2, whose calls carry no keys: what is lost, repeated and looked up."""

import dataclasses
from collections.abc import Iterator
from typing import Any

import pytest

from beltsort.cell import CommandError, EmergencyStopError, Outcome
from beltsort.cellfile.backends import ROS2_BELT, ROS2_SORTER
from beltsort.drivers.ros.device import Received
from beltsort.drivers.ros2 import Ros2Belt, Ros2ServiceBelt, Ros2ServiceSorter, Ros2Sorter
from beltsort.drivers.ros2.service_sorter import Call, outcome_of_call
from beltsort.drivers.ros2.services import request_topic
from beltsort.drivers.ros2.trigger import Answer, Trigger
from beltsort.errors import CellError
from tests.drivers.ros.fixtures import an_id
from tests.drivers.ros.rig import await_ready
from tests.drivers.ros2 import scene
from tests.drivers.ros2.rig import Rig, set_going
from tests.waiting import wait_until

pytestmark = pytest.mark.process


@pytest.fixture(scope="module")
def shared_stepper(shared: Rig) -> Iterator[Ros2ServiceBelt]:
    with Ros2ServiceBelt(scene.belt_by_service(shared.domain)) as belt:
        yield belt


@pytest.fixture
def stepper(rig: Rig, belt: Ros2Belt, shared_stepper: Ros2ServiceBelt) -> Ros2ServiceBelt:
    set_going(rig, belt)
    await_ready(shared_stepper)
    return shared_stepper


@pytest.fixture(params=["counts", "says nothing"])
def sorter(rig: Rig, request: pytest.FixtureRequest) -> Iterator[Ros2ServiceSorter]:
    with Ros2ServiceSorter(scene.sorter_by_service(rig.domain, counts=request.param == "counts")) as sorter:
        await_ready(sorter)
        yield sorter


def test_a_belt_goes_several_objects_by_single_steps(rig: Rig, stepper: Ros2ServiceBelt) -> None:
    at, one = rig.tell()["object"], an_id()
    stepper.advance_to(at + 3, one, timeout=60.0)
    assert rig.tell()["object"] == stepper.position() == at + 3
    stepper.advance_to(at + 3, one)
    stepper.advance_to(at + 3, an_id())
    assert rig.tell()["object"] == at + 3
    with pytest.raises(CommandError, match=r"\bforward only\b") as error:
        stepper.advance_to(at + 2, an_id())
    assert error.value.outcome is Outcome.NOT_DONE


@pytest.mark.parametrize("remedy", ["a late answer", "a restart"])
def test_a_belt_is_not_told_again_while_it_may_still_act(
    rig: Rig, stepper: Ros2ServiceBelt, remedy: str
) -> None:
    at, one = rig.tell()["object"], an_id()
    rig.tell(stuck=True, unanswered=True)
    with pytest.raises(CommandError, match=rf"\bobject {at}\b.*\breported {at} last") as error:
        stepper.advance_to(at + 1, one, timeout=5.0)
    assert error.value.outcome is stepper.outcome_of(one) is Outcome.UNKNOWN
    rig.tell(stuck=False)
    health = stepper.health()
    assert not health.ready
    assert "may still do it" in health.fault
    for again in (one, an_id()):
        with pytest.raises(
            CommandError, match=r"\bmay still do it\b.*\bstart the node of /belt/advance"
        ) as error:
            stepper.advance_to(at + 1, again, timeout=5.0)
        assert error.value.outcome is Outcome.UNKNOWN
    assert rig.tell()["object"] == at, "it was not called again"
    if remedy == "a restart":
        rig.kill(rig.peer)
        rig.start_peer()
    rig.mend()
    await_ready(stepper)
    at = rig.tell()["object"]
    stepper.advance_to(at + 1, an_id(), timeout=60.0)
    assert rig.tell()["object"] == at + 1


def test_a_belt_that_refuses_has_not_moved(rig: Rig, stepper: Ros2ServiceBelt) -> None:
    at, one = rig.tell(verdict=5)["object"], an_id()
    with pytest.raises(CommandError, match=r"/belt/advance says that it failed: says the peer") as error:
        stepper.advance_to(at + 1, one, timeout=60.0)
    assert error.value.outcome is stepper.outcome_of(one) is Outcome.NOT_DONE
    rig.mend()
    stepper.advance_to(at + 1, one, timeout=60.0)
    assert rig.tell()["object"] == at + 1


def test_a_belt_is_stopped_by_its_service(rig: Rig, stepper: Ros2ServiceBelt, belt: Ros2Belt) -> None:
    at = rig.tell(travel=60.0)["object"]
    stopping = rig.when_busy("belt", stepper.stop)
    with pytest.raises(CommandError) as error:
        stepper.advance_to(at + 1, an_id(), timeout=30.0)
    stopping.join()
    assert rig.tell()["halted"]
    assert error.value.outcome is Outcome.UNKNOWN
    with pytest.raises(CommandError, match=r"\bdid not stand still\b.*\(it reported -1 last\)"):
        stepper.advance_to(at + 1, an_id(), timeout=2.0)
    rig.mend()
    set_going(rig, belt)
    stepper.advance_to(rig.tell()["object"] + 1, an_id(), timeout=60.0)


def test_a_sort_is_done_once(rig: Rig, sorter: Ros2ServiceSorter) -> None:
    bins, one = rig.tell()["bins"], an_id()
    sorter.sort(2, one)
    sorter.sort(2, one)
    assert sorter.outcome_of(one) is Outcome.DONE
    assert rig.tell()["bins"] == [*bins[:2], bins[2] + 1, *bins[3:]]
    with pytest.raises(CommandError, match=r"\bnone for bin 17\b.*\[0, 1, 2, 3, 4\]") as error:
        sorter.sort(17, an_id())
    assert error.value.outcome is Outcome.NOT_DONE


def test_a_sorter_that_refuses_may_be_asked_again(rig: Rig, sorter: Ros2ServiceSorter) -> None:
    bins, one = rig.tell(full=True)["bins"], an_id()
    with pytest.raises(CommandError, match=r"/sorter/bin_1 says: the bin is full") as error:
        sorter.sort(1, one)
    assert error.value.outcome is sorter.outcome_of(one) is Outcome.NOT_DONE
    rig.mend()
    sorter.sort(1, one)
    assert sum(rig.tell()["bins"]) == sum(bins) + 1


def test_a_sort_whose_answer_is_lost_is_looked_up_where_the_sorter_counts(rig: Rig) -> None:
    bins, one = rig.tell(unanswered=True)["bins"], an_id()
    with Ros2ServiceSorter(scene.sorter_by_service(rig.domain)) as sorter:
        await_ready(sorter)
        sorter.sort(1, one)
        assert sorter.outcome_of(one) is Outcome.DONE
        await_ready(sorter)
    assert sum(rig.tell()["bins"]) == sum(bins) + 1


def test_without_a_count_a_lost_answer_is_unknown_and_nothing_is_sent_until_it_comes(rig: Rig) -> None:
    bins, one = rig.tell(unanswered=True)["bins"], an_id()
    with Ros2ServiceSorter(scene.sorter_by_service(rig.domain, counts=False)) as sorter:
        await_ready(sorter)
        with pytest.raises(CommandError, match=r"/sorter/bin_1 was called and did not end") as error:
            sorter.sort(1, one, timeout=3.0)
        assert error.value.outcome is sorter.outcome_of(one) is Outcome.UNKNOWN
        with pytest.raises(CommandError, match=r"\bwhat came of it is not known\b") as error:
            sorter.sort(1, one, timeout=3.0)
        assert error.value.outcome is Outcome.UNKNOWN
        with pytest.raises(CommandError, match=r"\bhas not answered, and may still act\b") as error:
            sorter.sort(1, an_id(), timeout=3.0)
        assert error.value.outcome is Outcome.NOT_DONE
        with Ros2ServiceSorter(scene.sorter_by_service(rig.domain, counts=False)) as another_program:
            assert another_program.outcome_of(one) is Outcome.UNKNOWN
        rig.mend()
        wait_until(lambda: sorter.outcome_of(one) is Outcome.DONE, "the late answer")
        sorter.sort(1, one)
        assert sum(rig.tell()["bins"]) == sum(bins) + 1


def test_a_sort_that_was_stopped_on_the_way_is_broken_off(rig: Rig) -> None:
    rig.tell(sort=60.0)
    one = an_id()
    with Ros2ServiceSorter(scene.sorter_by_service(rig.domain)) as sorter:
        await_ready(sorter)
        stopping = rig.when_busy("sorter", sorter.stop)
        with pytest.raises(CommandError, match=r"\bbroke the sort off\b.*\bstopped on the way\b") as error:
            sorter.sort(1, one, timeout=30.0)
        stopping.join()
        assert error.value.outcome is sorter.outcome_of(one) is Outcome.BROKEN_OFF


def test_the_emergency_stop(rig: Rig, sorter: Ros2ServiceSorter) -> None:
    rig.tell(sort=60.0)
    pressing = rig.when_busy("sorter", lambda: rig.tell(emergency=True))
    with pytest.raises(EmergencyStopError) as error:
        sorter.sort(1, an_id(), timeout=30.0)
    pressing.join()
    assert error.value.outcome is Outcome.UNKNOWN
    with pytest.raises(EmergencyStopError) as error:
        sorter.sort(1, an_id())
    assert error.value.outcome is Outcome.NOT_DONE
    with Ros2Sorter(scene.sorter(rig.domain)) as by_topic:
        by_topic.stop()


def test_a_restarted_sorter_is_told_apart_and_a_missing_service_named(rig: Rig) -> None:
    options = scene.sorter_by_service(rig.domain, counts=False)
    with Ros2ServiceSorter(options) as sorter:
        await_ready(sorter)
        boot_id = sorter.health().boot_id
        rig.kill(rig.peer)
        rig.start_peer()
        wait_until(lambda: sorter.health().boot_id != boot_id, "the sorter is known to have been restarted")
    with Ros2ServiceSorter(dataclasses.replace(options, services={0: "/sorter/bin_0", 1: "/none"})) as lost:
        health = lost.health()
        assert not health.ready
        assert health.fault.startswith("no server of /none;")
        with pytest.raises(CommandError, match=r"\bno server of /none\b") as error:
            lost.sort(0, an_id(), timeout=10.0)
        assert error.value.outcome is Outcome.NOT_DONE


@pytest.mark.parametrize(
    ("answer", "count", "node", "outcome"),
    [
        (None, 5, "a", Outcome.UNKNOWN),
        (None, -1, "a", Outcome.RUNNING),
        (None, 6, "a", Outcome.DONE),
        (None, 6, "restarted", Outcome.UNKNOWN),
        (None, 7, "a", Outcome.UNKNOWN),
        (True, 5, "a", Outcome.UNKNOWN),
        (True, 6, "a", Outcome.DONE),
        (False, 5, "a", Outcome.NOT_DONE),
        (False, -1, "a", Outcome.BROKEN_OFF),
    ],
)
def test_what_becomes_of_a_call(answer: bool | None, count: int, node: str, outcome: Outcome) -> None:
    call = Call("id", Trigger("/bin"), boot_id="a", count=5)
    said = None if answer is None else Answer(answer, "")
    state = Received(1, 0.0, 0.0, 0.0, node, {"data": count}, b"")
    assert outcome_of_call(call, said, state, counts=True) is outcome
    assert outcome_of_call(call, said, None, counts=True) is Outcome.UNKNOWN
    alone = {None: Outcome.UNKNOWN, True: Outcome.DONE, False: Outcome.NOT_DONE}[answer]
    assert outcome_of_call(call, said, None, counts=False) is alone


def test_the_topic_of_requests() -> None:
    assert request_topic("/belt/advance") == request_topic("belt/advance") == "rq/belt/advanceRequest"


def test_a_cell_file_chooses_services_by_naming_them() -> None:
    nowhere: Any = None
    stop = {"stop_topic": "/stop"}
    assert isinstance(ROS2_BELT.make({"advance_service": "/go", **stop}, nowhere), Ros2ServiceBelt)
    assert isinstance(ROS2_BELT.make({}, nowhere), Ros2Belt)
    assert isinstance(
        ROS2_SORTER.make({"services": {"0": "/a", "1": "/b"}, **stop}, nowhere), Ros2ServiceSorter
    )
    assert isinstance(ROS2_SORTER.make({}, nowhere), Ros2Sorter)
    with pytest.raises(CellError, match=r"\bcommand_topic\b"):
        ROS2_SORTER.make({"services": {"0": "/a"}, "command_topic": "/c", **stop}, nowhere)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"advance_service": ""}, r"\badvance_service is '' and state_topic '/belt/object'"),
        ({"state_topic": ""}, r"\bstate_topic ''.*\breport the object at its end\b"),
        ({"stop_service": "/belt/advance"}, r"\bboth '/belt/advance', expected two services\b"),
        ({"stop_service": ""}, r"\bstop_service is '' and stop_topic ''; expected one\b"),
        ({"stop_topic": "/stop"}, r"\bstop_service is '\S+' and stop_topic '/stop'; expected one\b"),
        ({"domain_id": -1}, r"\bdomain_id is -1\b"),
    ],
)
def test_belts_that_cannot_be_commanded(changes: dict[str, Any], said: str) -> None:
    with pytest.raises(CellError, match=said):
        dataclasses.replace(scene.belt_by_service(1), **changes)


@pytest.mark.parametrize(
    "changes",
    [
        {"services": {}},
        {"services": {0: "/a", 1: "/a"}},
        {"services": {0: ""}},
        {"services": {0: "/sorter/halt"}},
    ],
)
def test_sorters_that_cannot_be_commanded(changes: dict[str, Any]) -> None:
    with pytest.raises(CellError, match=r"\bexpected a service for each bin, and none twice\b"):
        dataclasses.replace(scene.sorter_by_service(1), **changes)
