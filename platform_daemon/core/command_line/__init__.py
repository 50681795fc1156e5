"""Parts that the commands of the command line share."""
