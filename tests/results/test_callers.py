"""Warnings name the line of the user that led to them, however deep in the package they arise."""

import errno
import os
import warnings
from pathlib import Path

import numpy as np
import pytest
from small import elastic_scene

from turingfold import (
    CoarseMeshWarning,
    Elastic,
    HoldingForceWarning,
    NeoHookean,
    Scene,
    SelfContact,
    TangentialGrowth,
    outline,
    semicircle,
    simulate,
)
from turingfold.cli import main as command_line

CASE = '''"""A patch of cortex. Less than a second."""
from turingfold import Elastic, NeoHookean, Scene, TangentialGrowth, semicircle
from turingfold import parameters as p


def scenes(quick=False, *, cortex: p.Cortex = 1.05):
    body = semicircle(radius=0.03, thickness=0.01, elements=1)
    solid, grow = Elastic(gray=NeoHookean.from_young(1000.0, 0.4)), TangentialGrowth(cortex=cortex)
    return {"only": Scene(body=body, terms=(solid,), processes=(grow,))}
'''


@pytest.fixture
def no_locks(monkeypatch):
    """Have no locks, as some network drives."""
    fcntl = pytest.importorskip("fcntl")

    def refuse(descriptor, operation):
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(fcntl, "flock", refuse)


def line_of(told, words):
    """Return the file and the line of code that a warning names."""
    (found,) = [each for each in told if words in str(each.message)]
    return found.filename, Path(found.filename).read_text(encoding="utf-8").splitlines()[found.lineno - 1]


@pytest.mark.usefixtures("no_locks")
def test_a_folder_that_cannot_be_locked_is_told_of_at_the_line_that_simulates(tmp_path):
    with pytest.warns(UserWarning, match="cannot be locked") as told:
        simulate(elastic_scene(), tmp_path / "out")  # this line
    file, line = line_of(told, "cannot be locked")
    assert file == __file__
    assert line.endswith("# this line")


@pytest.mark.usefixtures("no_locks")
def test_a_study_that_cannot_be_locked_is_told_of_at_the_line_that_begins_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("patch.py").write_text(CASE)
    told = []
    monkeypatch.setattr(command_line, "note", lambda message, kind, file, *rest: told.append((message, file)))
    command_line.main(["sweep", "patch", "--vary", "cortex=1.05"])
    files = {file for message, file in told if "patch-sweep cannot be locked" in str(message)}
    assert files == {__file__}


def test_a_coarse_mesh_is_told_of_at_the_line_that_simulates():
    body = semicircle(radius=0.03, thickness=0.01, elements=1)
    grow, solid = TangentialGrowth(cortex=1.01), Elastic(gray=NeoHookean.from_young(1000.0, 0.4))
    with pytest.warns(CoarseMeshWarning) as told:
        simulate(Scene(body=body, terms=(solid,), processes=(grow,)))  # this line
    file, line = line_of(told, "through the cortex")
    assert file == __file__
    assert line.endswith("# this line")


def test_what_holds_parts_is_told_of_at_the_line_that_simulates():
    at = 2 * np.pi * np.arange(120) / 120
    circle = np.stack([np.cos(at), np.sin(at)])
    pair = outline([circle, circle + np.array([[2.05], [0.0]])], thickness=0.2, size=0.1)
    grow, solid = TangentialGrowth(cortex=1.25), Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", HoldingForceWarning)
        simulate(Scene(body=pair, terms=(solid, SelfContact()), processes=(grow,)))  # this line
    file, line = line_of(told, "stresses there are the support's")
    assert file == __file__
    assert line.endswith("# this line")
