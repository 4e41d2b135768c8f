"""Damaged, edited, foreign and shared folders: an error that names the file, or a good run."""

import itertools
import json
import os
import random
import re
import shutil
import subprocess
import sys
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from small import elastic_scene
from test_endings import HURRIED, killed

import turingfold
from turingfold import (
    CorruptFileError,
    OutputError,
    UnfinishedWarning,
    UserKinetics,
    load,
    semicircle,
    simulate,
)
from turingfold.results.codec import decode, encode
from turingfold.results.document import rebuilt, stored
from turingfold.results.files import arrays_content, json_content, read_arrays
from turingfold.results.history import COLUMNS, History, read_history, sound_rows
from turingfold.results.identity import Identity
from turingfold.results.lock import FolderLock, writer


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("damage") / "out"
    simulate(elastic_scene(stepping=HURRIED), folder, frames=4)
    return folder


@pytest.fixture
def out(finished, tmp_path):
    """Return a copy of a finished result."""
    return Path(shutil.copytree(finished, tmp_path / "out"))


# checksums


def test_a_changed_number_of_the_scene_is_noticed(out):
    file = out / "scene.json"
    text = file.read_text()
    assert '"cortex": 1.3' in text
    file.write_text(text.replace('"cortex": 1.3', '"cortex": 1.6'))
    for use in (lambda: load(out), lambda: simulate(elastic_scene(stepping=HURRIED), out, resume=True)):
        with pytest.raises(CorruptFileError, match=r"scene\.json was changed after it was written"):
            use()


def test_scene_json_may_be_laid_out_anew(out):
    file = out / "scene.json"
    file.write_text(json.dumps(json.loads(file.read_text()), sort_keys=True))
    assert load(out).converged


def test_each_changed_digit_of_the_history_is_noticed(finished):
    content = (finished / "history.csv").read_bytes()
    rows, damage = sound_rows(content)
    assert not damage
    assert len(rows) == 10
    for at in range(content.index(b"\n"), len(content)):
        if content[at : at + 1].isdigit():
            changed = bytearray(content)
            changed[at] = 48 + (changed[at] - 48 + 1) % 10
            line = content[:at].count(b"\n") + 1
            assert sound_rows(bytes(changed))[1].startswith(f"line {line} ")


def test_load_names_the_line_of_the_history(out):
    file = out / "history.csv"
    file.write_text(re.sub(r"(?m)^0\.5", "0.4", file.read_text(), count=1))
    with pytest.raises(CorruptFileError, match=r"history\.csv: line \d+ was changed"):
        load(out)


def test_rows_that_are_gone_are_noticed(out):
    file = out / "history.csv"
    file.write_text("".join(file.read_text().splitlines(keepends=True)[:-1]))
    with pytest.raises(CorruptFileError, match="the history that leads to it is missing"):
        load(out)


def test_rows_with_other_columns_are_signed_as_well(tmp_path):
    history = History(tmp_path / "history.csv")
    rows = [{"time": 0.1}, {"time": 0.2, "work": 1 / 3}, {"time": 0.3, "work": -1e-300}]
    for row in rows:
        history.add(row)
    history.close()
    found = read_history(tmp_path)
    assert [{k: v for k, v in row.items() if not np.isnan(v)} for row in found] == rows
    assert set(found[0]) == {*COLUMNS, "work"}


# files of another run, and of earlier versions


@pytest.fixture(scope="module")
def another(tmp_path_factory):
    """Return the folder of a run of the same body that grows more."""
    folder = tmp_path_factory.mktemp("another") / "out"
    scene = elastic_scene(stepping=HURRIED)
    (grow,) = scene.processes
    simulate(replace(scene, processes=(replace(grow, cortex=1.6),)), folder, frames=4)
    return folder


OTHERS = ("history.csv", "summary.json", "scene.json")


@pytest.mark.parametrize("name", OTHERS)
def test_a_file_of_another_run_is_refused_by_its_name(out, another, name):
    shutil.copy(another / name, out / name)
    with pytest.raises(CorruptFileError, match=r"does not belong to the scene\.json beside it") as caught:
        load(out)
    assert str(out / name) in str(caught.value) or name == "scene.json"
    assert "overwrite" in str(caught.value)


@pytest.mark.parametrize("name", ["states/000005.npz", "states/000010.npz"])
def test_a_state_of_another_run_is_left_out(finished, out, another, name):
    shutil.copy(another / name, out / name)
    with pytest.warns(UserWarning, match=rf"{name} does not belong to the scene.json beside it"):
        found = load(out)
    whole = load(finished)
    np.testing.assert_array_equal(found.last["displacement"], whole.last["displacement"])
    assert found.summary() == whole.summary()  # the last one is in the checkpoint, too


def exchange(one, other):
    one_is, other_is = one.read_bytes(), other.read_bytes()
    one.write_bytes(other_is)
    other.write_bytes(one_is)


def test_states_of_one_run_that_were_exchanged_are_left_out(finished, out):
    """Each is known by its time, which the history has of its step."""
    whole = load(finished)
    names = [f"states/{step:06d}.npz" for step in (3, 8)]
    exchange(*(out / name for name in names))
    with pytest.warns(UserWarning, match="a file of another step") as told:
        found = load(out)
    times = [whole.history[step - 1]["time"] for step in (3, 8)]
    for name, time, other in zip(names, times, times[::-1], strict=True):
        message = rf"{name} holds the state of t = {other:g}, but by history\.csv .* ended at t = {time:g}"
        assert sum(bool(re.search(message, str(each.message))) for each in told) == 1
    assert [s.time for s in found.states] == [s.time for s in whole.states if s.time not in times]
    for state in found.states:
        kept = next(s for s in whole.states if s.time == state.time)
        np.testing.assert_array_equal(state["displacement"], kept["displacement"])


@pytest.mark.parametrize(
    ("name", "copy"),
    [
        ("states/000001.npz", "states/000001 (copy).npz"),
        ("states/000010.npz", "states/last.npz"),
        ("checkpoint-000010.npz", "checkpoint-old.npz"),
    ],
)
def test_a_copy_of_a_state_under_another_name_is_left_out(finished, out, name, copy):
    own = out / name
    shutil.copy(own if own.exists() else sorted(out.glob("states/*.npz"))[0], out / copy)
    with pytest.warns(UserWarning, match="is not named by its step") as told:
        found = load(out)
    assert [str(out / copy) in str(each.message) for each in told] == [True]
    whole = load(finished)
    assert [s.time for s in found.states] == [s.time for s in whole.states]
    assert found.summary() == whole.summary()


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_a_last_state_that_is_of_another_step_is_made_anew(finished, out):
    first, *_, last = sorted(out.glob("states/*.npz"))
    shutil.copy(first, last)
    older, newer = sorted(out.glob("checkpoint-*.npz"))
    exchange(older, newer)
    with pytest.raises(CorruptFileError, match=r"the last state, of t = 1, .* is missing or damaged"):
        load(out)
    assert simulate(elastic_scene(stepping=HURRIED), out, resume=True, frames=4).converged
    assert load(out).summary()["energy"] == load(finished).summary()["energy"]


@pytest.mark.parametrize("name", ["frames.pvd", "frames/000005.vtu"])
def test_a_frame_of_another_run_is_told_of(out, another, name):
    shutil.copy(another / name, out / name)
    with pytest.warns(UserWarning, match=rf"{name} does not belong to the scene.json beside it"):
        found = load(out)
    assert found.last.time == 1.0  # the states are its own


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize(
    "name",
    ["history.csv", "summary.json", "states/000010.npz", "frames.pvd", "frames/000005.vtu", "checkpoints"],
)
def test_going_on_makes_anew_what_is_of_another_run(finished, out, another, name):
    names = [file.name for file in another.glob("checkpoint-*.npz")] if name == "checkpoints" else [name]
    for one in names:
        shutil.copy(another / one, out / one)
    assert simulate(elastic_scene(stepping=HURRIED), out, resume=True, frames=4).converged
    for file in (finished / "frames.pvd", *finished.glob("states/*"), *finished.glob("frames/*")):
        assert (out / file.relative_to(finished)).read_bytes() == file.read_bytes(), file.name
    assert load(out).last.time == 1.0
    assert repr(numbers(out)) == repr(numbers(finished))


def numbers(folder):
    return [{name: value for name, value in row.items() if name != "seconds"} for row in read_history(folder)]


def test_going_on_refuses_a_scene_of_another_run_and_leaves_its_files(out, another):
    shutil.copy(another / "scene.json", out / "scene.json")
    before = {file: file.read_bytes() for file in out.rglob("*") if file.is_file()}
    with pytest.raises(ValueError, match="holds the result of another scene"):
        simulate(elastic_scene(stepping=HURRIED), out, resume=True)
    with pytest.raises(
        CorruptFileError, match=r"scene\.json is of another run than the files beside it.*--over"
    ):
        simulate(load(another).scene, out, resume=True)
    assert before == {file: file.read_bytes() for file in out.rglob("*") if file.is_file()}


@pytest.mark.parametrize("name", ["status", "energy", "errors"])
def test_a_summary_that_was_edited_is_refused_until_it_is_made_anew(finished, out, name):
    file = out / "summary.json"
    edited = json.loads(file.read_text()) | {name: {"status": "invalid", "energy": 0.5}.get(name, {})}
    file.write_text(json.dumps(edited))
    with pytest.raises(CorruptFileError, match=r"summary\.json was changed after it was written.*--resume"):
        load(out)
    simulate(elastic_scene(stepping=HURRIED), out, resume=True, frames=4)
    assert load(out).summary()["energy"] == load(finished).summary()["energy"]


def test_what_a_run_may_change_when_it_goes_on_is_not_its_identity(finished, another):
    document, _ = stored(elastic_scene(stepping=HURRIED))
    run = Identity.of(document)
    assert run.run == json.loads((finished / "scene.json").read_text())["run"] == Identity.at(finished).run
    patient, _ = stored(elastic_scene(stepping=replace(HURRIED, seconds=9.0)), {"command": "run"})
    assert Identity.of(patient | {"date": "today", "versions": {}}) == run
    later, _ = stored(elastic_scene(stepping=replace(HURRIED, first=0.05)))
    assert len({run.run, Identity.of(later).run, Identity.at(another).run}) == 3


def of_an_earlier_version(folder):
    """Take out of the files of a folder what says of which run they are."""
    for file in [*folder.glob("states/*.npz"), *folder.glob("checkpoint-*.npz")]:
        arrays = read_arrays(file)
        del arrays[".run"]
        file.write_bytes(arrays_content(arrays))
    history = History(folder / "history.csv")
    history.rows = read_history(folder)
    history.rewrite()
    history.close()
    for name, signed in (("scene.json", True), ("summary.json", False)):
        table = json.loads((folder / name).read_text())
        del table["run"], table["sha256"]
        (folder / name).write_bytes(json_content(table, signed=signed))
    for file in [folder / "frames.pvd", *folder.glob("frames/*.vtu")]:
        file.write_bytes(re.sub(rb"<!-- run \w+ -->\n", b"", file.read_bytes(), count=1))


def test_a_result_of_an_earlier_version_is_read_and_gone_on_with(finished, out, another):
    of_an_earlier_version(out)
    assert load(out).summary() == load(finished).summary()
    assert simulate(elastic_scene(stepping=HURRIED), out, resume=True, frames=4).converged
    assert load(out).summary()["energy"] == load(finished).summary()["energy"]
    shutil.copy(another / "history.csv", out / "history.csv")  # which says that it is of another run
    with pytest.raises(CorruptFileError, match=r"history\.csv does not belong"):
        load(out)


def test_a_file_of_an_earlier_version_belongs_to_no_run_of_this_one(finished, out, another, tmp_path):
    old = Path(shutil.copytree(another, tmp_path / "old"))
    of_an_earlier_version(old)
    shutil.copy(old / "history.csv", out / "history.csv")
    with pytest.raises(CorruptFileError, match=r"history\.csv does not belong .* it names no run"):
        load(out)


# a scene.json that was made to deceive


def test_only_functions_that_the_caller_names_are_found():
    kinetics = json.loads(json.dumps(encode(UserKinetics(p=rate_p, q=rate_q, guesses=((1.0, 0.9),)), {})))
    assert decode(kinetics, {}, known=[rate_p, rate_q]).p is rate_p
    for path in ("turingfold.results.files.write_whole", "turingfold.simulate", "os.system"):
        with pytest.raises(ValueError, match=f"scene.p: the stored scene uses {path}, which is no"):
            decode({**kinetics, "p": {"function": path}}, {}, known=[rate_q])


def rate_p(u, v):
    return 0.1 - u + u * u * v


def rate_q(u, v):
    return 0.9 - u * u * v


def test_parts_are_stored_by_their_public_names():
    document, _ = stored(elastic_scene())
    names = set(re.findall(r'"class": "([^"]+)"', json.dumps(document)))
    assert {"turingfold.Scene", "turingfold.Elastic", "turingfold.NeoHookean", "turingfold.Body"} <= names
    for name in names:
        assert name.removeprefix("turingfold.") in turingfold.__all__


def mutated(value, chance):
    """Return JSON with one of its values or keys replaced."""
    places = []

    def visit(item):
        for key in list(item) if isinstance(item, dict) else range(len(item)):
            places.append((item, key))
            if isinstance(item[key], (dict, list)):
                visit(item[key])

    visit(value)
    item, key = chance.choice(places)
    deep = []
    for _ in range(2000):
        deep = [deep]
    other = [
        None, True, -1, 0, 1e400, -1e300, float("nan"), "", "inf", [], {}, deep, [1.0, [2]], 10**400,
        {"array": "scene.body.mesh.nodes"}, {"array": 3}, {"float": "x"}, {"mesh": {}}, {"class": 7},
        {"function": "os.system"}, {"class": "turingfold.Scene"}, {"class": "turingfold.SelfContact"},
    ]  # fmt: skip
    if isinstance(item, dict) and chance.random() < 0.2:
        item[chance.choice(["class", "cortex", "x", ""])] = item.pop(key)
    else:
        item[key] = chance.choice(other)
    return value


def test_no_stored_scene_ends_in_another_error():
    body = semicircle(radius=1.0, thickness=0.4, size=0.5)
    document, arrays = stored(elastic_scene(body=body))
    text, chance, refused = json.dumps(document), random.Random(1), 0
    made = 0
    for _ in range(300):
        changed = mutated(json.loads(text), chance)
        try:
            rebuilt(changed, arrays)
        except ValueError as error:  # CorruptFileError is one
            refused += "scene" in str(error) or "it describes no scene" in str(error)
        else:
            made += 1
    assert refused + made == 300
    assert refused > 150


def test_a_mutated_file_is_refused_by_its_name(out):
    file, chance = out / "scene.json", random.Random(2)
    content = file.read_bytes()
    for _ in range(60):
        at = chance.randrange(len(content))
        changed = content[:at] + bytes([chance.randrange(256)]) + content[at + chance.choice((0, 1, 9)) :]
        file.write_bytes(changed)
        try:
            same = json.loads(changed) == json.loads(content)  # white space may change
        except ValueError:
            same = False
        if not same:
            with pytest.raises(ValueError, match=re.escape(str(out))):
                load(out)
    file.write_bytes(b'{"format": 3, "scene": ' + b"[" * 100_000 + b"]" * 100_000 + b"}")
    with pytest.raises(CorruptFileError, match=r"scene\.json is not JSON"):
        load(out)


@pytest.mark.parametrize(("number", "wrote"), [(1, "0.1.0"), (2, "0.1.0"), (4, "1.0")])
def test_results_of_other_versions_are_refused_with_the_version_that_wrote_them(out, number, wrote):
    document, _ = stored(elastic_scene())
    old = {**document, "format": number, "versions": {"turingfold": wrote}}
    (out / "scene.json").write_bytes(json_content(old, signed=False))
    with pytest.raises(ValueError, match=f"has format {number}, written by turingfold {wrote}, .* format 3"):
        load(out)


# damaged files


MADE_ANEW = ("body.npz", "history.csv", "summary.json", "frames.pvd")
WHOLE = ("scene.json", "body.npz", "history.csv", "summary.json")
DAMAGE = {
    "missing": lambda file: file.unlink(),
    "empty": lambda file: file.write_bytes(b""),
    "a folder": lambda file: (file.unlink(), file.mkdir()),
    "binary": lambda file: file.write_bytes(bytes(range(256))),
    "cut short": lambda file: file.write_bytes(file.read_bytes()[: file.stat().st_size // 2]),
}


@pytest.mark.parametrize("how", DAMAGE)
@pytest.mark.parametrize("name", WHOLE)
def test_damage_is_said_to_be_where_it_is(out, name, how):
    DAMAGE[how](out / name)
    if name == "summary.json" and how == "missing":  # as if it had been killed
        with pytest.warns(UnfinishedWarning):
            load(out)
        return
    with pytest.raises(ValueError, match=re.escape(str(out))) as caught:
        load(out)
    assert isinstance(caught.value, CorruptFileError) or (name, how) == ("scene.json", "missing")


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize(
    ("name", "how"),
    [
        *itertools.product(MADE_ANEW, ("missing", "binary", "cut short")),
        ("frames/000003.vtu", "missing"),
    ],
)
def test_going_on_makes_anew_what_was_damaged(finished, out, name, how):
    (file,) = out.glob(name)
    DAMAGE[how](file)
    assert simulate(elastic_scene(stepping=HURRIED), out, resume=True, frames=4).converged
    found, whole = load(out), load(finished)
    assert [state.time for state in found.states] == [state.time for state in whole.states]
    np.testing.assert_array_equal(found.last["displacement"], whole.last["displacement"])
    if name.startswith("frames") or name == "body.npz":
        assert file.read_bytes() == (finished / name).read_bytes()


def test_a_last_state_that_is_lost_is_not_passed_over(out):
    for file in [*sorted(out.glob("states/*.npz"))[-1:], *out.glob("checkpoint-*.npz")]:
        file.unlink()
    with pytest.raises(CorruptFileError, match=r"the last state, of t = 1, .* is missing"):
        load(out)


# two at one folder


HOLDS = """
import sys
from pathlib import Path
from turingfold.results.lock import FolderLock
FolderLock(Path(sys.argv[1]))
print("held", flush=True)
sys.stdin.read()
"""


def test_a_folder_has_one_writer_and_says_who_it_is(tmp_path):
    rows = killed(tmp_path / "out")
    process = subprocess.Popen(
        [sys.executable, "-c", HOLDS, str(tmp_path / "out")], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert process.stdout.readline() == b"held\n"
    scene, before = elastic_scene(stepping=HURRIED), sorted((tmp_path / "out").rglob("*"))
    for options in ({"resume": True}, {"overwrite": True}):
        with pytest.raises(ValueError, match=rf"out is being written by process {process.pid} on "):
            simulate(scene, tmp_path / "out", **options)
    assert sorted((tmp_path / "out").rglob("*")) == before
    with pytest.warns(UnfinishedWarning, match=rf"running at t = 0\.5 of 1\. .*process {process.pid}"):
        assert load(tmp_path / "out").last.time == rows[4]["time"]
    process.kill()
    process.communicate()
    assert writer(tmp_path / "out") == ""  # the lock died with it, though its file is there
    assert (tmp_path / "out" / ".lock").exists()
    assert simulate(scene, tmp_path / "out", resume=True).converged
    assert not (tmp_path / "out" / ".lock").exists()


def test_a_second_run_in_the_same_process_is_refused_too(tmp_path):
    lock = FolderLock(tmp_path)
    with pytest.raises(ValueError, match=f"is being written by process {os.getpid()}"):
        FolderLock(tmp_path)
    lock.release()
    FolderLock(tmp_path).release()
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("how", ["moved", "removed", "replaced"])
def test_a_folder_that_goes_away_during_a_run_is_not_made_anew(tmp_path, how):
    out, rows = tmp_path / "out", []

    def take_away(row):
        rows.append(row)
        if len(rows) == 2:
            out.rename(tmp_path / "elsewhere") if how != "removed" else shutil.rmtree(out)
            if how == "replaced":
                out.mkdir()

    with pytest.raises(OutputError, match=r"could not write .*out.*moved or removed"):
        simulate(elastic_scene(stepping=HURRIED), out, progress=take_away)
    assert len(rows) == 2
    assert not list(out.iterdir()) if how == "replaced" else not out.exists()


# links


def test_a_link_in_the_place_of_a_file_is_not_followed(tmp_path):
    killed(tmp_path / "out")
    mine = tmp_path / "thesis.tex"
    mine.write_text("mine")
    for name in ("summary.json", ".summary.json.part", "history.csv", "frames.pvd", "checkpoint-000005.npz"):
        (tmp_path / "out" / name).unlink(missing_ok=True)
        (tmp_path / "out" / name).symlink_to(mine)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert simulate(elastic_scene(stepping=HURRIED), tmp_path / "out", resume=True).converged
    assert mine.read_text() == "mine"
    assert not (tmp_path / "out" / "summary.json").is_symlink()


@pytest.mark.parametrize("name", ["states", "frames"])
def test_a_linked_subfolder_is_neither_written_nor_cleared(tmp_path, name):
    killed(tmp_path / "out")
    theirs = tmp_path / "theirs"
    (tmp_path / "out" / name).rename(theirs)
    (theirs / "000999.npz").write_text("theirs")
    before = {file: file.read_bytes() for file in theirs.iterdir()}
    (tmp_path / "out" / name).symlink_to(theirs, target_is_directory=True)
    for options in ({"resume": True}, {"overwrite": True}):
        with pytest.raises(OutputError, match=f"{name}: it is a link. .* nothing is written through"):
            simulate(elastic_scene(stepping=HURRIED), tmp_path / "out", **options)
    assert {file: file.read_bytes() for file in theirs.iterdir()} == before


def test_results_may_lie_behind_a_link(tmp_path):
    (tmp_path / "disk").mkdir()
    (tmp_path / "out").symlink_to(tmp_path / "disk", target_is_directory=True)
    assert simulate(elastic_scene(), tmp_path / "out").converged
    assert load(tmp_path / "disk").converged


def test_what_a_killed_process_was_writing_is_swept_away(tmp_path):
    killed(tmp_path / "out")
    for left in (".0123.part", "states/.0123.part"):
        (tmp_path / "out" / left).write_bytes(b"half")
    simulate(elastic_scene(stepping=HURRIED), tmp_path / "out", resume=True)
    assert not list((tmp_path / "out").rglob("*.part"))
