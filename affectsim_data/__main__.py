"""`python -m affectsim_data` is the `affectsim` command."""

import sys

from affectsim_data.cli import main

if __name__ == "__main__":
    sys.exit(main())
