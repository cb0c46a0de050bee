"""The command line: `cable-robot`, or `python -m cable_robot`."""

import signal
import sys

from . import _native
from ._fmus import FOLDER


def main():
    """Runs the program `cable-robot` in this process and returns its exit code."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # Python would only take note of Ctrl-C
    return _native.run_command(["cable-robot", *sys.argv[1:]], sys.executable, FOLDER)


if __name__ == "__main__":
    sys.exit(main())
