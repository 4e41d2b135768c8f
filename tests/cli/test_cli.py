"""The command line: what it prints, what it leaves, and its exit statuses."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from small import elastic_scene

from turingfold import (
    Elastic,
    NeoHookean,
    Result,
    Scene,
    Stepping,
    TangentialGrowth,
    load,
    outline,
    semicircle,
    simulate,
)  # fmt: skip
from turingfold.cli.main import main
from turingfold.cli.summary import told

CASE = '''"""A patch of cortex that grows. Less than a second.

    turingfold run tiny.py
"""
import os
import signal
from dataclasses import dataclass

import numpy as np

from turingfold import (
    Elastic, NeoHookean, NotConvergedError, Scene, Stepping, TangentialGrowth, semicircle
)
from turingfold.extend import Evolution, Process


@dataclass(frozen=True)
class Stumbles(Process):
    """Growth by nothing that fails after half of the time."""

    how: str
    writes = ("growth",)

    def on(self, body):
        return Stumbling(self.how, body)


class Stumbling(Evolution):
    def __init__(self, how, body):
        self.how, self.body = how, body

    def start(self, state, seed):
        return {"growth": np.ones((3, *self.body.quadrature.weights.shape))}

    def advance(self, before, now, dt):
        if before.time > 0.5 and self.how == "interrupt":
            raise KeyboardInterrupt
        if before.time > 0.5 and self.how == "die":
            os.kill(os.getpid(), signal.SIGKILL)
        if before.time > 0.5:
            raise NotConvergedError("it stumbled over a " + 20 * "long " + "sentence")
        return {}


def scenes(quick=False):
    body = semicircle(radius=1.0, thickness=0.25, size=0.5 if quick else 0.25)
    terms = (Elastic(gray=NeoHookean(mu=1.0, kappa=5.0)),)
    stepping = Stepping(first=STEP, smallest=STEP / 10, largest=STEP)
    grow = TangentialGrowth(cortex=1.2)
    PARTS
    options = {"body": body, "terms": terms, "stepping": stepping}
    return {name: Scene(processes=(part,), **options) for name, part in parts.items()}


def draw(results, figure):
    figure.set_size_inches(2, 1)
    figure.set_layout_engine("none")  # it takes long
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    for result in results.values():
        axes.plot(*result.pial())
'''
GROWS = 'parts = {"grows": grow}'
TWO = 'parts = {"first one": grow, "second one": TangentialGrowth(cortex=1.1)}'
STOPS = 'parts = {"stops": Stumbles("stop"), "grows": grow}'
DIES = 'parts = {"dies": Stumbles("die"), "grows": grow}'
INTERRUPTED = 'parts = {"interrupted": Stumbles("interrupt")}'


@pytest.fixture
def written(tmp_path, monkeypatch):
    """Return a function that writes the case with given parts; the working folder is empty else."""
    monkeypatch.chdir(tmp_path)

    def write(parts, name="tiny.py", step=0.25):
        (tmp_path / name).write_text(CASE.replace("PARTS", parts).replace("STEP", str(step)))
        return name

    return write


def test_run_writes_results_figure_and_seven_lines(written, tmp_path, capsys):
    assert main(["run", written(GROWS)]) == 0
    out, err = capsys.readouterr()
    assert "note: only 1 element(s) through the cortex" in err
    assert len(err.splitlines()) == 1  # the bar is for terminals
    lines = out.splitlines()
    assert len(lines) == 8  # seven and the figure
    assert lines[0].startswith("tiny, grows: reached the end at largest growth 1.20")
    assert lines[1] == "folds: 0 sulci; gyrification index 1.00"
    assert lines[2].startswith("errors of the mesh, estimated: pial length ")
    assert "; of the steps: none, but " in lines[2]  # an equilibrium
    assert lines[4] == "pattern: no pattern"
    assert lines[5].startswith("grown: area 1.")
    assert (tmp_path / "results/tiny/tiny.png").read_bytes().startswith(b"\x89PNG")
    assert json.loads((tmp_path / "results/tiny/grows/summary.json").read_text())["converged"] is True


@pytest.mark.parametrize(
    ("radius", "depth", "gap"),
    [
        (0.04, "12.30 ± ? mm deep on average; ", "0.02 mm,"),
        (1.0, "1.23 ± ? T deep on average (T: cortical thickness); ", "0.002 T,"),
    ],
)
def test_lengths_are_told_in_a_unit_that_suits_the_body(monkeypatch, radius, depth, gap):
    thickness = radius / 4
    result = simulate(elastic_scene(body=semicircle(radius=radius, thickness=thickness, size=thickness)))
    shape = {"folds": 3, "sulcal_depth": 1.23 * thickness, "min_gap": 0.002 * thickness}
    summary = result.summary() | shape
    monkeypatch.setattr(Result, "summary", lambda _: summary)
    _, folds, _, walls, *_ = told("case", {"scene": result}, Path("results"))
    assert f"folds: 3 sulci, {depth}" in folds
    assert f"smallest gap {gap}" in walls


def test_quick_results_are_kept_apart(written, tmp_path):
    case = written(GROWS)
    assert main(["run", case, "--quick"]) == 0
    assert main(["run", case]) == 0
    quick, full = (load(tmp_path / f / "tiny/grows").summary() for f in ("results/quick", "results"))
    assert quick["triangles"] < full["triangles"]


def test_figures_of_the_folder_cases_go_beside_it(written, tmp_path):
    (tmp_path / "cases").mkdir()
    case = written(GROWS, "cases/tiny.py")
    assert main(["run", case, "--quick"]) == 0
    assert not (tmp_path / "figures").exists()  # a quick run never replaces a figure
    assert main(["run", case]) == 0
    assert (tmp_path / "figures/tiny.png").exists()
    (tmp_path / "figures/tiny.png").unlink()
    assert main(["draw", case]) == 0
    assert (tmp_path / "figures/tiny.png").exists()


def test_a_second_run_is_refused_and_told_how(written, capsys):
    case = written(GROWS)
    assert main(["run", case]) == 0
    assert main(["run", case]) == 2
    err = capsys.readouterr().err
    assert "already holds this result" in err
    assert "--resume" in err
    assert main(["run", case, "--resume"]) == 0
    assert main(["run", case, "--overwrite"]) == 0


def test_only_some_scenes(written, tmp_path, capsys):
    case = written(TWO)
    assert main(["run", case, "--only", "second one"]) == 0
    assert [p.name for p in (tmp_path / "results/tiny").iterdir()] == ["second-one"]
    assert "not drawn, these scenes have no result yet: first one" in capsys.readouterr().out
    assert main(["run", case, "--only", "third one"]) == 2
    assert "no scene 'third one'; it has: 'first one', 'second one'" in unwrapped(capsys)
    assert main(["draw", case]) == 2
    assert f"no results of first one; run the case first: turingfold run {case} --only 'first one'" in (
        unwrapped(capsys)
    )


def test_drawing_what_was_never_run_says_what_to_run(written, tmp_path, capsys):
    case = written(TWO)
    assert main(["draw", case, "--quick"]) == 2
    said = "results/quick/tiny holds no results; run the case first: turingfold run tiny.py --quick"
    assert unwrapped(capsys).endswith(said)
    assert [path.name for path in tmp_path.iterdir()] == [case]


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_occupied_folders_are_found_before_anything_runs(written, tmp_path, capsys, jobs):
    case = written(TWO)
    assert main(["run", case, "--only", "second one"]) == 0
    assert main(["run", case, "-j", jobs]) == 2
    assert "scene 'second one': results/tiny/second-one already holds this result" in unwrapped(capsys)
    assert not (tmp_path / "results/tiny/first-one").exists()
    assert main(["run", case, "--resume"]) == 0


def test_variations_with_one_folder_are_refused(written, tmp_path, capsys):
    assert main(["sweep", written(INTERRUPTED), "--vary", "Stumbles.how=a b,a-b"]) == 2
    assert "the scenes 'how=a b' and 'how=a-b' would have one folder" in unwrapped(capsys)
    assert not (tmp_path / "results").exists()


def unwrapped(capsys):
    return " ".join(capsys.readouterr().err.split())


def test_several_scenes_get_a_line_each(written, capsys):
    assert main(["run", written(TWO)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("first one   growth 1.20")
    assert lines[1].startswith("second one  growth 1.10")


@pytest.mark.slow
def test_scenes_in_processes(written, capsys):
    assert main(["run", written(TWO), "-j", "2"]) == 0
    assert capsys.readouterr().out.count("growth 1.") == 2


def test_a_stopped_solve_is_status_3_and_the_rest_is_done(written, tmp_path, capsys):
    assert main(["run", written(STOPS)]) == 3
    out, err = capsys.readouterr()
    assert "STOPPED" in out
    assert "stops: " in err
    assert "it stumbled over a long long" in " ".join(err.split())
    assert max(map(len, err.splitlines()[1:])) <= 100  # after the note
    assert "Traceback" not in err
    stops, grows = (tmp_path / "results/tiny" / name / "summary.json" for name in ("stops", "grows"))
    last = json.loads(stops.read_text())
    assert last["converged"] is False
    assert f"drawn unfinished: stops: stopped at t = {last['time']:.6g} of 1" in " ".join(err.split())
    assert (tmp_path / "results/tiny/tiny.png").exists()
    assert json.loads(grows.read_text())["converged"] is True


def test_ctrl_c_is_status_130_and_says_how_to_go_on(written, tmp_path, capsys):
    case = written(INTERRUPTED, step=0.1)
    assert main(["run", case, "--out", "there"]) == 130
    assert f"turingfold run {case} --out there --resume" in unwrapped(capsys)
    summary = json.loads((tmp_path / "there/tiny/interrupted/summary.json").read_text())
    assert summary["converged"] is False
    assert summary["steps"] == 6  # of a tenth each; the seventh starts after 0.5


@pytest.mark.slow
@pytest.mark.parametrize("jobs", ["1", "2"])
def test_a_real_interrupt_can_be_resumed(written, tmp_path, jobs):
    case = written(GROWS, step=0.002)
    words = [sys.executable, "-m", "turingfold", "run", case, "-j", jobs]
    process = subprocess.Popen(
        words, stderr=subprocess.PIPE, text=True, start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # ignored in the background
    )  # fmt: skip
    history = tmp_path / "results/tiny/grows/history.csv"
    while not history.exists() or history.read_text().count("\n") < 5:
        assert process.poll() is None
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does, to all processes
    said = process.communicate(timeout=60)[1]
    assert "--resume" in said
    assert "Traceback" not in said
    assert process.returncode == 130
    rows = history.read_text().splitlines()
    assert main(["run", case, "--resume"]) == 0
    assert history.read_text().splitlines()[: len(rows)] == rows


def test_an_output_folder_that_cannot_be_made_is_status_4(written, tmp_path, capsys):
    (tmp_path / "occupied").write_text("")
    assert main(["run", written(GROWS), "--out", "occupied"]) == 4
    assert "could not write" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x = 1", "no function scenes; a case has a docstring and two functions"),
        ("def scenes(quick=False):\n    return []", "must return a dict"),
        ("def scenes(quick=False):\n    return {'a': 1}", "'a': int"),
        ("import turingfold\n\ndef scenes(quick=False):\n    turingfold.Linear(gapp=1)", "line 4: TypeError"),
        ("def scenes(:", "line 1: SyntaxError"),
        ("import nowhere", "line 1: ModuleNotFoundError"),
        ("import turingfold\nturingfold.NeoHookean(mu=-1.0, kappa=1.0)", "line 2: mu=-1 must be positive"),
        ("raise SystemExit(0)", "line 1: SystemExit"),
        ("def scenes(quick=False):\n    assert quick", "line 2: AssertionError"),
    ],
)
def test_mistakes_in_a_case_are_status_2(tmp_path, monkeypatch, capsys, text, words):
    monkeypatch.chdir(tmp_path)  # the line is found for a relative path too
    (tmp_path / "wrong.py").write_text(text)
    assert main(["run", "wrong.py"]) == 2
    err = unwrapped(capsys)
    assert words in err
    assert "Traceback" not in err


def test_a_file_that_a_case_misses_is_named(tmp_path, capsys):
    (tmp_path / "wrong.py").write_text("def scenes(quick=False):\n    open('nowhere.csv')")
    assert main(["run", str(tmp_path / "wrong.py")]) == 4
    assert "nowhere.csv: No such file" in capsys.readouterr().err


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_a_scene_that_cannot_start_is_named(written, capsys, jobs):
    turing = "turingfold.Turing(turingfold.Schnakenberg(), half_waves=500)"  # too many for its band
    path = written(f'import turingfold; parts = {{"narrow": {turing}}}')
    assert main(["run", path, "--jobs", jobs]) == 2
    assert "scene 'narrow': half_waves=500" in capsys.readouterr().err


def test_a_mistake_in_draw_names_the_line(written, capsys):
    path = Path(written(GROWS))
    path.write_text(path.read_text() + "    axes.plt()\n")
    assert main(["run", str(path)]) == 2
    assert "AttributeError" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["-j", "x"], ["-j", "0"], ["--resume", "--overwrite"]])
def test_wrong_options_are_refused(written, capsys, words):
    with pytest.raises(SystemExit) as failure:
        main(["run", written(GROWS), *words])
    assert failure.value.code == 2
    assert "_at_least_one" not in capsys.readouterr().err


def test_debug_shows_the_traceback(tmp_path, capsys):
    (tmp_path / "wrong.py").write_text("import nowhere")
    assert main(["run", str(tmp_path / "wrong.py"), "--debug"]) == 2
    assert "Traceback" in capsys.readouterr().err


def test_a_missing_case_is_status_2(capsys):
    assert main(["run", "nowhere.py"]) == 2
    assert "no case file nowhere.py" in capsys.readouterr().err


def test_list_names_cases_and_runs_those_that_are_named(written, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "50")
    written(TWO)
    assert main(["list", str(tmp_path / "tiny.py")]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[-3:] == ["  scenes:", "    first one", "    second one"]
    (tmp_path / "broken.py").write_text("def scenes(quick=False):\n    return 3")
    (tmp_path / "other.py").write_text("raise ValueError('this is no case, and must not be run')")
    assert main(["list", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert "tiny.py: A patch of cortex that grows. Less than a second." in " ".join(out.split())
    assert max(map(len, out.splitlines())) <= max(50, len(str(tmp_path)) + 20)
    assert "other.py" not in out
    assert main(["list", "broken", "tiny"]) == 2
    out, err = capsys.readouterr()
    assert "broken.py: scenes() must return a dict" in " ".join(err.split())
    assert "second one" in out
    (tmp_path / "worse.py").write_text("def scenes(:")
    assert main(["list"]) == 2
    assert "worse.py, line 1: SyntaxError" in " ".join(capsys.readouterr().err.split())
    (tmp_path / "empty").mkdir()
    assert main(["list", str(tmp_path / "empty")]) == 2


def test_a_list_imports_nothing_heavy_and_fits_the_terminal(capsys, monkeypatch):
    words = "import sys; from turingfold.cli.main import main; main(['list']); print('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "False"
    monkeypatch.setenv("COLUMNS", "80")
    assert main(["list", "figure3"]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("  ")]
    assert max(map(len, lines)) <= 80
    assert any(line.startswith(31 * " " + "BVAM2012") for line in lines)  # kinetics go on below each other


def test_stability_prints_the_conditions(capsys):
    # Schnakenberg a = 0.1, b = 0.9: f_u = 0.8, det J = 1, so the critical ratio is ((1 + √1.8)/0.8)²
    assert main(["stability", "Schnakenberg", "--param", "a=0.1", "--param", "b=0.9"]) == 0
    assert f"critical {((1 + 1.8**0.5) / 0.8) ** 2:.6g}"[:14] in capsys.readouterr().out


def test_stability_on_a_body_names_its_modes(tmp_path, capsys):
    figure = tmp_path / "s.png"
    assert main(["stability", "Schnakenberg", "--half-waves", "24", "--figure", str(figure)]) == 0
    assert " 24 half waves along" in capsys.readouterr().out
    assert figure.stat().st_size > 10_000
    assert main(["stability", "Schnakenberg", "--half-waves", "24", "--thickness", "-1"]) == 2
    assert "thickness=-1" in capsys.readouterr().err


@pytest.mark.parametrize(("name", "begin"), [("s.PNG", b"\x89PNG"), ("s.pdf", b"%PDF"), ("s.svg", b"<?xml")])
def test_a_figure_has_the_format_of_its_name(tmp_path, name, begin):
    assert main(["stability", "Schnakenberg", "--figure", str(tmp_path / name)]) == 0
    assert (tmp_path / name).read_bytes().startswith(begin)


@pytest.mark.parametrize("name", ["s.bmp", "s", "png"])
def test_a_figure_of_another_format_is_refused(tmp_path, capsys, name):
    with pytest.raises(SystemExit, match="2"):
        main(["stability", "Schnakenberg", "--figure", str(tmp_path / name)])
    assert f"{name}' must end with .png, .pdf or .svg" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["Schnakenburg"], "must be one of"),
        (["Schnakenberg", "--param", "c=1"], "no parameter 'c'; it has a, b"),
        (["Schnakenberg", "--param", "a=x"], "NAME=VALUE"),
        (["Schnakenberg", "--ratio", "-1"], "ratio=-1 must be positive"),
    ],
)
def test_stability_refuses_what_it_does_not_know(capsys, words, message):
    assert main(["stability", *words]) == 2
    assert message in unwrapped(capsys)


def test_compare_puts_results_side_by_side(written, tmp_path, capsys):
    assert main(["run", written(TWO)]) == 0
    capsys.readouterr()
    folders = [str(tmp_path / "results/tiny" / name) for name in ("first-one", "second-one")]
    assert main(["compare", *folders, "--figure", "c.png"]) == 0
    out = capsys.readouterr().out
    assert "first-one" in out
    assert "gyrification index" in out
    assert (tmp_path / "c.png").exists()
    assert main(["compare", folders[0], str(tmp_path)]) == 2
    capsys.readouterr()
    assert main(["compare", folders[0], "nofile.csv"]) == 2
    assert "there is no file or folder nofile.csv; name" in unwrapped(capsys)
    assert main(["compare", folders[0], "results/tiny"]) == 2
    assert "holds several results; name one of results/tiny/first-one" in unwrapped(capsys)
    (tmp_path / "results/tiny/tiny.png").unlink()
    for folder in ("results/tiny", folders[0]):
        assert main(["draw", folder]) == 0
        assert (tmp_path / "results/tiny/tiny.png").exists()
    assert main(["draw", str(tmp_path)]) == 2
    assert "holds no results of a case; name a case" in unwrapped(capsys)


def test_threads_are_set_before_numpy_is_imported(tmp_path):
    script = (
        "import sys, os\nimport turingfold.cli.main as cli\nassert 'numpy' not in sys.modules\n"
        "cli.main(['stability', 'BVAM', '--threads', '2'])\nprint(os.environ['OMP_NUM_THREADS'])"
    )
    environment = {k: v for k, v in os.environ.items() if "THREADS" not in k}
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "2"
    with pytest.raises(SystemExit, match="2"):
        main(["run", "x.py", "--threads", "0"])


def test_compare_reads_outlines(tmp_path, capsys):
    angle = np.linspace(0.0, 2 * np.pi, 200, endpoint=False)
    for name, lobes in (("plain", 0.0), ("lobed", 0.2)):
        r = 1.0 + lobes * np.cos(6 * angle)
        table = np.stack([r * np.cos(angle), r * np.sin(angle)], axis=1)
        np.savetxt(tmp_path / f"{name}.csv", table, delimiter=",", header="x,y", comments="")
    assert main(["compare", str(tmp_path / "plain.csv"), str(tmp_path / "lobed.csv")]) == 0
    (folds,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("folds")]
    assert folds.split()[1:3] == ["0", "6"]
    (tmp_path / "marks.csv").write_text("name,x_a,y_a,x_b,y_b\nright,1,0,1.2,0\n")
    names = [str(tmp_path / name) for name in ("plain.csv", "lobed.csv", "marks.csv")]
    assert main(["compare", *names[:2], "--landmarks", names[2]]) == 0
    told = capsys.readouterr().out
    assert "landmark right: at 0.000 and 0.000 of the arcs" in told
    assert told.count("best circle 1.000") == 3  # the plain outline is one
    assert main(["compare", *names[:2], "--landmarks", names[0]]) == 2


def table(file, curves):
    file.write_text(
        "x,y\n" + "\n\n".join("\n".join(f"{x},{y}" for x, y in curve.T.tolist()) for curve in curves)
    )


def test_compare_takes_one_of_several_curves_by_its_number_or_name(tmp_path, capsys):
    """Circles of radius 1 and 2: their lengths are 2π and 4π m."""
    angle = 2 * np.pi * np.arange(90) / 90
    circle = np.stack([np.cos(angle), np.sin(angle)])
    table(tmp_path / "two.csv", [circle, 2 * circle + 5])
    two, one = str(tmp_path / "two.csv"), str(tmp_path / "one.csv")
    table(tmp_path / "one.csv", [circle])
    assert main(["compare", two, one]) == 2
    said = unwrapped(capsys)
    assert "of 2 curves: 0 (6.28 long), 1 (12.6 long); choose one, as by --curve-a 0" in said
    assert main(["compare", one, two, "--curve-b", "2"]) == 2
    assert "--curve-b 2: there is none in" in unwrapped(capsys)
    assert main(["compare", one, two, "--curve-b", "1"]) == 0
    (length,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("length, m")]
    assert [float(word) for word in length.split()[2:]] == pytest.approx(
        [2 * np.pi, 4 * np.pi, 2.0], rel=2e-3
    )
    drawing = tmp_path / "two.svg"
    shapes = "".join(f'<circle id="{name}" r="{r}"/>' for name, r in (("inner", 1), ("outer", 2)))
    drawing.write_text(f'<svg xmlns="http://www.w3.org/2000/svg">{shapes}</svg>')
    assert main(["compare", one, str(drawing), "--curve-b", "outer"]) == 0
    (length,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("length, m")]
    assert float(length.split()[-1]) == pytest.approx(2.0, rel=2e-3)


def ratio_of_lengths(capsys):
    (length,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("length, m")]
    return float(length.split()[-1])


def test_compare_takes_no_curve_by_a_name_that_several_have_or_that_is_a_number(tmp_path, capsys):
    """A ring of radii 3 and 1 in one path; circles of radii 2 and 3 are called by each other's number."""
    angle = 2 * np.pi * np.arange(90) / 90
    table(tmp_path / "one.csv", [np.stack([np.cos(angle), np.sin(angle)])])
    ring = " ".join(f"M{r},0 A{r},{r} 0 0 1 -{r},0 A{r},{r} 0 0 1 {r},0 Z" for r in (3, 1))
    svg = '<svg xmlns="http://www.w3.org/2000/svg">{}</svg>'
    (tmp_path / "ring.svg").write_text(svg.format(f'<path id="pial" d="{ring}"/>'))
    circles = '<circle id="1" r="2"/><circle id="0" r="3"/><circle id="7" r="4"/>'
    (tmp_path / "numbers.svg").write_text(svg.format(circles))
    words = ["compare", str(tmp_path / "one.csv")]
    assert main([*words, str(tmp_path / "ring.svg"), "--curve-b", "pial"]) == 2
    said = unwrapped(capsys)
    assert "--curve-b pial: 2 curves of" in said
    assert "have this name: 0 (pial, 18.8 long), 1 (pial, 6.28 long); choose one by its number" in said
    for file, which, ratio in (
        ("ring", "0", 3),
        ("numbers", "0", 2),
        ("numbers", "1", 3),
        ("numbers", "7", 4),
    ):
        assert main([*words, str(tmp_path / f"{file}.svg"), "--curve-b", which]) == 0
        assert ratio_of_lengths(capsys) == pytest.approx(ratio, rel=3e-3)


def test_compare_takes_one_of_several_parts_of_a_result(tmp_path, capsys):
    """A disc with a closed-off sulcus, which runs clockwise, beside a smaller disc; all hardly grown."""
    angle = 2 * np.pi * np.arange(90) / 90
    circle = np.stack([np.cos(angle), np.sin(angle)])
    with pytest.warns(UserWarning, match="lies inside another"):
        body = outline([circle, 0.4 * circle, 0.7 * circle + 3], thickness=0.1, size=0.1)
    solid = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))
    steps = Stepping(first=1.0, largest=1.0)
    scene = Scene(body=body, terms=(solid,), processes=(TangentialGrowth(cortex=1.0001),), stepping=steps)
    simulate(scene, out=tmp_path / "parts")
    parts = str(tmp_path / "parts")
    assert main(["compare", parts, parts]) == 2
    assert "of 3 curves: 0 (6.28 long), 1 (4.4 long), 2 (2.51 long); choose one" in unwrapped(capsys)
    assert main(["compare", parts, parts, "--curve-a", "1", "--curve-b", "2"]) == 0
    (length,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("length, m")]
    assert [float(word) for word in length.split()[2:]] == pytest.approx(
        [1.4 * np.pi, 0.8 * np.pi, 0.8 / 1.4], rel=2e-3
    )


def test_compare_reads_landmarks_in_the_unit_of_their_header(tmp_path, capsys):
    angle = 2 * np.pi * np.arange(80) / 80
    circle = 0.03 * np.stack([np.cos(angle), np.sin(angle)])
    table(tmp_path / "disc.csv", [circle])
    words = ["compare", *2 * [str(tmp_path / "disc.csv")], "--landmarks", str(tmp_path / "marks.csv")]
    row = "name,x_a{0},y_a{0},x_b{0},y_b{0}\ntop,0,30,-30,0\n"
    (tmp_path / "marks.csv").write_text(row.format(" (mm)"))
    assert main(words) == 0
    assert "landmark top: at 0.250 and 0.500 of the arcs" in capsys.readouterr().out
    (tmp_path / "marks.csv").write_text(row.format(""))
    assert main(words) == 2
    assert "in its unit" in unwrapped(capsys)


def test_compare_says_that_a_curve_of_which_landmarks_lie_far_off_states_no_unit(tmp_path, capsys):
    angle = 2 * np.pi * np.arange(80) / 80
    circle = 5 * np.stack([np.cos(angle), np.sin(angle)])  # mm
    table(tmp_path / "plain.csv", [circle])
    stated = (tmp_path / "plain.csv").read_text().replace("x,y", "x (mm),y (mm)")
    (tmp_path / "stated.csv").write_text(stated)
    plain, stated = str(tmp_path / "plain.csv"), str(tmp_path / "stated.csv")
    marks = tmp_path / "marks.csv"
    marks.write_text("name,x_a (mm),y_a (mm),x_b (mm),y_b (mm)\ntop,0,5,-5,0\n")
    assert main(["compare", stated, plain, "--landmarks", str(marks)]) == 2
    said = unwrapped(capsys)
    assert "curve b" in said
    assert "plain.csv states no unit, so that its numbers are read as metres" in said
    assert main(["compare", stated, stated, "--landmarks", str(marks)]) == 0
    marks.write_text(marks.read_text().replace("0,5,", "0,9,"))
    capsys.readouterr()
    assert main(["compare", stated, plain, "--landmarks", str(marks)]) == 2
    assert "states no unit" not in unwrapped(capsys)  # curve a is to blame, and has one


def test_a_case_may_import_a_file_beside_it(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(sys, "path", list(sys.path))
    (tmp_path / "my_shapes_for_a_test.py").write_text("RADIUS = 1.0\n")
    (tmp_path / "own.py").write_text(
        '"""Own."""\nfrom my_shapes_for_a_test import RADIUS\nfrom turingfold import *\n'
        "def scenes(quick=False):\n"
        "    body = semicircle(radius=RADIUS, thickness=0.25, size=0.25)\n"
        "    solid = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))\n"
        "    return {'one': Scene(body=body, terms=(solid,), processes=(TangentialGrowth(cortex=1.1),))}\n"
    )
    assert main(["list", str(tmp_path / "own.py")]) == 0
    assert "one" in capsys.readouterr().out


@pytest.mark.parametrize("command", ["run", "sweep", "accuracy"])
def test_a_case_makes_its_scenes_once(tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    Path("own.py").write_text(
        '"""Own."""\nfrom pathlib import Path\nfrom turingfold import *\n'
        "def scenes(quick=False):\n"
        "    with Path('made').open('a') as file:\n        file.write('x')\n"
        "    body = semicircle(radius=1.0, thickness=0.25, size=0.25)\n"
        "    solid = Elastic(gray=NeoHookean(mu=1.0, kappa=5.0))\n"
        "    steps, grow = Stepping(first=1, largest=1), TangentialGrowth(cortex=1.1)\n"
        "    return {'one': Scene(body=body, terms=(solid,), processes=(grow,), stepping=steps)}\n"
        "def draw(results, figure):\n    figures.section(figure.add_subplot(), results['one'])\n"
    )
    more = ["--vary", "TangentialGrowth.cortex=1.1,1.2"] if command == "sweep" else []
    assert main([command, "own.py", *more]) == 0
    assert Path("made").read_text() == "x"


TABLE = '''

def table(results):
    """Return one row."""
    (one,) = results.values()
    return [{"name": "grows", "growth": one.summary()["growth"], "chance": None}]
'''


def test_the_table_of_a_case_is_written_as_csv_and_markdown(written, tmp_path, capsys):
    name = written(GROWS)
    (tmp_path / name).write_text((tmp_path / name).read_text() + TABLE)
    assert main(["run", name]) == 0
    assert "table: results/tiny/table.md" in capsys.readouterr().out
    markdown = (tmp_path / "results/tiny/table.md").read_text()
    assert markdown == "| name | growth | chance |\n| --- | --- | --- |\n| grows | 1.2 | - |\n"
    assert (tmp_path / "results/tiny/table.csv").read_text().splitlines()[0] == "name,growth,chance"


@pytest.mark.parametrize("wrong", ["[]", "[{'a': 1}, {'b': 1}]", "[1]", "None"])
def test_a_table_that_is_no_rows_is_refused(written, tmp_path, capsys, wrong):
    name = written(GROWS)
    text = (tmp_path / name).read_text() + f"\n\ndef table(results):\n    return {wrong}\n"
    (tmp_path / name).write_text(text)
    assert main(["run", name]) == 2
    assert "must return a list of dicts with the same keys" in " ".join(capsys.readouterr().err.split())
