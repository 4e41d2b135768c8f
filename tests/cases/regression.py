"""The numbers of every case's scenes at quick size, kept in regression.csv, and how far they may move.

    python tests/cases/regression.py              runs the cases and prints what differs
    python tests/cases/regression.py --renew      writes down what came out as well
    python tests/cases/regression.py figure3      of some cases only
    python tests/cases/regression.py --from DIR   reads results that turingfold run --quick --out DIR left

Nothing here says that a number is right; that is for the other tests. It says that a change of the program
moved it, by how much, and where.
"""

import argparse
import csv
import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from turingfold.cli.case import folder_name, load_case
from turingfold.cli.main import main as turingfold

STORE = Path(__file__).with_name("regression.csv")
CASES = {path.stem: path for path in sorted((Path(__file__).parents[2] / "cases").glob("*.py"))}
RENEW = "python tests/cases/regression.py --renew"

EXACT = ("status", "folds")
COUNTS = ("steps", "newton_iterations", "factorizations")
NUMBERS = ("perimeter", "energy", "gyrification_index")
COLUMNS = ("case", "scene", "hangs_on", *EXACT, *COUNTS, *NUMBERS)

# what a scene's numbers hang on, beside the physics: relative tolerances of NUMBERS, of folds and of COUNTS;
# iterations follow rounding everywhere
TOLERANCES = {
    "nothing": (1e-6, 0.0, 0.3),  # one equilibrium, to the residual of the solver
    "mesh": (1e-2, 0.0, 0.3),  # a real outline, whose mesh is made by choices that rounding may turn
    # rounding decides with which steps, and so with which chords of walls, the same folds are come to: up to
    # 3.2e-4 and twice the iterations were seen, on two processors and with OpenBLAS told of two others
    "path": (1e-3, 0.0, 1.5),
    "branch": (0.1, 0.3, 1.5),  # rounding decides which of several equilibria, that differ, the body snaps to
}
NONE = "none"
ROUND_OFF = 1e-12  # of NUMBERS in their units: the energy of a body at rest is not quite none
FEW = 5  # difference of COUNTS that is allowed in any case

Row = dict[str, str]


def as_row(case, scene, summary, hangs_on="nothing"):
    """Return the row of a scene, from its summary."""
    found = {"case": case, "scene": scene, "hangs_on": hangs_on}
    found |= {name: str(summary[name]) for name in (*EXACT, *COUNTS)}
    return found | {name: NONE if summary[name] is None else f"{summary[name]:.10g}" for name in NUMBERS}


def stored(store=STORE):
    """Return the stored rows, by case and scene."""
    if not store.exists():
        return {}
    with store.open(encoding="utf-8", newline="") as file:
        return {(row["case"], row["scene"]): row for row in csv.DictReader(file)}


def differences(case, summaries, store=STORE):
    """Return a line for each number of a case's scenes that is not the stored one within its tolerance."""
    known = {scene: row for (name, scene), row in stored(store).items() if name == case}
    lines = [f"{case}, {scene}: has no row; {RENEW} {case}" for scene in summaries if scene not in known]
    lines += [f"{case}, {scene}: is no scene any more; {RENEW} {case}" for scene in known.keys() - summaries]
    for scene in known.keys() & summaries:
        before, now = known[scene], as_row(case, scene, summaries[scene])
        changes = [change for name in before if (change := _change(name, before, now))]
        lines += [f"{case}, {scene}: {'; '.join(changes)}"] if changes else []
    return lines


def _change(name, before, now):
    """Return in words how a number differs from the stored one, or nothing where it is near enough."""
    old, new = before[name], now[name]
    if name in ("case", "scene", "hangs_on") or old == new:
        return ""
    relative, folds, work = TOLERANCES[before["hangs_on"]]
    if name == "status" or NONE in (old, new):
        return f"{name} {old} -> {new}"
    off = abs(float(new) - float(old))
    allowed = {"folds": folds}.get(name, work if name in COUNTS else relative) * abs(float(old))
    if off <= max(allowed, FEW if name in COUNTS else ROUND_OFF):
        return ""
    share = f" ({100 * (float(new) / float(old) - 1):+.2g} %)" if float(old) else ""
    return f"{name} {old} -> {new}{share}, allowed {allowed:.2g}"


def renew(case, summaries, store=STORE):
    """Write the rows of a case anew, and leave those of others; what a known scene hangs on stays."""
    rows = stored(store)
    kept = {key: row for key, row in rows.items() if key[0] != case}
    for scene, summary in summaries.items():
        old = rows.get((case, scene), {"hangs_on": "nothing"})
        kept[case, scene] = as_row(case, scene, summary, old["hangs_on"])
    with store.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(row for _, row in sorted(kept.items(), key=lambda item: item[0][0]))


def summaries_in(out, case):
    """Return the summaries of a case's scenes, as turingfold run --quick --out stored them."""
    names = load_case(CASES[case]).scenes({}, quick=True)
    files = {name: out / case / folder_name(name) / "summary.json" for name in names}
    return {name: json.loads(file.read_text(encoding="utf-8")) for name, file in files.items()}


def _has_data(case):
    folder = getattr(load_case(CASES[case]).module, "FOLDER", STORE.parent)
    return folder.is_dir()


def main(words=None):
    """Run cases at quick size, print what differs from the store, and renew it if asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", metavar="CASE", default=[], help="names; all without any")
    parser.add_argument("--renew", action="store_true", help="write down what came out")
    parser.add_argument("--from", dest="folder", type=Path, help="a folder with results of quick runs")
    given = parser.parse_args(words)
    if unknown := set(given.cases) - CASES.keys():
        parser.error(f"there is no case {', '.join(sorted(unknown))}; there are {', '.join(CASES)}")
    found = []
    for case in given.cases or CASES:
        if not _has_data(case):
            print(f"{case}: left out, its data are not there")
            continue
        with TemporaryDirectory() as own:
            out = given.folder or Path(own)
            if given.folder is None:
                turingfold(["run", str(CASES[case]), "--quick", "--no-errors", "--out", own])
            summaries = summaries_in(out, case)
        found += (lines := differences(case, summaries))
        print("\n".join(lines) or f"{case}: as stored", flush=True)
        if given.renew:
            renew(case, summaries)
    return 1 if found and not given.renew else 0


if __name__ == "__main__":
    sys.exit(main())
