"""A page in the browser that shows a run, live or afterwards, and can hold it.

It reads the journal and writes nothing, but for requests to hold a run that takes them.
"""

from beltsort.watch.server import WatchServer
from beltsort.watch.watcher import Watcher

__all__ = ["WatchServer", "Watcher"]
