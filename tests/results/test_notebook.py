"""A result in a notebook: picture, numbers, figures, objects of other libraries; watching a run."""

import io
import re
import sys
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from small import elastic_scene

from turingfold import Stepping, Tracker, half, semicircle, simulate
from turingfold.results.html import picture
from turingfold.results.watch import progress_line


@pytest.fixture(scope="module")
def result():
    return simulate(elastic_scene())


def shoelace(text):
    """Return the area that the first path of an SVG picture encloses, px²."""
    points = np.array(re.findall(r"(-?[\d.]+),(-?[\d.]+)", text), dtype=float)
    x, y = points.T
    return 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))


def paths(svg):
    root = ElementTree.fromstring(svg)
    return float(root.get("width")), [path.get("d") for path in root.iter("{http://www.w3.org/2000/svg}path")]


def test_a_notebook_shows_picture_and_numbers(result):
    shown = result._repr_html_()
    ElementTree.fromstring(shown)  # well-formed
    s = result.summary()
    assert f"<td>{s['growth']:.3f}</td>" in shown
    assert f"<td>{s['gyrification_index']:.2f} ± ?</td>" in shown  # no errors were asked for
    stopped = replace(result, status="stopped", message="J < 0 & more")
    assert "J &lt; 0 &amp; more" in stopped._repr_html_()


@pytest.mark.parametrize("of_half", [False, True])
def test_the_picture_has_the_areas_of_core_and_cortex(of_half):
    body = semicircle(radius=1.0, thickness=0.25, size=0.25)
    width, drawn = paths(picture(half(body) if of_half else body, np.zeros((2, 1))))
    scale = 0.96 * width / 2  # px of a radius
    parts = len(drawn) // 4
    assert parts == 1 + of_half
    core, cortex = (sum(shoelace(one) for one in drawn[k * parts : (k + 1) * parts]) for k in (0, 1))
    assert core / scale**2 == pytest.approx(0.5 * np.pi * 0.75**2, rel=0.01)
    assert (core + cortex) / scale**2 == pytest.approx(0.5 * np.pi, rel=0.01)


def test_plot_draws_the_field_of_a_step(result):
    figure = result.plot(field="jacobian")
    bar = figure.axes[-1]
    assert "J*" in bar.get_ylabel()
    with pytest.raises(ValueError, match="step=100"):
        result.plot(100)
    figure.savefig(io.BytesIO())


def test_meshio_has_the_deformed_body(result):
    mesh = result.to_meshio()
    body = result.scene.body
    np.testing.assert_array_equal(mesh.points[:, :2], body.nodes.T)
    np.testing.assert_array_equal(mesh.point_data["displacement"][:, :2], result.last["displacement"].T)
    assert mesh.cells_dict["triangle6"].shape == (body.mesh.nelements, 6)
    assert mesh.cell_data["growth"][0].max() == pytest.approx(1.3)


def test_xarray_has_all_states_and_the_history(result):
    pytest.importorskip("xarray")
    found = result.to_xarray()
    assert found.sizes["time"] == len(result.states)
    assert found["displacement"].dims == ("time", "axis", "node")
    last = found["displacement"].sel(time=1.0)
    np.testing.assert_array_equal(last, result.last["displacement"])
    assert found["growth"].dims[-2:] == ("point", "triangle")
    energies = [row["energy"] for row in result.history]
    np.testing.assert_array_equal(found["history_energy"], energies)


def test_pyvista_warps_to_the_deformed_body(result):
    pytest.importorskip("pyvista")
    grid = result.to_pyvista()
    moved = grid.warp_by_vector("displacement").points[:, :2]
    places = result.scene.body.nodes + result.last["displacement"]
    np.testing.assert_allclose(moved, places.T, atol=1e-6)


@pytest.mark.parametrize("package", ["xarray", "pyvista"])
def test_what_is_not_installed_is_named(result, monkeypatch, package):
    monkeypatch.setattr("turingfold.results.exports.find_spec", lambda name: None)
    with pytest.raises(ModuleNotFoundError, match=f"pip install {package}"):
        getattr(result, f"to_{package}")()


def test_trackers_are_called_at_their_times_with_the_fields_of_the_states():
    scene = elastic_scene(stepping=Stepping(first=0.2, largest=0.2, stops=(0.5,)))
    every, chosen = [], []
    trackers = (
        Tracker(call=lambda state, fields: every.append(state.time)),
        Tracker(call=lambda state, fields: chosen.append((state, fields)), times=(0, 0.5, 0.55)),
    )
    result = simulate(scene, trackers=trackers)
    assert every == [state.time for state in result.states]
    after = next(time for time in every if time >= 0.55)
    assert [state.time for state, _ in chosen] == [0.0, 0.5, after]
    for state, fields in chosen:
        expected = result.observe(state)
        assert fields.keys() == expected.keys()
        np.testing.assert_allclose(fields["von_mises"], expected["von_mises"], atol=1e-12)


def test_what_is_no_tracker_or_progress_is_refused():
    with pytest.raises(ValueError, match="trackers"):
        simulate(elastic_scene(), trackers=(print,))
    with pytest.raises(ValueError, match="call=3"):
        Tracker(call=3)
    with pytest.raises(ValueError, match="progress='bar'"):
        simulate(elastic_scene(), progress="bar")


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_progress_is_a_line_in_a_terminal_and_ten_in_a_file(capsys):
    rows = [{"time": 0.02 * k, "growth": 1 + 0.01 * k} for k in range(1, 101)]
    file, terminal = io.StringIO(), Terminal()
    for out in (file, terminal):
        show = progress_line(2.0, out)
        for row in rows:
            show(row)
    lines = file.getvalue().splitlines()
    assert len(lines) == 10
    assert lines[4].startswith("##########..........  50%, growth 1.500, about")
    assert lines[-1] == "#################### 100%, growth 2.000"
    assert terminal.getvalue().count("\n") == 1
    assert "\r####################" in terminal.getvalue()
    simulate(elastic_scene(), progress=True)
    assert "100%, growth 1.300" in capsys.readouterr().err


def test_a_notebook_is_a_terminal(monkeypatch):
    monkeypatch.setitem(sys.modules, "ipykernel", io)
    out = io.StringIO()
    show = progress_line(1.0, out)
    show({"time": 0.5, "growth": 1.1})
    show({"time": 1.0, "growth": 1.2})
    assert out.getvalue().startswith("\r")
