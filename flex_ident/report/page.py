"""A report as one HTML file built of sections; nothing in it needs a network."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from flex_ident import __version__


@dataclass(frozen=True)
class Row:
    """One row of a table; `weak` greys it out."""

    cells: tuple[str, ...]
    weak: bool = False


@dataclass(frozen=True)
class Image:
    """A picture as `data:` address, and what it shows in words."""

    source: str
    alt: str


@dataclass(frozen=True)
class Merit:
    """A number that a reader should see first."""

    name: str
    value: str
    note: str = ""


@dataclass(frozen=True)
class Section:
    """Texts, a list, a table, pictures and small print, in this order; `right` are the columns flush right."""

    title: str
    texts: tuple[str, ...] = ()
    items: tuple[str, ...] = ()
    header: tuple[str, ...] = ()
    rows: tuple[Row, ...] = ()
    right: tuple[int, ...] = ()
    images: tuple[Image, ...] = ()
    notes: tuple[str, ...] = ()


def _typeset(text: object) -> object:
    """Powers of units and formulas as a reader expects them: kg m²."""
    return text.replace("^2", "²").replace("^3", "³") if type(text) is str else text


def page_html(
    *,
    title: str,
    heading: str,
    verdict: str,
    summary: str,
    sections: Sequence[Section],
    merits: Sequence[Merit] = (),
    source: str = "",
) -> str:
    """The page. All texts are escaped."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent), autoescape=True, undefined=StrictUndefined, finalize=_typeset
    )
    return environment.get_template("page.html").render(
        title=title, heading=heading, verdict=verdict, summary=summary, sections=sections, figures_of_merit=merits,
        footer=f"flex_ident {__version__}. {source}",
    )  # fmt: skip
