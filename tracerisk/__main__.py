"""`python -m tracerisk`: the command."""

import sys

from tracerisk.cli import main

if __name__ == "__main__":
    sys.exit(main())
