"""Run the command line: python -m turingfold."""

from .cli.start import main

if __name__ == "__main__":
    raise SystemExit(main())
