"""`python -m robotid.cli`: the command line without its entry point."""

import sys

from robotid.cli.app import main

sys.exit(main())
