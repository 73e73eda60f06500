"""`python -m robotid`: the command line without its entry point."""

import sys

from robotid.cli.entry import main

if __name__ == "__main__":
    sys.exit(main())
