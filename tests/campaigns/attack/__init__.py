"""Many at once against one daemon: how long do /platform and /stop take, and how much memory does it hold?

campaign: the program: situations one after the other, table, page.
load: what makes the load, in a process of its own.
probe: what measures, in another one.
"""
