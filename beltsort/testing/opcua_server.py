"""A reference OPC UA server: `python -m beltsort.testing.opcua_server --pki FOLDER`.

It prints its endpoint as one line of JSON, reads buttons of the operator's panel from standard input, and
ends with standard input.
"""

from argparse import Namespace
from pathlib import Path
from typing import Any, Generic

from beltsort.drivers.fieldbus.diversions import DiversionRequest, DiversionVerb
from beltsort.drivers.fieldbus.link import ReplyT, RequestT
from beltsort.drivers.fieldbus.security import check_loopback
from beltsort.drivers.fieldbus.wire import Request, Verb
from beltsort.drivers.opcua.diversion_nodes import DIVERSION_NODES
from beltsort.drivers.opcua.nodes import FOLDER, NAMESPACE, NODES, NodeLayout, node_id
from beltsort.testing.serving import Panel, free_port, parser, run, serve
from beltsort.util.extras import extra

with extra("opcua", program=__name__ == "__main__"):
    from asyncua import ua
    from asyncua.common.node import Node
    from asyncua.crypto.permission_rules import User, UserRole
    from asyncua.crypto.truststore import TrustStore
    from asyncua.server.server import Server
    from asyncua.server.user_managers import UserManager
    from cryptography import x509

    from beltsort.drivers.fieldbus.pki import Identity, application_uri, identity
    from beltsort.drivers.opcua.trust import trust_store

SECURE = [
    ua.SecurityPolicyType.Basic256Sha256_SignAndEncrypt,
    ua.SecurityPolicyType.Aes128Sha256RsaOaep_SignAndEncrypt,
    ua.SecurityPolicyType.Aes256Sha256RsaPss_SignAndEncrypt,
]


class TrustedPeers(UserManager):
    """Authenticates clients by the certificate of the secure channel.

    asyncua's own validator checks the certificate named in the session, which a client may omit; only for the
    channel's certificate has the client proved that it has the private key.
    """

    def __init__(self, trust: TrustStore) -> None:
        self._trust = trust

    def get_user(self, *_: Any, **claims: Any) -> User | None:
        """Return the user of a trusted client, or None."""
        certificate = claims["certificate"]
        if certificate is None or not self._trust.validate(x509.load_der_x509_certificate(certificate)):
            return None
        return User(role=UserRole.User, name="client")


class Nodes(Generic[RequestT, ReplyT]):
    """The nodes of a part of the protocol on a server."""

    def __init__(self, layout: NodeLayout[RequestT, ReplyT], request: Node, reply: list[Node]) -> None:
        self._layout = layout
        self._request = request
        self._reply = reply

    async def request(self) -> RequestT | None:
        """Return the last request that a client wrote, or None if it is not a valid one."""
        return self._layout.decode_request(await self._request.read_value())

    async def publish(self, reply: ReplyT) -> None:
        """Publish a reply to clients; the node with the sequence is written last."""
        for node, value in reversed(list(zip(self._reply, self._layout.encode_reply(reply), strict=True))):
            await node.write_value(value, _type_of(value))


def _type_of(value: Any) -> ua.VariantType:
    return ua.VariantType.Boolean if isinstance(value, bool) else ua.VariantType.Int64


async def folder_on(server: Server) -> Node:
    """Create the folder of the nodes on a server."""
    index = await server.register_namespace(NAMESPACE)
    folder: Node = await server.nodes.objects.add_object(f"ns={index};s={FOLDER}", FOLDER)
    return folder


async def build(
    folder: Node, layout: NodeLayout[RequestT, ReplyT], request: RequestT, reply: ReplyT
) -> Nodes[RequestT, ReplyT]:
    """Create the nodes of a part of the protocol, with their first values."""

    async def variable(name: str, value: Any) -> Node:
        index = folder.nodeid.NamespaceIndex
        return await folder.add_variable(node_id(index, name), name, value, _type_of(value))

    asked = await variable(layout.request, layout.encode_request(request))
    await asked.set_writable()
    values = zip(layout.reply, layout.encode_reply(reply), strict=True)
    return Nodes(layout, asked, [await variable(name, value) for name, value in values])


async def secured(own: Identity) -> Server:
    """Return a server that accepts trusted clients only."""
    server = Server(user_manager=TrustedPeers(await trust_store(own.trust)))
    await server.init()
    await server.set_application_uri(application_uri(own.certificate))
    await server.load_certificate(str(own.certificate))
    await server.load_private_key(str(own.private_key))
    server.set_security_policy(SECURE)
    server.set_identity_tokens([ua.AnonymousIdentityToken])
    return server


async def insecure(host: str) -> Server:
    """Return a server without security, for this computer only."""
    check_loopback(host)
    server = Server()
    await server.init()
    server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
    return server


async def main(arguments: Namespace) -> None:
    """Serve until standard input ends."""
    server = await (secured(identity(Path(arguments.pki))) if arguments.pki else insecure(arguments.host))
    endpoint = f"opc.tcp://{arguments.host}:{free_port(arguments)}/beltsort"
    server.set_endpoint(endpoint)
    panel = Panel(arguments)
    folder, shown = await folder_on(server), panel.shown()
    nodes = await build(folder, NODES, Request(shown.sequence, Verb.LOOK), shown)
    diversions = None
    if panel.diverting is not None:
        belt = panel.diverting.look()
        first = DiversionRequest(belt.sequence, DiversionVerb.LOOK)
        diversions = await build(folder, DIVERSION_NODES, first, belt)
    async with server:
        await serve(panel, {"endpoint": endpoint}, nodes, diversions)


if __name__ == "__main__":
    run(main(parser("beltsort.testing.opcua_server", "A reference OPC UA server.").parse_args()))
