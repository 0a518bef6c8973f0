"""The process of a node, with a program that needs no ROS."""

import os
import sys
from concurrent.futures import Future

import pytest

from beltsort.cell import CommandError, Outcome
from beltsort.drivers.ros.process import Answer, NodeProcess, Program

GOES_AWAY = """
import json, sys, time
from multiprocessing.connection import Connection
connection = Connection(int(sys.argv[1]))
json.loads(connection.recv_bytes())
connection.send_bytes(json.dumps({"id": 0}).encode())
connection.send_bytes(b"")
connection.recv_bytes()
connection.close()
time.sleep(60)
"""


def test_a_node_whose_requests_fail_is_not_alive_even_while_its_process_ends() -> None:
    program = Program([sys.executable, "-c", GOES_AWAY], dict(os.environ), "a program", "write it")
    process = NodeProcess(program, {"name": "node"}, 30.0)
    try:
        assert process.alive()
        found: list[bool] = []
        waiting = process._waiting[99] = Future[Answer]()
        waiting.add_done_callback(lambda _: found.append(process.alive()))
        with pytest.raises(CommandError, match="ended during a request") as ended:
            process.ask("newest", 30.0)
        assert ended.value.outcome is Outcome.UNKNOWN
        with pytest.raises(CommandError, match="has ended"):
            process.ask("newest", 30.0)
        assert process._process.poll() is None
        assert found == [False]
    finally:
        process.end(patience=0.0)
