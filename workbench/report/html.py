"""HTML pages from the packaged templates, with pictures embedded and files linked."""

from __future__ import annotations

import base64
import hashlib
import os
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from jinja2 import Template


def render(template: str, **values: Any) -> str:
    """A page from a packaged template; an unknown name in the template is an error."""
    return compiled(template).render(**values)


@cache
def compiled(template: str) -> Template:
    """A packaged template; compiling it takes longer than to fill it in."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("workbench"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template)


@cache
def templates_digest() -> str:
    """Sha256 of the packaged templates of pages."""
    digest = hashlib.sha256()
    for path in sorted((Path(__file__).resolve().parents[1] / "templates").glob("*.html")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def data_url(png: bytes) -> str:
    """A PNG as an address that contains it."""
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")


def embedded(path: Path) -> str:
    """A PNG file as an address that contains it."""
    return data_url(path.read_bytes())


def link(file: Path, page: Path) -> dict[str, str]:
    """Name and relative address of a file for a page."""
    return {"name": file.name, "href": Path(os.path.relpath(file, page.parent)).as_posix()}
