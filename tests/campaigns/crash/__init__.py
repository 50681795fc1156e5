"""Deaths, hangs and cut links, on the emulated wires: how long until the outputs are off, and whether a series goes on.

strikes.py   what is done, and what must come of it
bench.py     an emulated lab with a daemon, or a program that measures, on it
pair.py      two of them in turn
strike.py    one strike: its moment, the blow, the times
page.py      docs/evidence/crash.md
__main__.py  the campaign, with a journal that lets it go on
"""
