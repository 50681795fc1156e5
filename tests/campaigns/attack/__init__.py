"""Many at once against one daemon: how long do /platform and /stop take, and how much memory does it hold?

campaign: the program: situations one after the other, table, page.
daemon: what is attacked.
series: shots in real time beside it.
load: what makes the load, in a process of its own.
probe: what measures, in another one.
"""
