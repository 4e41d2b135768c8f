"""Exit statuses of the command line."""

BAD_INPUT = 2
STOPPED = 3  # a solve
IO_FAILED = 4
INTERRUPTED = 130
