"""Write the page of all cases: picture, command, and the numbers of full-size runs.

    turingfold run figure3                 such a run, in results/figure3
    python .docs/gallery.py results        the page, with the numbers of every run in these folders

Numbers are kept in gallery.json beside this file. Runs with --quick or with other values, and those that did
not reach their end in every scene, are passed over.
"""

import json
import sys
from pathlib import Path

from turingfold.cli.case import Case, load_case

HERE = Path(__file__).parent
ROOT = HERE.parent
KEPT, PAGE = HERE / "gallery.json", HERE / "pages" / "gallery.md"
HEAD = """# Gallery

Every case that comes with the package; `turingfold list CASE` names its parameters. Numbers are of runs at
full size with default values: sulci, gyrification index against the convex hull, and registration with the
pattern, or where there is none how many times as large the area became. This page is written by
`python .docs/gallery.py results`.
"""
MOST = 20  # scenes of a case that have a row each
NONE = "No numbers: this case has not been run at full size for this page."


def main(folders: list[str]) -> None:
    """Read what is in the folders of results, and write the page."""
    kept = json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.is_file() else {}
    cases = [load_case(path) for path in sorted((ROOT / "cases").glob("*.py"))]
    for case in cases:
        for folder in folders:
            if found := measured(Path(folder) / case.name):
                kept[case.name] = found
    KEPT.write_text(json.dumps(kept, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    entries = [entry(case, kept.get(case.name)) for case in cases]
    PAGE.write_text("\n".join([HEAD, *entries]), encoding="utf-8")


def measured(folder: Path) -> dict[str, list[str]]:
    """Return the numbers of a case's scenes in words; none where its results are not of a run as it comes."""
    found: dict[str, list[str]] = {}
    missing: set[str] = set()
    for file in sorted(folder.glob("*/summary.json")):
        case = json.loads(file.with_name("scene.json").read_text(encoding="utf-8"))["case"]
        summary = json.loads(file.read_text(encoding="utf-8"))
        if case["quick"] or case["changed"] or summary["status"] != "converged":
            return {}
        found[case["scene"]] = numbers(summary)
        missing = set(case["scenes"]) - found.keys()
    if missing:
        return {}
    return found if len(found) <= MOST else {f"{len(found)} scenes": ranges(list(found.values()))}


def ranges(rows: list[list[str]]) -> list[str]:
    """Return the least and the largest number of each column, words apart."""
    found = []
    for column in zip(*rows, strict=True):
        split = [text.rpartition(" ")[::2] for text in column]
        words, numbers = {word for word, _ in split}, sorted((number for _, number in split), key=float)
        text = numbers[0] if numbers[0] == numbers[-1] else f"{numbers[0]} to {numbers[-1]}"
        found.append(f"{words.pop()} {text}".strip() if len(words) == 1 else "")
    return found


def numbers(summary: dict[str, float | None]) -> list[str]:
    """Return sulci, gyrification index, and registration or growth of area."""
    registered = summary["registration"]
    last = f"area {summary['area_growth']:.2f}" if registered is None else f"registration {registered:+.2f}"
    return [f"{summary['folds']:.0f}", f"{summary['gyrification_index']:.2f}", last]


def entry(case: Case, found: dict[str, list[str]] | None) -> str:
    """Return what the page says of a case."""
    text = f"## {case.name}\n\n{case.title}\n\n```\nturingfold run {case.name}\n```\n"
    if (ROOT / "figures" / f"{case.name}.png").is_file():
        text += f"\n[![{case.name}](../../figures/{case.name}.png)](../../cases/{case.name}.py)\n"
    if found is None:
        return f"{text}\n{NONE}\n"
    rows = [f"| {scene} | {' | '.join(words)} |" for scene, words in found.items()]
    return "\n".join([text, "| scene | sulci | index | |", "|---|---|---|---|", *rows, ""])


if __name__ == "__main__":
    main(sys.argv[1:])
