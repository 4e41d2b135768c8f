"""The package as a whole: which way imports run, what a run loads, what is public and documented."""

import ast
import importlib
import inspect
import re
import subprocess
import sys
import tomllib
from functools import cache
from itertools import chain
from pathlib import Path

import pytest

import turingfold

PACKAGE = Path(turingfold.__file__).parent
# from the bottom up: a file imports from rooms below its own, and from its own without going in circles
ROOMS = (
    ("arrays", "checks", "errors", "memory"),
    ("geometry",),
    ("morphometry", "state", "stepping"),
    ("parts",),
    ("scene",),
    ("growth", "outlines", "turing"),
    ("readers", "terms"),
    ("models",),
    ("extend", "solve"),
    ("stability",),
    ("results",),
    ("figures",),
    ("studies",),
    ("sensitivity",),
    ("testing",),
    ("verification",),
    ("app",),
    ("cli",),
    ("__main__",),
)
FEW = 14  # files at the top of the package
HEAVY = ("matplotlib", "meshio", "pyamg", "ipctk", "rich")


def modules():
    return sorted(path for path in PACKAGE.rglob("*.py") if path != PACKAGE / "__init__.py")


def part(path):
    """Return the part of the package that a file belongs to: its folder, or itself."""
    return path.relative_to(PACKAGE).with_suffix("").parts[0]


@cache
def parsed(path):
    return ast.parse(path.read_text(encoding="utf-8"))


def imports(path):
    """Return the parts of the package that a file imports, wherever in it."""
    found = set()
    for node in ast.walk(parsed(path)):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = path.parent
            for _ in range(node.level - 1):
                base = base.parent
            names = (node.module or "").split(".") if node.module else []
            target = [*base.relative_to(PACKAGE).parts, *names]
            found |= {target[0]} if target else {alias.name for alias in node.names}
    return found


def row(name):
    for number, names in enumerate(ROOMS):
        if name in names:
            return number
    pytest.fail(f"{name} is not listed in ROOMS; put it where it belongs")


def test_imports_run_one_way():
    for path in modules():
        own = part(path)
        for other in imports(path) - {own}:
            assert row(other) < row(own), f"{path} imports {other}, which is not below it"


def targets(path):
    """Return the files of the package that a file imports, wherever in it."""
    found = set()
    for node in ast.walk(parsed(path)):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = path.parents[node.level - 1].joinpath(*(node.module or "").split("."))
            for name in node.names:
                options = (base / f"{name.name}.py", base.with_suffix(".py"), base / "__init__.py")
                found |= {next(option for option in options if option.exists())}
    return found


def test_imports_do_not_go_in_circles():
    below = {path: targets(path) for path in modules()}
    while free := [path for path, needed in below.items() if not needed & below.keys()]:
        for path in free:
            del below[path]
    assert not below, sorted(str(path.relative_to(PACKAGE)) for path in below)


def test_the_top_of_the_package_stays_small():
    assert len([path for path in PACKAGE.glob("*.py*") if path.suffix != ".pyc"]) <= FEW


def test_heavy_packages_are_imported_where_they_are_used():
    contact = {PACKAGE / "terms" / f"{name}.py" for name in ("contact", "walls")}  # which import it
    for path in set(modules()) - contact:
        for node in parsed(path).body:
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) and not node.level else []
            assert not {name.split(".")[0] for name in names} & set(HEAVY), path


def test_every_folder_is_installed():
    folders = {path.parent for path in PACKAGE.rglob("*.py")} - {PACKAGE / "cases"}
    assert not [folder for folder in folders if not (folder / "__init__.py").exists()]


def test_folders_define_nothing():
    for path in PACKAGE.rglob("__init__.py"):
        if path.parent != PACKAGE:
            docstring, *rest = parsed(path).body
            assert isinstance(docstring, ast.Expr), path
            assert all(isinstance(node, ast.ImportFrom) and node.level for node in rest), path


def test_every_public_name_exists_and_is_documented():
    names = [name for name in turingfold.__all__ if name != "__version__"]
    assert len(names) > 40
    for name in names:
        item = getattr(turingfold, name)
        own = inspect.getdoc(item)
        assert own, name
        if inspect.isclass(item):
            # the line that dataclasses make is no documentation
            assert not own.startswith(f"{name}("), name
            for attribute, value in vars(item).items():
                if inspect.isfunction(value) and not attribute.startswith("_"):
                    assert inspect.getdoc(value), f"{name}.{attribute}"


def test_public_names_do_not_hide_modules():
    for name in turingfold.__all__:
        path = PACKAGE / f"{name}.py"
        assert not path.exists() or inspect.ismodule(getattr(turingfold, name)), name


def test_every_package_imported_is_declared():
    project = tomllib.loads((PACKAGE.parent / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    asked = [*project["dependencies"], *chain(*project["optional-dependencies"].values())]
    declared = {re.match(r"[\w-]+", words)[0] for words in asked}
    names = {"skfem": "scikit-fem", "PIL": "pillow", "lazy_loader": "lazy-loader"}
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(parsed(path)):
            found = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            found += [node.module] if isinstance(node, ast.ImportFrom) and not node.level else []
            for name in {name.split(".")[0] for name in found} - sys.stdlib_module_names:
                assert names.get(name, name) in declared, f"{path.name} imports {name}"


SCRIPT = """
import sys
import turingfold
assert "numpy" not in sys.modules, "import turingfold is not cheap"
from turingfold import Elastic, NeoHookean, Scene, Stepping, TangentialGrowth, semicircle, simulate
body = semicircle(radius=1.0, thickness=0.25, size=0.5)
scene = Scene(
    body=body, terms=(Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)),),
    processes=(TangentialGrowth(cortex=1.1),), stepping=Stepping(first=0.5, largest=0.5),
)
simulate(scene).summary()
print(*sorted(sys.modules))
"""


@pytest.fixture(scope="module")
def loaded():
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


UNUSED = (
    "turing", "terms.tension", "terms.contact", "terms.damping", "terms.dynamics", "results.folder",
    "figures", "morphometry.similarity", "stability", "studies", "cli",
)  # fmt: skip


@pytest.mark.parametrize("absent", [*(f"turingfold.{name}" for name in UNUSED), *HEAVY])
def test_a_purely_elastic_run_loads_nothing_else(loaded, absent):
    assert "turingfold.terms.elastic.term" in loaded
    assert not [name for name in loaded if name == absent or name.startswith(f"{absent}.")]


def test_the_package_has_one_version():
    assert importlib.import_module("importlib.metadata").version("turingfold") == turingfold.__version__


def test_every_folder_of_the_package_and_the_cases_are_installed():
    project = tomllib.loads((PACKAGE.parent / "pyproject.toml").read_text(encoding="utf-8"))
    tool = project["tool"]["setuptools"]
    folders = {".".join(path.parent.relative_to(PACKAGE.parent).parts) for path in PACKAGE.rglob("*.py")}
    assert set(tool["packages"]) == {*folders, "turingfold.cases"}
    assert tool["package-dir"] == {"turingfold.cases": "cases"}


def test_no_test_patches_a_private_name():
    patched = re.compile(r"(?:setattr|delattr|patch(?:\.object)?)\([^)]*?[\"'.]_[a-z]\w*[\"']")
    tests = (PACKAGE.parent / "tests").rglob("*.py")
    assert not [path.name for path in tests if patched.search(path.read_text(encoding="utf-8"))]
