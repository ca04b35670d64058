# SPDX-License-Identifier: Apache-2.0
"""The command `gnosphere`, which is `python -m gnosphere`, too."""

import signal
import sys

from . import _gnosphere


def main() -> int:
    """Runs the command line of this process, and returns its exit status."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # Python's own handler would wait for the end of the work
    return _gnosphere._run_command_line(["gnosphere", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
