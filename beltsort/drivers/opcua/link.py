"""One OPC UA session."""

import asyncio
from collections.abc import Coroutine
from contextlib import suppress
from pathlib import Path
from threading import Thread
from typing import Any, Generic, TypeVar

from beltsort.drivers.fieldbus.link import MissingPartError, ReplyT, RequestT
from beltsort.drivers.fieldbus.pki import application_uri
from beltsort.drivers.opcua.nodes import NAMESPACE, NodeLayout, node_id
from beltsort.drivers.opcua.options import OpcuaOptions
from beltsort.drivers.opcua.trust import trust_store
from beltsort.util.extras import extra

with extra("opcua"):
    from asyncua import ua
    from asyncua.client.client import Client
    from asyncua.crypto import security_policies
    from asyncua.crypto.validator import CertificateValidator, CertificateValidatorOptions
    from asyncua.ua.uaerrors import BadNodeIdUnknown

Result = TypeVar("Result")

SESSION_TIMEOUT = 60_000
"""Time after which the server closes the session of a lost client, milliseconds."""


class OpcuaLink(Generic[RequestT, ReplyT]):
    """A session with an event loop and a thread of its own, so that it can be abandoned if it hangs.

    Parameters
    ----------
    options
        Connection to the server.
    layout
        The nodes.
    seconds
        Timeout of each call.
    """

    def __init__(self, options: OpcuaOptions, layout: NodeLayout[RequestT, ReplyT], seconds: float) -> None:
        self._layout, self._seconds = layout, seconds
        self._loop, self._over = asyncio.new_event_loop(), asyncio.Event()
        self._client = Client(options.endpoint, timeout=seconds)
        self._client.session_timeout = SESSION_TIMEOUT
        Thread(target=self._live, name=options.endpoint, daemon=True).start()
        try:
            self._run(self._connect(options))
        except BaseException:
            self.close()
            raise

    def write(self, request: RequestT) -> None:
        """Write a request, without a time stamp, which many controllers reject."""
        value = ua.DataValue(ua.Variant(self._layout.encode_request(request), ua.VariantType.Int64))
        self._run(self._request.write_value(value))

    def read(self) -> ReplyT:
        """Read the latest reply."""
        read = self._run(self._client.read_attributes(self._reply))
        for name, value in zip(self._layout.reply, read, strict=True):
            if value.StatusCode is not None and value.StatusCode.value == BadNodeIdUnknown.code:
                raise MissingPartError(f"it has no node {name}")
        values = [None if value.Value is None else value.Value.Value for value in read]
        return self._layout.decode_reply(values)

    def close(self) -> None:
        """End the session in the background; its thread ends with it."""
        with suppress(RuntimeError):  # it is closed already
            self._loop.call_soon_threadsafe(self._over.set)

    def _live(self) -> None:
        with asyncio.Runner(loop_factory=lambda: self._loop) as runner:
            runner.run(self._until_over())

    async def _until_over(self) -> None:
        await self._over.wait()
        with suppress(Exception):  # the connection is abandoned, whether the server answers or not
            await asyncio.wait_for(self._client.disconnect(), self._seconds)

    async def _connect(self, options: OpcuaOptions) -> None:
        if not options.allow_insecure:
            await self._secure(options)
        await self._client.connect()
        index = await self._client.get_namespace_index(NAMESPACE)
        self._request = self._client.get_node(node_id(index, self._layout.request))
        self._reply = [self._client.get_node(node_id(index, name)) for name in self._layout.reply]

    async def _secure(self, options: OpcuaOptions) -> None:
        self._client.application_uri = application_uri(Path(options.certificate))
        trust = await trust_store(Path(options.trust))
        self._client.certificate_validator = CertificateValidator(
            CertificateValidatorOptions.TRUSTED_VALIDATION | CertificateValidatorOptions.PEER_SERVER, trust
        )
        policy = getattr(security_policies, f"SecurityPolicy{options.policy}")
        await self._client.set_security(policy, options.certificate, options.private_key)

    def _run(self, coroutine: Coroutine[Any, Any, Result]) -> Result:
        try:
            future = asyncio.run_coroutine_threadsafe(coroutine, self._loop)
        except RuntimeError:  # disconnected: the loop is closed
            coroutine.close()
            raise
        return future.result(self._seconds)
