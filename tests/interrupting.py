"""Ctrl-C while the main thread is in a call of the core."""

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

TURNS = 1000


@contextmanager
def interrupted() -> Iterator[None]:
    """Let another thread raise SIGINT once it has had many turns, and expect that this ends what is inside.

    Each turn gives the interpreter back to the main thread. So by the last one the main thread is in the call
    inside; and if that call kept the interpreter to itself, there would be no last one.
    """

    def take_turns() -> None:
        for _ in range(TURNS):
            time.sleep(0.0)
        signal.raise_signal(signal.SIGINT)

    interrupter = threading.Thread(target=take_turns, daemon=True)
    with pytest.raises(KeyboardInterrupt):  # noqa: PT012  (it may come as soon as the thread has started)
        interrupter.start()
        yield
