"""`python -m platform_daemon.core.guard PID`: the guard of a process."""

import sys

from .watch import main

sys.exit(main())
