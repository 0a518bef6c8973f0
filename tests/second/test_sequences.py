"""Nothing is lost or done twice with a controller that shares no code with beltsort."""

import shutil
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from tests.contract.peers import ModbusPeer, OpcuaPeer, ServerPeer
from tests.second.controllers import ReferenceSequence, SecondSequence
from tests.second.process import built
from tests.second.sequences import Account, Sequence

pytestmark = pytest.mark.process

AT_ONCE = 6
"""Sequences that run side by side: they wait most of the time."""


@pytest.fixture(scope="module")
def binary(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built(tmp_path_factory.mktemp("controller"))


def ran(make: Callable[[Path, int], Sequence], folder: Path, seeds: range) -> Account:
    """Run sequences; return what they came to together."""

    def one(seed: int) -> Account:
        place = folder / str(seed)
        place.mkdir()
        try:
            account = make(place, seed).run()
        except BaseException as failure:
            failure.add_note(f"in the sequence of seed {seed}; its journal is in {place}")
            raise
        shutil.rmtree(place)
        return account

    whole = Account()
    with ThreadPoolExecutor(AT_ONCE) as pool:
        try:
            for account in pool.map(one, seeds):
                whole.add(account)
                if whole.sequences % 100 == 0:
                    print(f"{whole.sequences} of {len(seeds)} sequences", flush=True)
        finally:
            pool.shutdown(cancel_futures=True)
    return whole


def told(account: Account) -> str:
    faults = ", ".join(f"{name} {number}" for name, number in account.faults.most_common())
    held = ", ".join(f"{name} {number}" for name, number in account.held.most_common())
    return (
        f"\n{account.sequences} sequences, {account.commands} commands, {account.starts} starts\n"
        f"faults {account.faults.total()}: {faults}\nseen to by a person: {held}\n"
        f"objects lost 0, doubled 0, passed and told {account.passed}"
    )


def second(binary: Path) -> Callable[[Path, int], Sequence]:
    return lambda folder, seed: SecondSequence(binary, folder, seed)


def reference(kind: type[ServerPeer]) -> Callable[[Path, int], Sequence]:
    return lambda folder, seed: ReferenceSequence(kind(folder), folder, seed)


def test_nothing_is_lost_or_done_twice(binary: Path, tmp_path: Path) -> None:
    account = ran(second(binary), tmp_path, range(50))
    print(told(account))
    assert account.faults.keys() == set(SecondSequence.faults)
    assert account.faults.total() > 100


@pytest.mark.parametrize("kind", [ModbusPeer, OpcuaPeer])
def test_nothing_is_lost_or_done_twice_with_a_reference_server(
    kind: type[ServerPeer], tmp_path: Path
) -> None:
    account = ran(reference(kind), tmp_path, range(6))
    print(told(account))
    assert account.faults.total() > 10


@pytest.mark.soak
def test_nothing_is_lost_or_done_twice_in_many_sequences(binary: Path, tmp_path: Path) -> None:
    print(told(ran(second(binary), tmp_path, range(1000, 3000))))


@pytest.mark.soak
@pytest.mark.parametrize("kind", [ModbusPeer, OpcuaPeer])
def test_nor_in_many_with_a_reference_server(kind: type[ServerPeer], tmp_path: Path) -> None:
    print(told(ran(reference(kind), tmp_path, range(1000, 1500))))
