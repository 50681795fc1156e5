"""The command line: `main` lists the commands; one file per command, and what the commands share."""
