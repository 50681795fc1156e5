"""The study as a program: python -m tests.campaigns.angle_study

Seeded: record number K is the same in every run.  The journal (JSON lines) lets an interrupted study go on.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

from tests.campaigns.angle_study.cases import CASES
from tests.campaigns.angle_study.command import Command
from tests.campaigns.angle_study.journal import finished, keep
from tests.campaigns.angle_study.page import document, row
from tests.campaigns.angle_study.record import record_of, written
from tests.campaigns.angle_study.score import case_names, scored


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--records", type=int, default=200)
    parser.add_argument("--first", type=int, default=0, help="number of the first record")
    parser.add_argument("--only", choices=case_names(), help="only this case, of the same numbers")
    parser.add_argument("--record", type=int, nargs="+", help="these records and no others")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--most-s", type=float, default=300.0, help="after which a diagnosis counts as not done")
    parser.add_argument("--page", type=Path)
    parser.add_argument("--journal", type=Path, help="keep scores in this file, and go on after those it holds")
    parser.add_argument("--file", type=Path, help="write the one --record to this file, and do not diagnose it")
    asked = parser.parse_args()
    if asked.file is not None:
        for index in asked.record or ():
            print(written(record_of(asked.seed, index), asked.file))
        return 0
    numbers = asked.record or range(asked.first, asked.first + asked.records)
    todo = [k for k in numbers if asked.only in (None, CASES[k % len(CASES)].name)]
    known = {k: s for k, s in finished(asked.journal, asked.seed).items() if k in todo}
    command, began = Command(asked.most_s), time.monotonic()
    try:
        with tempfile.TemporaryDirectory() as folder:
            for count, index in enumerate([k for k in todo if k not in known], 1):
                known[index] = scored(record_of(asked.seed, index), command, Path(folder))
                keep(asked.journal, known[index])
                left = (time.monotonic() - began) / count * (len(todo) - len(known))
                print(f"{len(known)}/{len(todo)}, {left / 60.0:.0f} min left, {known[index].seconds:.0f} s: "
                      f"{row(known[index])}", flush=True)  # fmt: skip
    except KeyboardInterrupt:
        print("stopped; the page has what is finished")
    command.close()
    text = document([known[k] for k in sorted(known)], len(todo), asked.seed)
    print(text)
    if asked.page:
        asked.page.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
