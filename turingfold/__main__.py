"""Run the command line: python -m turingfold."""

from .cli.main import main

if __name__ == "__main__":
    raise SystemExit(main())
