"""What is particular to OPC UA: who may talk to whom."""

import asyncio
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from asyncua import ua
from asyncua.client.client import Client
from asyncua.crypto.security_policies import SecurityPolicyBasic256Sha256
from asyncua.ua.uaerrors import UaError

from beltsort.drivers.fieldbus.pki import application_uri
from beltsort.drivers.opcua import OpcuaOptions, make, make_diverter
from beltsort.drivers.opcua.nodes import NAMESPACE, REQUEST, node_id
from beltsort.errors import CellError, MissingExtraError
from beltsort.util.extras import require
from tests.contract.peers import OpcuaPeer

pytestmark = pytest.mark.process

ENDPOINT = "opc.tcp://127.0.0.1:4840/beltsort"


class OpenPeer(OpcuaPeer):
    secure = False


@pytest.fixture(scope="module")
def guarded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[OpcuaPeer]:
    peer = OpcuaPeer(tmp_path_factory.mktemp("guarded"))
    try:
        peer.start("--home", "0")
        yield peer
    finally:
        peer.close()


@pytest.mark.parametrize("named", [True, False])
def test_a_stranger_does_not_get_in(guarded: OpcuaPeer, named: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also not by leaving the certificate out of the session, where asyncua would look at it."""

    async def try_in() -> None:
        client = Client(f"opc.tcp://127.0.0.1:{guarded.port}/beltsort")
        client.application_uri = application_uri(guarded.stranger.certificate)
        files = (str(guarded.stranger.certificate), str(guarded.stranger.private_key))
        await client.set_security(SecurityPolicyBasic256Sha256, *files)
        create_session = client.uaclient.create_session

        async def nameless(parameters: ua.CreateSessionParameters) -> ua.CreateSessionResult:
            parameters.ClientCertificate = None
            return await create_session(parameters)

        if not named:
            monkeypatch.setattr(client.uaclient, "create_session", nameless)
        await client.connect()

    with pytest.raises(UaError, match="permission"):
        asyncio.run(try_in())


def test_without_security_nobody_gets_in(guarded: OpcuaPeer) -> None:
    async def try_in() -> None:
        await Client(f"opc.tcp://127.0.0.1:{guarded.port}/beltsort").connect()

    with pytest.raises(UaError):
        asyncio.run(try_in())


@pytest.mark.parametrize("policy", ["Aes128Sha256RsaOaep", "Aes256Sha256RsaPss"])
def test_other_policies_work(guarded: OpcuaPeer, policy: str) -> None:
    own = guarded.client
    endpoint = f"opc.tcp://127.0.0.1:{guarded.port}/beltsort"
    files = (str(own.certificate), str(own.private_key), str(own.trust))
    device = make(OpcuaOptions(endpoint, *files, policy=policy))
    assert device.health().ready
    device.close()


def test_what_is_no_request_is_ignored(guarded: OpcuaPeer) -> None:
    own, endpoint = guarded.client, f"opc.tcp://127.0.0.1:{guarded.port}/beltsort"

    async def write_nonsense() -> None:
        client = Client(endpoint)
        client.application_uri = application_uri(own.certificate)
        await client.set_security(SecurityPolicyBasic256Sha256, str(own.certificate), str(own.private_key))
        async with client:
            index = await client.get_namespace_index(NAMESPACE)
            request = client.get_node(node_id(index, REQUEST))
            await request.write_value([1, 2, 3], ua.VariantType.Int64)

    asyncio.run(write_nonsense())
    device = guarded.device()
    device.sort(0, "after nonsense")
    device.close()


def test_a_server_without_diversions_is_told(guarded: OpcuaPeer) -> None:
    own, endpoint = guarded.client, f"opc.tcp://127.0.0.1:{guarded.port}/beltsort"
    belt = make_diverter(OpcuaOptions(endpoint, str(own.certificate), str(own.private_key), str(own.trust)))
    with pytest.raises(CellError, match=r"\bno diversions\b.*\bDiversionAnswer\b"):
        belt.reading()
    belt.close()


def test_keys_are_their_owners_alone(guarded: OpcuaPeer) -> None:
    assert guarded.server.private_key.stat().st_mode & 0o777 == 0o600


def test_security_can_be_left_out_on_this_computer(tmp_path: Path) -> None:
    peer = OpenPeer(tmp_path)
    try:
        peer.start("--home", "0")
        device = make(OpcuaOptions(f"opc.tcp://127.0.0.1:{peer.port}/beltsort", allow_insecure=True))
        device.sort(0, "sort")
        device.close()
    finally:
        peer.close()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--host", "0.0.0.0"], r"'0\.0\.0\.0'.*\b127\.0\.0\.1\b"),
        (["--pki", "{folder}"], r"\.pem or \.der\b"),
    ],
)
def test_a_server_that_is_open_to_all_or_to_nobody_is_refused(
    tmp_path: Path, arguments: list[str], said: str
) -> None:
    command = [sys.executable, "-m", OpcuaPeer.module, *(part.format(folder=tmp_path) for part in arguments)]
    ran = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    assert ran.returncode != 0
    assert re.search(said, ran.stderr)
    assert "Traceback" not in ran.stderr


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"endpoint": "127.0.0.1:4840"}, r"\bendpoint\b.*'127\.0\.0\.1:4840'.*'opc\.tcp://host:port/path'"),
        ({"endpoint": ENDPOINT}, r"certificate, private_key and trust\b.*docs/fieldbus\.md"),
        (
            {"endpoint": ENDPOINT, "policy": "Basic128Rsa15"},
            r"\bpolicy\b.*'Basic128Rsa15'.*\bBasic256Sha256\b",
        ),
        (
            {"endpoint": ENDPOINT, "allow_insecure": True, "answer_timeout": 0.0},
            r"\banswer_timeout\b.*\b0\.0\b.*\b0\b",
        ),
        (
            {"endpoint": "opc.tcp://192.168.0.5:4840", "allow_insecure": True},
            r"'192\.168\.0\.5'.*\b127\.0\.0\.1\b",
        ),
        ({"endpoint": "opc.tcp://plc.local:4840", "allow_insecure": True}, r"'plc\.local'.*\b127\.0\.0\.1\b"),
    ],
)
def test_options_without_sense_are_refused(options: dict[str, Any], said: str) -> None:
    with pytest.raises(CellError, match=said):
        OpcuaOptions(**options)


def test_a_missing_package_is_named() -> None:
    with pytest.raises(MissingExtraError, match=r"no_such_package\b.*pip install 'beltsort\[opcua\]'"):
        require("opcua", "no_such_package")


def test_drivers_are_loaded_when_a_device_is_made() -> None:
    program = (
        "import sys, beltsort, beltsort.cell, beltsort.drivers.modbus, beltsort.drivers.opcua as opcua\n"
        f"opcua.OpcuaOptions({ENDPOINT!r}, allow_insecure=True)\n"
        "print(*{'asyncua', 'pymodbus', 'cryptography'} & set(sys.modules))"
    )
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == ""
