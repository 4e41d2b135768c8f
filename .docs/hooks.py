"""What the site has beyond the pages: files of the project that they link to, and the public names."""

import ast
import re
from itertools import groupby
from pathlib import Path

from mkdocs.structure.files import File

ROOT = Path(__file__).parents[1]
OUTSIDE = "](../../"  # how a page links to a file of the project
PUBLIC = "::: turingfold"  # where the reference shows the public names


def on_files(files, config):
    """Add the files of the project that pages link to."""
    text = "".join(page.content_string for page in files.documentation_pages())
    for path in sorted(set(re.findall(re.escape(OUTSIDE) + r"([^)#]+)", text))):
        files.append(File.generated(config, path, abs_src_path=str(ROOT / path)))
    return files


def on_page_markdown(markdown, **_):
    """Return a page with links to those files, and the public names where it asks for them."""
    lines = markdown.replace(OUTSIDE, "](").splitlines()
    return "\n".join(public() if line == PUBLIC else line for line in lines)


def public():
    """Return the public names of the package by the room that they come from."""
    stub = ast.parse((ROOT / "turingfold" / "__init__.pyi").read_text(encoding="utf-8"))
    lines = [node for node in stub.body if isinstance(node, ast.ImportFrom) and node.module]
    found = []
    for room, nodes in groupby(sorted(lines, key=room_of), key=room_of):
        names = sorted(alias.name for node in nodes for alias in node.names)
        found += [f"## {room}", *(f"::: turingfold.{name}" for name in names)]
    return "\n\n".join(found)


def room_of(node):
    """Return the room that an import comes from."""
    return node.module.partition(".")[0]
