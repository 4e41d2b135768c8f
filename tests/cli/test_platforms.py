"""Other platforms: processes that are spawned, signals of Windows, nothing POSIX-only alone."""

import ast
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from test_cli_parameters import CASE

from turingfold import load
from turingfold.cli.main import main

ROOT = Path(__file__).parents[2]
POSIX = {"fcntl", "resource", "pwd", "grp", "termios", "tty", "pty", "syslog", "posix"}  # modules
CALLS = {"fork", "forkpty", "killpg", "setsid", "getuid", "geteuid", "getpgid", "mkfifo", "uname", "chown"}
SIGNALS = {"SIGKILL", "SIGHUP", "SIGUSR1", "SIGALRM", "SIGPIPE", "SIGQUIT", "SIGCHLD"}
GUARDED = {  # imports that have another way beside them
    ("results/lock.py", "fcntl"), ("memory.py", "resource"),
}  # fmt: skip
SPAWNS = """
import multiprocessing
import sys

from turingfold.cli.main import main

if __name__ == "__main__":
    multiprocessing.set_start_method("spawn")
    sys.exit(main(["sweep", "patch.py", "--quick", "--vary", "cortex=1.04,1.05", "-j", "2", "--out", "two"]))
"""


def posix_only(file):
    """Yield modules, calls and signals in a file that Windows does not have."""
    for node in ast.walk(ast.parse(file.read_bytes())):
        if isinstance(node, ast.Import):
            yield from POSIX & {one.name for one in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module in POSIX:
            yield node.module
        elif isinstance(node, ast.Attribute) and node.attr in CALLS | SIGNALS:
            yield node.attr
        elif isinstance(node, ast.Constant) and node.value == "/dev/null":
            yield node.value


def test_nothing_is_posix_only():
    found = {
        (path.relative_to(ROOT / "turingfold").as_posix(), word)
        for path in (ROOT / "turingfold").rglob("*.py")
        for word in posix_only(path)
    }
    assert found == GUARDED
    assert not [word for path in (ROOT / "cases").glob("*.py") for word in posix_only(path)]


def test_without_fcntl_and_resource_a_folder_is_locked_and_memory_is_not_told(monkeypatch, tmp_path):
    from turingfold import memory

    monkeypatch.setattr(memory, "find_spec", lambda name: None)
    monkeypatch.setattr(memory, "MEMINFO", tmp_path / "none")
    assert memory.address_space_left() == memory.memory_left() == float("inf")


@pytest.mark.slow  # four processes are started
def test_a_sweep_from_a_script_whose_processes_are_spawned_is_that_of_one_process(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("patch.py").write_text(CASE)
    Path("script.py").write_text(SPAWNS)
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "script.py"], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert main(["sweep", "patch.py", "--quick", "--vary", "cortex=1.04,1.05", "--out", "one"]) == 0
    for name in ("cortex=1.04", "cortex=1.05"):
        one, two = (load(f"{out}/patch-sweep/{name}").last["displacement"] for out in ("one", "two"))
        np.testing.assert_array_equal(one, two)


def test_ctrl_break_is_heard_as_ctrl_c_is(monkeypatch, capsys):
    monkeypatch.setattr(signal, "SIGBREAK", signal.SIGUSR1, raising=False)
    before = signal.getsignal(signal.SIGUSR1)
    try:
        assert main(["--version"]) == 0
        assert signal.getsignal(signal.SIGUSR1) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGUSR1, before)


def test_the_app_asks_to_stop_by_what_a_platform_does_not_end_processes_at(monkeypatch):
    pytest.importorskip("starlette")
    from turingfold.app import runs

    sent = []
    monkeypatch.setattr(os, "kill", lambda process, number: sent.append((process, number)))
    runs._tell(7, again=False)
    monkeypatch.setattr(signal, "CTRL_BREAK_EVENT", 1, raising=False)
    runs._tell(7, again=False)
    runs._tell(7, again=True)
    assert sent == [(7, signal.SIGINT), (7, 1), (7, signal.SIGTERM)]
