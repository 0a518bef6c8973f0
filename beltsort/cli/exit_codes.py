"""Exit codes of the commands; docs/recovery.md lists them."""

DONE = 0
EXCEEDED = 1
"""A check found a value beyond a limit, or some of the files could not be labelled."""
WRONG = 2
"""Wrong usage, an invalid file, or an error that a retry does not fix."""
NEEDS_PERSON = 3
"""A run is held: an operator must check the cell and answer."""
TRY_AGAIN = 4
"""A device does not answer, rejects a command or is not ready: the same command may succeed later."""
EMERGENCY_STOP = 5
"""The emergency stop is pressed."""
NOT_WRITTEN = 6
"""The journal cannot be written: a full disk, for example."""
IN_USE = 7
"""Another process uses the same run or the same device."""
SIGNALLED = 128
"""Plus the number of the signal that ended the command: 130 for Ctrl-C, 143 for SIGTERM, 129 for SIGHUP."""
