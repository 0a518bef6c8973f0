"""Whom one side of an OPC UA connection trusts."""

from pathlib import Path

from asyncua.crypto.truststore import TrustStore

from beltsort.drivers.fieldbus.trust import trusted


async def trust_store(folder: Path) -> TrustStore:
    """Return the certificates in a folder, loaded.

    Raises
    ------
    CellError
        If there is none.
    """
    trusted(folder)
    store = TrustStore([folder], [])
    await store.load()
    return store
