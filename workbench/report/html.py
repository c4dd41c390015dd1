"""HTML pages from the packaged templates, with pictures embedded and files linked."""

from __future__ import annotations

import base64
import os
from pathlib import Path
from typing import Any


def render(template: str, **values: Any) -> str:
    """A page from a packaged template; an unknown name in the template is an error."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("workbench"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template).render(**values)


def data_url(png: bytes) -> str:
    """A PNG as an address that contains it."""
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")


def embedded(path: Path) -> str:
    """A PNG file as an address that contains it."""
    return data_url(path.read_bytes())


def link(file: Path, page: Path) -> dict[str, str]:
    """Name and relative address of a file for a page."""
    return {"name": file.name, "href": Path(os.path.relpath(file, page.parent)).as_posix()}
