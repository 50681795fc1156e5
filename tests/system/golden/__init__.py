"""Golden files: what the command line writes and the REST API answers today, kept to hold later code to it.

`python -m tests.system.golden make FOLDER` runs every command and every route as a user would, in processes of their
own, and keeps exit codes, lines and JSON text; `compare FOLDER` does so again and lists what is different.  Nothing of
the daemon is imported: only its command line and its HTTP port are used, so that the same golden files hold after every
module has moved.
"""
