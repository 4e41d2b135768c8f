"""Where the command line begins: with nothing imported, so that Ctrl-C is heard from the first moment."""

import sys


def main() -> int:
    """Run the command line and return its exit status, 130 where Ctrl-C comes while it is imported."""
    try:
        from .main import main as run
    except KeyboardInterrupt:
        print("turingfold: stopped.", file=sys.stderr)
        return 130
    return run()
