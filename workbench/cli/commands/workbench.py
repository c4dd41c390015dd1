"""`stagecad workbench`: serves the page for machine, simulation and measurement on this computer."""

from __future__ import annotations

from pathlib import Path

import click

from stagecad.parameters.errors import InputError
from workbench.cli.options import Run, common_options

LOOPBACK = ("127.0.0.1", "localhost", "::1")


@click.command("workbench")
@click.option("--host", default="127.0.0.1", show_default=True, help="Address to listen on.")
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=8321,
    show_default=True,
    help="Port to serve on; 0 for any free one.",
)
@click.option(
    "--token",
    default=None,
    metavar="TEXT",
    help="Secret that the browser must present; chosen at random unless the address is that of this computer.",
)
@click.option("--browser/--no-browser", default=True, help="Open the page in the browser.")
@click.option(
    "--trust", is_flag=True, help="Ask on the page for consent to the Python code of experiments ([model] custom)."
)
@common_options
def command(run: Run, host: str, port: int, token: str | None, browser: bool, trust: bool) -> None:
    """Serve a page for the machine, simulations and measurements of the present folder; Ctrl-C ends it."""
    import secrets

    from workbench.page.project import Project
    from workbench.page.server import serve

    if run.overrides:
        raise InputError("--set: values are changed on the page; name the parameter file with --params")
    if token is not None and len(token) < 16:
        raise InputError("--token: at least 16 characters are required")
    if token is None and host not in LOOPBACK:
        token = secrets.token_urlsafe(24)
    project = Project(Path.cwd(), run.out, run.design.path, trust)
    serve(project, host, port, token, run.note, browser)
