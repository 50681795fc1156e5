"""What has been measured, on which code, and whether that code has changed since.

    python -m tests.evidence                   write docs/evidence/index.md from docs/evidence/pages.toml
    python -m tests.evidence --check           list the pages that are older than the code they are about; exit code 0
    python -m tests.evidence --measured NAME   note that docs/evidence/NAME.md was measured on the commit checked out

A page is older than its code if a line below one of its `proves` has changed since its commit; a file that was only
moved has not changed.  Without git history (a source archive, a shallow clone) the age is reported as unknown.
"""

from __future__ import annotations

import argparse
import sys

from tests.evidence.pages import INDEX, check, index, note_measured


def main() -> int:
    """The command line; the exit code is 0 also if pages are old."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="list what is older than its code; write nothing")
    parser.add_argument("--measured", metavar="NAME", help="the page NAME.md was measured on this commit")
    options = parser.parse_args()
    if options.check:
        for line in check():
            print(f"warning: {line}", file=sys.stderr)
        return 0
    if options.measured:
        note_measured(options.measured)
    INDEX.write_text(index())
    return 0


if __name__ == "__main__":
    sys.exit(main())
