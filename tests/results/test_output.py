"""Results on disk: round trips, damage, foreign content, and going on after a kill to the last bit."""

import contextlib
import errno
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest
from small import elastic_scene, folding_scene
from test_results import Breaks

import turingfold
from turingfold import (
    CorruptFileError,
    Elastic,
    NeoHookean,
    OutputError,
    Scene,
    Stepping,
    StoppedError,
    TangentialGrowth,
    load,
    semicircle,
    simulate,
)
from turingfold.results.codec import decode, encode
from turingfold.results.document import difference, stored
from turingfold.results.files import arrays_content, digest, read_arrays, write_whole, writing
from turingfold.results.history import History, read_history
from turingfold.results.identity import Identity
from turingfold.results.vtu import Frames, arrays_of, entries, in_cells, index, mesh_of

HERE = Path(__file__).parents[1]
PARTS = [
    turingfold.Elastic(
        gray=turingfold.NeoHookean(mu=1.0, kappa=5.0), white=turingfold.NeoHookean(mu=2.0, kappa=1 / 3)
    ),
    turingfold.TangentialGrowth(cortex=1.9, history=turingfold.Table(times=(0.0, 0.1), shares=(0.0, 1.0))),
    turingfold.AxonalTension(strength=-0.5, surface="pial", direction="toward-peaks"),
    turingfold.Turing(turingfold.BVAM(), half_waves=20, ratio=7.0),
    turingfold.SelfContact(),
    turingfold.Stepping(seconds=np.inf),
]


def same(a, b):
    return a.keys() == b.keys() and all(np.array_equal(a[k], b[k], equal_nan=True) for k in a)


# scenes as JSON


@pytest.mark.parametrize("part", PARTS, ids=lambda part: type(part).__name__)
def test_parts_come_back_equal(part):
    text = json.dumps(encode(part, {}), allow_nan=False)
    assert decode(json.loads(text), {}) == part


def test_a_scene_comes_back_with_its_mesh():
    scene = folding_scene()
    document, arrays = stored(scene)
    again = decode(json.loads(json.dumps(document["scene"], allow_nan=False)), arrays)
    assert again.terms == scene.terms
    assert again.processes == scene.processes
    assert again.stepping == scene.stepping
    np.testing.assert_array_equal(again.body.nodes, scene.body.nodes)
    np.testing.assert_array_equal(again.body.pial, scene.body.pial)
    np.testing.assert_array_equal(again.body.in_cortex, scene.body.in_cortex)
    assert difference(stored(again)[0], document) == ""


@pytest.mark.parametrize(
    "foreign",
    [
        {"class": "subprocess.Popen", "args": "true"},
        {"function": "os.system"},
        {"class": "turingfold.results.simulate.Scene"},  # not where it is defined
        {"class": "turingfold.results.folder.ResultFolder"},  # not a dataclass
        {"class": "turingfold.nothing.Here"},
        {"class": "turingfold..scene"},
        {"class": "turingfold.simulate"},  # public, but a function
        {"function": "turingfold.results.files.write_whole"},  # ours, but not what the caller names
        {"function": "turingfold.simulate"},
    ],
)
def test_what_is_read_cannot_run_other_code(foreign):
    with pytest.raises(ValueError, match=r"scene: the stored scene uses .*, which is not part of"):
        decode(foreign, {})


def test_fields_must_be_those_of_the_class():
    part = encode(turingfold.SelfContact(), {})
    with pytest.raises(ValueError, match="differ in the fields: strength"):
        decode({**part, "strength": 1.0}, {})
    with pytest.raises(ValueError, match="differ in the fields: kappa"):
        decode({"class": "turingfold.NeoHookean", "mu": 1.0}, {})
    del part["gap"]  # as if the option were newer than the result
    assert decode(part, {}) == turingfold.SelfContact()


def test_own_classes_must_be_named():
    part = json.loads(json.dumps(encode(Breaks(after=0.25), {})))
    with pytest.raises(ValueError, match=r"known="):
        decode(part, {})
    assert decode(part, {}, known=[Breaks]) == Breaks(after=0.25)


@pytest.mark.parametrize("value", [lambda u, v: u, object(), {1: 2}])
def test_what_cannot_be_written_down_is_refused(value):
    with pytest.raises(ValueError, match=r"stored with the results|top of a module"):
        encode(value, {})


# files


def test_arrays_keep_their_bits_and_show_damage(tmp_path):
    arrays = {"x": np.random.default_rng(0).standard_normal((3, 40)), "n": np.array(7), "empty": np.zeros(0)}
    write_whole(tmp_path / "a.npz", arrays_content(arrays))
    assert same(read_arrays(tmp_path / "a.npz"), arrays)
    content = (tmp_path / "a.npz").read_bytes()
    caught = 0
    for at in range(0, len(content), 23):
        (tmp_path / "a.npz").write_bytes(content[:at] + bytes([content[at] ^ 0xFF]) + content[at + 1 :])
        try:  # a changed date in the archive harms nobody
            assert same(read_arrays(tmp_path / "a.npz"), arrays)
        except CorruptFileError:
            caught += 1
    assert caught > 960 / 23  # at least each time when one of the numbers was hit
    (tmp_path / "a.npz").write_bytes(content[: len(content) // 2])
    with pytest.raises(CorruptFileError, match="damaged"):
        read_arrays(tmp_path / "a.npz")


def test_damage_anywhere_in_the_archive_s_directory_is_damage(tmp_path):
    file = tmp_path / "a.npz"
    write_whole(file, arrays_content({"x": np.arange(3.0), "n": np.array(7)}))
    content = file.read_bytes()
    for at in range(content.index(b"PK\x01\x02"), len(content)):
        file.write_bytes(content[:at] + b"\xff" + content[at + 1 :])
        with contextlib.suppress(CorruptFileError):  # any other error would end the run that resumes
            assert set(read_arrays(file)) == {"x", "n"}
    file.write_bytes(content[:-6] + b"\xff" * 4 + content[-2:])  # the directory's place, beyond the file
    with pytest.raises(CorruptFileError, match="damaged"):
        read_arrays(file)


def test_a_single_array_is_no_file_of_arrays(tmp_path):
    np.save(tmp_path / "one.npy", np.arange(3.0))
    with pytest.raises(CorruptFileError, match="single array"):
        read_arrays(tmp_path / "one.npy")


def test_pickled_arrays_are_not_read(tmp_path):
    np.savez(tmp_path / "a.npz", x=np.array([{}], dtype=object), sha256=np.array(""))
    with pytest.raises(CorruptFileError):
        read_arrays(tmp_path / "a.npz")


def test_the_checksum_sees_names_types_and_shapes():
    x = np.arange(6.0)
    tables = ({"x": x}, {"y": x}, {"x": x.reshape(2, 3)}, {"x": x.astype(int)}, {"x": x, "y": x})
    assert len({digest(table) for table in tables}) == len(tables)
    assert digest({"x": np.asfortranarray(x.reshape(2, 3))}) == digest({"x": x.reshape(2, 3)})


def test_a_write_that_fails_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "summary.json"
    write_whole(path, b"old")

    def full(_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OutputError, match=r"No space left on device.*resume") as caught:
        write_whole(path, b"new")
    assert caught.value.errno == errno.ENOSPC
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("number", "remedy"),
    [
        (errno.ENOSPC, "Everything written before is complete; free some space.*resume"),
        (errno.EFBIG, "raise the limit on the size of files.*resume"),
        (errno.EROFS, "Make this place writable or choose another"),
        (errno.EACCES, "Make this place writable or choose another"),
        (errno.EIO, "see to the disk.*resume"),
    ],
)
def test_what_to_do_depends_on_what_failed(tmp_path, number, remedy):
    said = rf"could not write .*{os.strerror(number)}\. .*{remedy}"
    with pytest.raises(OutputError, match=said) as caught, writing(tmp_path / "a.npz"):
        raise OSError(number, os.strerror(number))
    assert caught.value.errno == number
    assert ("free some space" in str(caught.value)) == (number == errno.ENOSPC)


def test_a_folder_that_is_a_file_or_gone_is_said_to_be(tmp_path):
    (tmp_path / "notes").write_text("")
    for path in ("notes/a.npz", "notes/deeper/a.npz"):
        with pytest.raises(OutputError, match="A part of this path is a file; choose another folder"):
            write_whole(tmp_path / path, b"")
    with pytest.raises(OutputError, match="Its folder is not there"), writing(tmp_path / "a"):
        (tmp_path / "nowhere" / "a").open("a")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_read_only_folder_is_an_output_error(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(OutputError, match="could not write"):
        simulate(elastic_scene(), tmp_path / "out")


# ParaView


def test_a_frame_opens_in_other_programs(tmp_path, folded):
    body, last = folded.scene.body, folded.last
    (tmp_path / "f.vtu").write_bytes(Frames(folded.scene).content(last, folded.observe()))
    mesh = meshio.read(tmp_path / "f.vtu")
    (block,) = mesh.cells
    assert block.type == "triangle6"
    # VTK's order: corners, then the middles of 01, 12, 20; white matter has straight edges
    corners = mesh.points[block.data[:, :3]]
    middles = mesh.points[block.data[:, 3:]]
    expected = 0.5 * (corners + np.roll(corners, -1, axis=1))
    straight = mesh.cell_data["layer"][0] == 0
    inner = straight & (np.hypot(*corners.mean(1)[:, :2].T) < 0.8 * body.length)
    np.testing.assert_allclose(middles[inner], expected[inner], atol=1e-14)
    moves = mesh.point_data["displacement [m]"]
    assert moves.shape == (body.nodes.shape[1], 3)
    np.testing.assert_array_equal(moves[:, :2].T, last["displacement"])
    assert not moves[:, 2].any()
    assert {"von_mises [Pa]", "pressure [Pa]", "jacobian", "growth", "layer"} <= set(mesh.cell_data)
    assert mesh.field_data["TimeValue"] == [last.time]
    assert {"activator", "inhibitor", "pattern"} <= set(mesh.point_data)
    in_band = np.isfinite(mesh.point_data["pattern"])
    assert set(np.flatnonzero(in_band)) == set(body.cortex.nodes)


def test_the_cells_of_a_frame_are_as_vtk_wants_them(folded):
    """Plain lists of numbers: VTK's own reader, unlike meshio, refuses connectivity of six components."""
    grid = ElementTree.fromstring(Frames(folded.scene).content(folded.last, folded.observe()))
    (own,) = grid.iter("Cells")
    cells = {array.get("Name"): array for array in own}
    assert list(cells) == ["connectivity", "offsets", "types"]
    assert all(array.get("NumberOfComponents", "1") == "1" for array in cells.values())


def test_a_frame_has_the_whole_stress(folded, tmp_path):
    observed, file = folded.observe(), tmp_path / "f.vtu"
    file.write_bytes(Frames(folded.scene).content(folded.last, observed))
    found = arrays_of(file)
    stress = found["cauchy_stress"].reshape(-1, 3, 3)
    np.testing.assert_array_equal(stress, stress.transpose(0, 2, 1))
    assert not stress[:, 2, :2].any()
    scale = np.abs(stress).max()
    pressure = -np.trace(stress, axis1=1, axis2=2) / 3
    np.testing.assert_allclose(pressure, found["pressure"], atol=1e-12 * scale)
    for name, (i, j) in {"xx": (0, 0), "yy": (1, 1), "xy": (0, 1), "zz": (2, 2)}.items():
        np.testing.assert_array_equal(
            stress[:, i, j], in_cells(folded.scene.body, observed[f"stress_{name}"])
        )
    # it bears von Mises' stress at each point
    xx, yy, xy, zz = (observed[f"stress_{name}"] for name in ("xx", "yy", "xy", "zz"))
    mises = np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3 * xy**2)
    np.testing.assert_allclose(mises, observed["von_mises"], rtol=1e-9, atol=1e-9 * scale)


def test_frames_of_scenes_with_units_of_their_own_and_of_earlier_versions_have_no_units(tmp_path, folded):
    scene = elastic_scene()  # a radius of 1, a modulus of 1
    result = simulate(scene)
    (tmp_path / "own.vtu").write_bytes(Frames(scene).content(result.last, result.observe()))
    mesh = meshio.read(tmp_path / "own.vtu")
    assert "displacement" in mesh.point_data
    assert {"von_mises", "cauchy_stress"} <= set(mesh.cell_data)
    new, old = tmp_path / "new.vtu", tmp_path / "old.vtu"
    new.write_bytes(Frames(folded.scene).content(folded.last, folded.observe()))
    mesh_of(folded.scene.body, folded.last, folded.observe()).write(old)
    for name, values in arrays_of(old).items():
        np.testing.assert_array_equal(values, arrays_of(new)[name])


def test_cells_have_the_mean_of_their_area():
    body = elastic_scene().body
    x = body.quadrature.points[0]
    # the mean of x over a straight triangle is that of its corners
    straight = np.flatnonzero(~body.in_cortex)[-5:]
    corners = body.nodes[0][body.triangles[:3]].mean(0)
    np.testing.assert_allclose(in_cells(body, x)[straight], corners[straight], atol=1e-13)


def test_the_index_lists_frames_in_time():
    listed = [(1.0, "frames/000003.vtu"), (0.0, "frames/000000.vtu"), (1 / 3, "frames/000001.vtu")]
    assert entries(index(listed)) == sorted(listed)


# the folder of a result


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("finished") / "out"
    return folder, simulate(elastic_scene(), folder, frames=3)


def test_steps_given_as_numpy_numbers_leave_the_same_files(tmp_path):
    for name, kind in (("plain", float), ("numpy", np.float64)):
        stepping = Stepping(first=kind(0.5), largest=kind(0.5))
        simulate(elastic_scene(stepping=stepping, until=kind(1.0)), out=tmp_path / name, vtu=True)
    plain, other = tmp_path / "plain", tmp_path / "numpy"
    assert entries((other / "frames.pvd").read_bytes())[1][0] == 0.5
    for file in (plain / "frames.pvd", *plain.glob("frames/*.vtu")):
        assert (other / file.relative_to(plain)).read_bytes() == file.read_bytes(), file.name
    assert [state.time for state in load(other).states] == [0.0, 0.5, 1.0]
    assert [row["step"] for row in load(other).history] == [0.5, 0.5]


def test_a_stored_result_comes_back(finished):
    folder, result = finished
    found = load(folder)
    assert found.summary() == result.summary()
    assert [set(row) for row in found.history] == [set(row) | {"min_gap"} for row in result.history]
    for row, other in zip(found.history, result.history, strict=True):
        assert all(row[name] == other[name] for name in other)  # to the last bit
    # three frames evenly in time, and the start
    assert found.states[0].time == 0.0
    for state in found.states:
        (original,) = [s for s in result.states if s.time == state.time]
        assert same(state.fields, original.fields)
    assert len(found.states) == 4
    assert [t for t, _ in entries((folder / "frames.pvd").read_bytes())] == [s.time for s in found.states]
    assert len(list(folder.glob("checkpoint-*.npz"))) == 2


def test_the_history_has_units_in_its_file_and_none_in_its_rows(tmp_path):
    solid = Elastic(gray=NeoHookean(mu=500.0, kappa=2500.0))
    body, grow = semicircle(radius=0.04, thickness=0.01, size=0.01), TangentialGrowth(cortex=1.1)
    scene = Scene(body=body, terms=(solid,), processes=(grow,), stepping=Stepping(first=0.5, largest=0.5))
    result, file = simulate(scene, tmp_path / "out"), tmp_path / "out" / "history.csv"
    new = file.read_bytes()
    assert new.startswith(
        b"time,growth,energy [J/m],newton_iterations,factorizations,min_jacobian,min_gap [m]"
    )
    rows = [row | {"min_gap": 0.0} for row in result.history]  # there is no gap without contact
    assert [row | {"min_gap": 0.0} for row in load(tmp_path / "out").history] == rows
    old = History(file, run=Identity.at(tmp_path / "out").run)  # as earlier versions wrote it
    old.rows = read_history(tmp_path / "out")
    old.rewrite()
    old.close()
    assert file.read_bytes().startswith(b"time,growth,energy,newton")
    assert [row | {"min_gap": 0.0} for row in load(tmp_path / "out").history] == rows
    simulate(scene, tmp_path / "out", resume=True)
    assert file.read_bytes() == new
    simulate(elastic_scene(), tmp_path / "own")  # in units of its own
    assert b"[" not in (tmp_path / "own" / "history.csv").read_bytes()


def test_versions_and_seed_are_kept(finished):
    document = json.loads((finished[0] / "scene.json").read_text())
    assert document["versions"]["numpy"] == np.__version__
    made = datetime.fromisoformat(document["date"])
    assert timedelta(0) <= datetime.now(UTC) - made < timedelta(hours=1)
    assert document["scene"]["seed"] == 0


def test_a_finished_result_is_not_run_again(finished):
    folder, result = finished
    before = (folder / "history.csv").read_bytes()
    again = simulate(elastic_scene(), folder, resume=True)
    assert again.converged
    assert same(again.last.fields, result.last.fields)
    assert (folder / "history.csv").read_bytes() == before


@pytest.mark.parametrize("damage", ["cut short", "missing", "no frame"])
def test_going_on_restores_the_last_kept_state_from_the_checkpoint(tmp_path, damage):
    out = tmp_path / "out"
    simulate(elastic_scene(), out, frames=3)
    kept, frame = (sorted(out.glob(files))[-1] for files in ("states/*.npz", "frames/*.vtu"))
    content, shown, listed = kept.read_bytes(), frame.read_bytes(), (out / "frames.pvd").read_bytes()
    if damage == "cut short":
        kept.write_bytes(content[:-100])
    else:
        (kept if damage == "missing" else frame).unlink()
    assert simulate(elastic_scene(), out, resume=True, frames=3).converged
    assert kept.read_bytes() == content
    assert frame.read_bytes() == shown
    assert (out / "frames.pvd").read_bytes() == listed
    assert load(out).last.time == load(out).history[-1]["time"] == elastic_scene().until


def test_the_start_is_restored_as_well(tmp_path):
    out = tmp_path / "out"
    hopeless = elastic_scene(stepping=Stepping(first=0.1, largest=0.2, seconds=1e-9))
    with pytest.raises(StoppedError, match="time limit"):
        simulate(hopeless, out)
    (start,) = out.glob("states/*.npz")
    content = start.read_bytes()
    start.write_bytes(content[:50])
    with pytest.raises(StoppedError, match="time limit"):
        simulate(hopeless, out, resume=True)
    assert start.read_bytes() == content


def test_a_folder_with_another_result_is_refused(finished):
    folder, _ = finished
    with pytest.raises(ValueError, match=r"already holds this result.*resume"):
        simulate(elastic_scene(), folder)
    with pytest.raises(ValueError, match=r"another scene \(scene.until was 1.0 and is 0.5\)"):
        simulate(elastic_scene(until=0.5), folder)
    more = elastic_scene(stepping=replace(elastic_scene().stepping, iterations=99))
    told = r"another scene: scene\.stepping\.iterations was 60 and is 99\. .*--max-seconds.* iterations .*new"
    with pytest.raises(ValueError, match=told):
        simulate(more, folder, resume=True)
    with pytest.raises(ValueError, match=r"another scene: scene.until was 1.0 and is 0.5"):
        simulate(elastic_scene(until=0.5), folder, resume=True)


def test_overwriting_removes_what_was_there(tmp_path):
    simulate(elastic_scene(), tmp_path / "out", frames=50)
    (tmp_path / "out" / "notes.txt").write_text("mine")
    result = simulate(elastic_scene(until=0.5), tmp_path / "out", frames=1, overwrite=True)
    assert len(load(tmp_path / "out").states) == 2
    assert load(tmp_path / "out").last.time == result.last.time == 0.5
    assert (tmp_path / "out" / "notes.txt").read_text() == "mine"


def test_foreign_files_are_left_alone(tmp_path):
    (tmp_path / "thesis.tex").write_text("")
    with pytest.raises(ValueError, match="files that are no result"):
        simulate(elastic_scene(), tmp_path)
    with pytest.raises(ValueError, match="is a file"):
        simulate(elastic_scene(), tmp_path / "thesis.tex")
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]
    with pytest.raises(ValueError, match="no result"):
        load(tmp_path)


def test_a_body_of_another_scene_is_noticed(tmp_path):
    simulate(elastic_scene(), tmp_path / "out")
    write_whole(tmp_path / "out" / "body.npz", arrays_content({"x": np.zeros(3)}))
    with pytest.raises(CorruptFileError, match="does not belong"):
        load(tmp_path / "out")


# going on after an interruption

SCRIPT = """
import os, resource, signal, sys
sys.path.insert(0, {here!r})
import turingfold.results.simulate as runs
from small import folding_scene
runs.CHECKPOINT = 0.0
rows = []
def progress(row):
    rows.append(row)
    if len(rows) == {kill}:
        os.kill(os.getpid(), signal.SIGKILL)
    if len(rows) == {fill}:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))
runs.simulate(folding_scene(), {out!r}, progress=progress, resume={resume}, frames=4)
"""


def run(out, *, kill=-1, fill=-1, resume=False, status=0):
    """Run the scene in a process that is killed, or whose disk is full, after so many steps."""
    script = SCRIPT.format(here=str(HERE), kill=kill, fill=fill, out=str(out), resume=resume)
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, cwd=HERE.parent)
    assert done.returncode == status, done.stderr
    return done


def numbers(folder):
    return [{k: v for k, v in row.items() if k != "seconds"} for row in read_history(folder)]


def assert_same_result(folder, other):
    for file in sorted(other.glob("states/*.npz")):
        assert same(read_arrays(folder / "states" / file.name), read_arrays(file)), file.name
    assert len(list(folder.glob("states/*.npz"))) == len(list(other.glob("states/*.npz")))
    assert repr(numbers(folder)) == repr(numbers(other))
    assert (folder / "frames.pvd").read_bytes() == (other / "frames.pvd").read_bytes()


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole") / "out"
    simulate(folding_scene(), folder, frames=4)
    return folder


# contact acts from step 10 on
@pytest.mark.parametrize(
    "kill", [pytest.param(1, marks=pytest.mark.slow), pytest.param(6, marks=pytest.mark.slow), 11]
)
def test_a_killed_run_goes_on_to_the_last_bit(tmp_path, uninterrupted, kill):
    out = tmp_path / "out"
    run(out, kill=kill, status=-signal.SIGKILL)
    assert len(numbers(out)) == kill
    assert not (out / "summary.json").exists()
    simulate(folding_scene(), out, resume=True, frames=4)
    assert_same_result(out, uninterrupted)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_kills_at_any_moment_leave_no_trace(tmp_path, uninterrupted, seed):
    """Killed five times, wherever it is: between steps and while it writes; one that ends is begun anew."""
    out, rng, kills = tmp_path / "out", np.random.default_rng(seed), 0
    for _ in range(50):
        if kills == 5:
            break
        script = SCRIPT.format(here=str(HERE), kill=-1, fill=-1, out=str(out), resume=out.exists())
        process = subprocess.Popen([sys.executable, "-c", script], cwd=HERE.parent)
        rows = len(numbers(out)) if out.exists() else 0
        while process.poll() is None and len(numbers(out) if out.exists() else []) < rows + 1:
            time.sleep(0.005)
        try:
            process.wait(rng.uniform(0.0, 0.2))
        except subprocess.TimeoutExpired:
            process.kill()
        if process.wait() == -signal.SIGKILL:
            kills += 1
        else:
            assert process.returncode == 0
            assert_same_result(out, uninterrupted)
            shutil.rmtree(out)
    assert kills == 5
    if out.exists():
        run(out, resume=True)
        assert_same_result(out, uninterrupted)


def test_a_damaged_checkpoint_falls_back_to_the_older_one(tmp_path, uninterrupted, monkeypatch):
    monkeypatch.setattr("turingfold.results.simulate.CHECKPOINT", 0.0)
    out = tmp_path / "out"
    rows = []

    def interrupt(row):
        rows.append(row)
        if len(rows) == 11:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(folding_scene(), out, progress=interrupt, frames=4)
    older, newest = sorted(out.glob("checkpoint-*.npz"))
    newest.write_bytes(newest.read_bytes()[:-100])
    with pytest.warns(UserWarning, match=rf"{newest.name} is damaged.*older state"):
        result = simulate(folding_scene(), out, resume=True, frames=4)
    assert older.name == "checkpoint-000010.npz"
    assert result.converged
    assert_same_result(out, uninterrupted)


@pytest.mark.parametrize("damage", ["history", "checkpoints"])
def test_starting_over_leaves_nothing_of_the_earlier_run(tmp_path, damage):
    out = tmp_path / "out"
    first = simulate(elastic_scene(), out, frames=50)
    assert len(list(out.glob("states/*.npz"))) == len(first.states) > 3  # a frame per step
    if damage == "history":
        (out / "history.csv").write_text("time\n")
    else:
        for file in out.glob("checkpoint-*.npz"):
            file.write_bytes(b"")
    with pytest.warns(UserWarning, match=r"has lost the rows|is damaged"):
        simulate(elastic_scene(), out, resume=True, frames=1)
    assert len(load(out).states) == 2  # the start and the one frame
    assert len(list(out.glob("frames/*.vtu"))) == len(entries((out / "frames.pvd").read_bytes())) == 2
    assert load(out).converged


def test_going_on_removes_what_came_after_the_checkpoint(tmp_path):
    out = tmp_path / "out"
    simulate(elastic_scene(), out, frames=1)
    for stale in (out / "states" / "000999.npz", out / "frames" / "000999.vtu"):
        stale.write_bytes(b"of a step that was lost")
    simulate(elastic_scene(), out, resume=True, frames=1)
    assert not list(out.rglob("000999.*"))
    assert len(load(out).states) == 2


def test_a_full_disk_keeps_what_was_written(tmp_path, uninterrupted):
    out = tmp_path / "out"
    done = run(out, fill=11, status=1)
    assert "OutputError" in done.stderr
    assert "could not write" in done.stderr
    for file in out.rglob("*.npz"):
        read_arrays(file)
    assert not list(out.rglob("*.part"))
    assert len(numbers(out)) == 11
    simulate(folding_scene(), out, resume=True, frames=4)
    assert_same_result(out, uninterrupted)


def test_a_run_that_ran_out_of_time_goes_on_with_more(tmp_path):
    short = elastic_scene(stepping=Stepping(first=0.1, largest=0.2, seconds=1e-9))
    with pytest.raises(StoppedError, match="time limit"):
        simulate(short, tmp_path / "result")
    longer = elastic_scene(stepping=Stepping(first=0.1, largest=0.2, seconds=100.0))
    assert simulate(longer, tmp_path / "result", resume=True).converged
    other = elastic_scene(stepping=Stepping(first=0.1, largest=0.1))
    with pytest.raises(ValueError, match="another scene"):
        simulate(other, tmp_path / "result", resume=True)
