"""turingfold completion: what a shell must be told to complete commands, options, cases and parameters.

The shell asks this program at each Tab, by argcomplete; nothing heavy is imported for an answer.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from pathlib import Path

import argcomplete
from argcomplete.completers import FilesCompleter
from argcomplete.shell_integration import shellcode

from .files import parameter_names, shipped

HOW = {
    "bash": 'in ~/.bashrc: eval "$(turingfold completion bash)"',
    "zsh": 'in ~/.zshrc, after compinit: eval "$(turingfold completion zsh)"',
    "fish": "in ~/.config/fish/config.fish: turingfold completion fish | source",
}


def completion(shell: str) -> str:
    """Return what a shell runs to complete the words of turingfold."""
    return f"# {HOW[shell]}\n{shellcode(['turingfold'], shell=shell)}"


def complete(commands: argparse.ArgumentParser) -> None:
    """Answer the shell that asks how words go on, and end the program; return where none asks."""
    for command in _commands(commands):
        for action in command._actions:
            if own := COMPLETERS.get(action.dest):
                setattr(action, "completer", own)  # noqa: B010 - where argcomplete looks for it
    argcomplete.autocomplete(commands, always_complete_options=False)


def _commands(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            yield from action.choices.values()


def cases(prefix: str, **_: object) -> list[str]:
    """Return names of cases of the package, and files that may be cases."""
    files = FilesCompleter(allowednames=("py",))(prefix)
    return [*(name for name in shipped() if name.startswith(prefix)), *files]


def parameters(prefix: str, parsed_args: argparse.Namespace, **_: object) -> list[str]:
    """Return parameters of the case that was named before."""
    given = str(getattr(parsed_args, "case", None) or "")
    file = shipped().get(given, Path(given))
    names = parameter_names(file) if file.is_file() else []
    return [f"{name}=" for name in names if name.startswith(prefix)]


COMPLETERS: dict[str, Callable[..., list[str]]] = {
    "case": cases, "cases": cases, "assigned": parameters, "vary": parameters,
}  # fmt: skip
