"""`python -m platform_daemon.processes hardware|web|stop OPTIONS [SOCKETS]`: one process of the daemon."""

import sys

from .process import main

if __name__ == "__main__":  # a worker process imports this file too
    sys.exit(main(sys.argv[1], sys.argv[2], tuple(map(int, sys.argv[3:]))))
