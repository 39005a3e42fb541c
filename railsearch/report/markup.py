"""What the reports are made of: one HTML page that needs nothing beside itself, sections, tables, pictures."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable, Mapping, Sequence
from importlib.resources import files
from string import Template
from typing import TYPE_CHECKING, Any

from railsearch.report.figures import drawn
from railsearch.wording import quantity_label

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Row = Sequence[object]

PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>$title</title>
<style>
$style</style>
</head>
<body>
<h1>$title</h1>
<p class="lead">$summary</p>
$content
$script</body>
</html>
""")


class Markup(str):
    """Text that is HTML already and is not escaped again."""


def page(title: str, summary: str, content: Iterable[str], styles: Sequence[str] = (), scripts: Sequence[str] = ()) -> str:
    """A page of a title, a summary and HTML parts; styles and scripts: files of this package beside page.css."""
    style = "".join(resource(name) for name in ("page.css", *styles))
    script = "".join(f"<script>\n{resource(name)}</script>\n" for name in scripts)
    parts = {"title": escaped(title), "summary": escaped(summary), "content": "\n".join(content)}
    return PAGE.substitute(parts, style=style, script=script)


def resource(name: str) -> str:
    """A style sheet or script of this package."""
    return files("railsearch.report").joinpath(name).read_text(encoding="utf-8")


def section(title: str, content: str, name: str = "") -> str:
    """A section under its heading; name: the identifier by which it is referred to."""
    opening = f'<section id="{escaped(name)}">' if name else "<section>"
    return f"{opening}<h2>{escaped(title)}</h2>\n{content}\n</section>"


def table(titles: Row, rows: Iterable[Row], numbers: Iterable[int] = (), marked: Sequence[bool] = (), kind: str = "") -> str:
    """A table; numbers: the columns that are aligned to the right; marked: which rows stand out; kind: its class."""
    right = set(numbers)
    body = [_line(row, "td", right, place < len(marked) and marked[place]) for place, row in enumerate(rows)]
    opening = f'<table class="{kind}">' if kind else "<table>"
    return (
        f'<div class="scroll">{opening}<thead>{_line(titles, "th", right)}</thead>\n<tbody>\n'
        + "\n".join(body)
        + "\n</tbody></table></div>"
    )


def picture(name: str, figure: Figure, kind: str = "") -> str:
    """A figure with its label as the caption, drawn into the page; kind: its class."""
    caption = escaped(str(figure.get_label()))
    opening = f'<figure id="{escaped(name)}" class="{kind}">' if kind else f'<figure id="{escaped(name)}">'
    return f'{opening}<div class="scroll">{drawing(name, figure)}</div><figcaption>{caption}</figcaption></figure>'


def drawing(name: str, figure: Figure) -> str:
    """A figure as an element of a page, without a caption."""
    return inlined(drawn(figure, "svg", name).decode("utf-8"), name)


def inlined(image: str, name: str) -> str:
    """An SVG file as an element of a page: no header, no metadata, identifiers made unique by the figure's name."""
    element = re.sub(r"<metadata>.*?</metadata>", "", image[image.index("<svg") :], flags=re.DOTALL)
    return re.sub(r'(\bid="|url\(#|href="#)', rf"\g<1>{name}-", element)


def labelled(quantity: Mapping[str, Any]) -> str:
    """A name with its unit in brackets."""
    return quantity_label(quantity["name"], quantity["unit"])


def escaped(value: object) -> str:
    """Any value as text of a page."""
    return value if isinstance(value, Markup) else html.escape(str(value))


def _line(cells: Row, tag: str, right: set[int], marked: bool = False) -> str:
    kinds = [' class="number"' if place in right else "" for place in range(len(cells))]
    line = "".join(f"<{tag}{kind}>{escaped(cell)}</{tag}>" for kind, cell in zip(kinds, cells, strict=True))
    return f'<tr class="objective">{line}</tr>' if marked else f"<tr>{line}</tr>"
