"""What a scene does not need is not imported."""

import importlib.util
from pathlib import Path

import pytest

FILE = Path(__file__).parent / "benchmarks" / "scene_cost.py"


def scene_cost():
    spec = importlib.util.spec_from_file_location("scene_cost", FILE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
@pytest.mark.parametrize("name", ["growth alone", "ATH", "IPH + DGH", "all three, with inertia"])
def test_modules_of_absent_parts_are_not_imported(name):
    own = scene_cost()
    found = own.measured(own.scenes(quick=True)[name])
    assert found["status"] == "converged"
    for part, module in own.OWN.items():
        assert (
            any(f"{loaded}.".startswith(f"{module}.") for loaded in found["modules"])
            == (own.scenes(quick=True)[name][part])
        )
