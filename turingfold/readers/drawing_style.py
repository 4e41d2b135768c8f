"""What the elements of a drawing declare: by attributes, in style="...", and in the rules of style sheets."""

from __future__ import annotations

import re
from dataclasses import dataclass
from xml.etree.ElementTree import Element

SPACE = "{http://www.w3.org/2000/svg}"
PLACES = ("x", "y", "width", "height", "cx", "cy", "r", "rx", "ry")
CUTS = ("clip-path", "mask", "mask-image")  # of which only a part of a shape is shown
READ = ("display", "visibility", "transform", "transform-origin", "transform-box", "overflow", *PLACES, *CUTS)
NOT_READ = ("d", "rotate", "scale", "translate", "offset-path", "zoom")  # properties that move shapes, too
COMMENT = re.compile(r"/\*.*?\*/|<!--|-->|@(?:import|charset|namespace)[^;]*;", re.DOTALL)
RULE = re.compile(r"([^{}]*)\{([^{}]*)\}")
CONDITIONAL = re.compile(r"@(media|supports|layer|container|scope)", re.IGNORECASE)
SIMPLE = re.compile(r"(\*|[\w-]+)?((?:[.#][\w-]+)*)")

Declarations = tuple[tuple[str, str, bool], ...]


@dataclass(frozen=True)
class Rule:
    """Declarations for elements of a kind ("" for all) that have all of these ids and classes."""

    kind: str
    ids: frozenset[str]
    classes: frozenset[str]
    declarations: Declarations

    @property
    def weight(self) -> tuple[int, int, int]:
        """By which it outdoes other rules."""
        return len(self.ids), len(self.classes), bool(self.kind)

    def holds_for(self, element: Element) -> bool:
        """Return whether the element is of the kind, with the ids and classes."""
        return (
            self.kind in ("", kind_of(element))
            and self.ids <= {element.get("id", "")}
            and self.classes <= set(element.get("class", "").split())
        )


def kind_of(element: Element) -> str:
    """Return the name of an element of SVG, "" for those of other languages."""
    name = str(element.tag).removeprefix(SPACE)
    return "" if name.startswith("{") else name


def rules_of(root: Element, source: str) -> list[Rule]:
    """Return the rules of all style sheets of a drawing, the weightiest last.

    Raises ValueError for rules that place or hide shapes with selectors of more than a kind, ids and classes.
    """
    found = []
    for sheet in root.iter():
        if kind_of(sheet) == "style" and sheet.get("media", "all") in ("", "all", "screen"):
            text = COMMENT.sub("", "".join(sheet.itertext()))
            conditional = CONDITIONAL.search(text)
            for selectors, body in RULE.findall(text):
                declarations = _declarations(body, f"{source}: the style of {selectors.strip()}")
                if declarations:
                    if conditional:
                        selectors = f"{conditional[0]} {selectors.strip()}"
                    found += [_rule(each.strip(), declarations, source) for each in selectors.split(",")]
    return sorted(found, key=lambda rule: rule.weight)


def declared(element: Element, rules: list[Rule], source: str) -> dict[str, str]:
    """Return the attributes of an element, with the values of rules and of its style in their place."""
    own = _declarations(element.get("style", ""), f"{source}: the style of {kind_of(element)}")
    ruled = [each for rule in rules if rule.holds_for(element) for each in rule.declarations]
    found = dict(element.attrib)
    for pressing in (False, True):
        found |= {name: value for name, value, important in (*ruled, *own) if important == pressing}
    return found


def _rule(selector: str, declarations: Declarations, source: str) -> Rule:
    match = SIMPLE.fullmatch(selector)
    if not match or not selector:
        names = ", ".join(name for name, _, _ in declarations)
        raise ValueError(
            f"{source}: its style sheet gives {names} to {selector!r}; only kinds, ids and classes are read, "
            "such as path.pial. Write it at the elements, or save the drawing as plain SVG."
        )
    words = re.findall(r"[.#][\w-]+", match[2])
    ids, classes = (frozenset(w[1:] for w in words if w[0] == sign) for sign in "#.")
    return Rule((match[1] or "").replace("*", ""), ids, classes, declarations)


def _declarations(text: str, where: str) -> Declarations:
    """Return what a list of declarations says of places and of what is shown: name, value, importance."""
    found = []
    for each in COMMENT.sub("", text).split(";"):
        name, _, value = (part.strip() for part in each.partition(":"))
        plain = re.sub(r"\s*!\s*important$", "", value, flags=re.IGNORECASE)
        name = name.lower()
        if name in NOT_READ and plain.lower() not in ("none", "normal", "1", "initial"):
            raise ValueError(
                f"{where} has the property {name}, which is not read; use the attribute transform."
            )
        if name in READ and plain:
            found.append((name, plain, plain != value))
    return tuple(found)
