"""The interlock under random commands, faults and deaths, with an opponent that must find planted mistakes.

bench.py     a simulated platform whose every call may be lost, unheard or the owner's last, and what must always hold
machine.py   the steps, as a Hypothesis state machine; how often each came to what
mutants.py   mistakes that are planted
campaign.py  runs it, with or without a mistake
__main__.py  docs/evidence/interlock.md
"""
