"""Exit codes of the commands; docs/recovery.md lists them."""

DONE = 0
EXCEEDED = 1
"""A check found something beyond a limit."""
WRONG = 2
"""Usage, a file that is wrong, or an error that trying again does not mend."""
NEEDS_PERSON = 3
"""A run is held: a person must look and say what is true."""
TRY_AGAIN = 4
"""A device does not answer or is not ready: the same command may succeed later."""
EMERGENCY_STOP = 5
"""The emergency stop is pressed."""
NOT_WRITTEN = 6
"""The journal cannot be written: a full disk, for example."""
IN_USE = 7
"""Another process works on the same run or drives the same device."""
SIGNALLED = 128
"""Plus the number of the signal that ended the command: 130 for Ctrl-C, 143 for SIGTERM, 129 for SIGHUP."""
