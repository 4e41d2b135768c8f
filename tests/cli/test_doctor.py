"""What the doctor finds, with packages that are missing, too old or built for other machines."""

import json
import subprocess
import sys

import pytest

from turingfold.cli import doctor
from turingfold.cli.main import main

SOUND = ["lazy-loader>=0.4", 'cvxopt>=1.3.2; extra == "fast"', 'xxarray>=2; extra == "notebook"']


@pytest.fixture
def asks(monkeypatch):
    """Return a function that sets what the package needs."""
    return lambda *words: monkeypatch.setattr(doctor, "requires", lambda name: list(words))


@pytest.fixture
def told(capsys):
    """Return a function that runs the doctor and returns its exit status and its JSON object."""

    def run():
        status = main(["doctor", "--json"])
        return status, json.loads(capsys.readouterr().out)

    return run


def test_what_is_optional_may_be_missing(asks, capsys):
    asks(*SOUND)
    assert main(["doctor"]) == 0
    out = capsys.readouterr().out
    assert 'PyVista objects; without xxarray: pip install "turingfold[notebook]"' in out
    assert out.splitlines()[-1] == "all that is needed works"


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ("no-such-package>=2", 'no-such-package is missing: pip install "no-such-package>=2"'),
        ("lazy-loader>=99", f"lazy-loader {doctor.installed('lazy-loader')} is not lazy-loader>=99: pip"),
    ],
)
def test_what_is_needed_and_missing_or_old_is_status_1(asks, told, asked, words):
    asks(asked)
    status, found = told()
    assert status == 1
    (problem,) = found["problems"]
    assert problem.startswith(words)
    assert found["factorisation"] is None  # it is not tried


def test_a_wheel_for_other_processors_is_named_and_the_others_are_tried(tmp_path, monkeypatch):
    (tmp_path / "deadly_wheel.py").write_text("import os, signal\nos.kill(os.getpid(), signal.SIGILL)")
    (tmp_path / "broken_wheel.py").write_text("raise ImportError('no such\\nsymbol')")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    found = doctor.imported(["json", "deadly_wheel", "broken_wheel", "csv"])
    assert list(found) == ["json", "deadly_wheel", "broken_wheel", "csv"]
    assert found["json"] == found["csv"] == ""
    assert found["deadly_wheel"] == "it ends the program by SIGILL"
    assert found["broken_wheel"] == "ImportError: no such symbol"


def test_a_factorisation_that_fails_is_status_1(asks, told, monkeypatch):
    asks(*SOUND)
    monkeypatch.setattr(doctor, "FACTORISE", "raise ArithmeticError('no pivot')")
    status, found = told()
    assert status == 1
    assert found["problems"][0].startswith("no factorisation works (ArithmeticError: no pivot): pip")


def test_a_folder_that_cannot_be_written_is_status_1(asks, told, monkeypatch):
    def refuses(**_):
        raise PermissionError(13, "Permission denied")

    asks("lazy-loader>=0.4")
    monkeypatch.setattr(doctor, "FACTORISE", "print('Cholmod')")
    monkeypatch.setattr("tempfile.TemporaryDirectory", refuses)
    status, found = told()
    assert (status, found["disk"]["writable"]) == (1, False)
    assert "cannot be written (Permission denied)" in found["problems"][0]


def test_a_package_that_is_not_installed_is_status_1(told, monkeypatch):
    def unknown(name):
        raise doctor.PackageNotFoundError(name)

    monkeypatch.setattr(doctor, "requires", unknown)
    status, found = told()
    assert (status, found["turingfold"]) == (1, None)


@pytest.mark.slow  # it loads every package that is needed
def test_the_doctor_itself_needs_none_of_the_packages():
    load = "from turingfold.cli.main import main; import sys"
    words = f"{load}; print(main(['doctor', '--json']), *sys.modules)"
    done = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, check=True)
    found, ending = done.stdout.splitlines()
    status, *modules = ending.split()
    assert status == "0"
    assert not {"numpy", "scipy", "rich"} & set(modules)
    facts = json.loads(found)
    assert facts["packages"]["shapely"] == doctor.installed("shapely")
    assert facts["factorisation"]["name"] in ("cholmod", "superlu")
    assert facts["extras"].keys() == doctor.EXTRAS.keys()
