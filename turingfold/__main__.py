"""Run the command line: python -m turingfold."""

from .cli import main

if __name__ == "__main__":
    raise SystemExit(main())
