"""Recordings of runs for the rerun viewer (https://rerun.io), with the extra `rerun`.

The recorder writes a file and opens no connection. It neither reads nor writes rerun's settings; usage
statistics are sent by rerun's own programs, such as its viewer, until `rerun analytics disable`.
"""

from beltsort.rrd.recorder import Recorder

__all__ = ["Recorder"]
