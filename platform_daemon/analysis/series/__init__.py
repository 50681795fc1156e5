"""What follows from the fits of a series: orientation and its spread, Allan deviation, the summary of a file."""
