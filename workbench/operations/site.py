"""`docs`: the documentation as a site, built by Sphinx (`docs/conf.py`) and served on this machine."""

import shutil
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from stagecad.parameters.errors import InputError


def build_site(folder: Path, root: Path) -> Path:
    """Build the site of the pages below `root`, README.md and those of the examples too; returns its HTML pages."""
    try:
        from sphinx.cmd.build import build_main
    except ImportError:
        raise InputError("the documentation is built by Sphinx: pip install 'stagecad[docs]'") from None
    source, html, log = folder / "source", folder / "html", folder / "warnings.txt"
    shutil.rmtree(source, ignore_errors=True)
    # With the times of the files: only pages that have changed are built again.
    shutil.copytree(root / "docs", source)
    shutil.copy2(root / "README.md", source / "readme.md")
    shutil.copy2(root / "examples" / "README.md", source / "examples.md")
    arguments = ["-q", "-b", "html", "-d", str(folder / "doctrees"), "-w", str(log), str(source), str(html)]
    status = build_main(arguments)
    faults = [line for line in log.read_text("utf-8").splitlines() if line.strip()] if log.is_file() else []
    if status or faults:
        raise InputError(f"documentation: {faults[0] if faults else 'was not built'} ({len(faults)} faults in {log})")
    return html


def documentation_server(folder: Path, port: int) -> ThreadingHTTPServer:
    """A server of the files of a folder on 127.0.0.1; `port` 0 takes a free one."""
    # Requests are not logged.
    quiet = type("Quiet", (SimpleHTTPRequestHandler,), {"log_message": lambda *words: None})
    try:
        return ThreadingHTTPServer(("127.0.0.1", port), partial(quiet, directory=str(folder)))
    except OSError as error:
        raise InputError(f"--port {port}: {error.strerror}; choose another, or 0 for a free one") from None
