"""Blocks between fences of a Markdown file, for the tests that run what is written there."""

import re
from dataclasses import dataclass
from pathlib import Path

BLOCK = re.compile(r'^```(\w*)(?: title="([^"]+)")?\n(.*?)^```$', re.DOTALL | re.MULTILINE)


@dataclass(frozen=True)
class Fence:
    """language: of the block, "" for none.  title: of the file that the block is, "" for none."""

    language: str
    title: str
    text: str


def fences(page: Path) -> list[Fence]:
    """Return the blocks of a page in their order."""
    return [Fence(*found) for found in BLOCK.findall(page.read_text(encoding="utf-8"))]
