"""The trust store of one side of an OPC UA connection."""

from pathlib import Path

from beltsort.drivers.fieldbus.security import trusted
from beltsort.util.extras import extra

with extra("opcua"):
    from asyncua.crypto.truststore import TrustStore


async def trust_store(folder: Path) -> TrustStore:
    """Load the trusted certificates in a folder.

    Raises
    ------
    CellError
        If there are none.
    """
    trusted(folder)
    store = TrustStore([folder], [])
    await store.load()
    return store
