"""`stagecad workbench`: serves the page for machine, simulation and measurement on this computer."""

import os
from contextlib import suppress
from pathlib import Path

import click

from stagecad.parameters.errors import InputError, require
from workbench.cli.options import Run, common_options, port_option, without_effect

TOKEN = "Secret that the browser must present; chosen at random once for this user."
TRUST = "Ask on the page for consent to the Python code of experiments ([model] custom)."


@click.command("workbench")
@click.option("--host", default="127.0.0.1", show_default=True, help="Address to listen on.")
@port_option(8321)
@click.option("--token", default=None, metavar="TEXT", help=TOKEN)
@click.option("--browser/--no-browser", default=True, help="Open the page in the browser.")
@click.option("--trust", is_flag=True, help=TRUST)
@without_effect("overrides", "json_target")
@common_options
def command(run: Run, host: str, port: int, token: str | None, browser: bool, trust: bool) -> None:
    """Serve a page for the machine, simulations and measurements of the present folder; Ctrl-C ends it."""
    from workbench.page.project import Project
    from workbench.page.server import serve

    require(not run.overrides, "--set: values are changed on the page; name the parameter file with --params")
    secret = _page_token(token)
    params = run.design.path
    if run.params is None and params is not None and Path.cwd().resolve() not in params.resolve().parents:
        raise InputError(f"{params}: is a link that leads out of the folder; name the file with --params")
    serve(Project(Path.cwd(), run.out, params, trust), host, port, secret, run.note, browser)


LEAST_TOKEN = 16
"""Smallest number of characters of a token."""


def _page_token(given: str | None) -> str:
    """The secret of the browser: the one given, else the one kept: an open page finds a server started again."""
    import secrets

    from stagecad.parameters.atomic import atomic_write_text
    from stagecad.private import make_private, user_folder

    if given is not None:
        require(len(given) >= LEAST_TOKEN, f"--token: at least {LEAST_TOKEN} characters are required")
        return given
    folder = user_folder("XDG_STATE_HOME", os.path.join(".local", "state"))
    with suppress(OSError, UnicodeDecodeError):
        if folder is not None:
            file = make_private(folder / "workbench") / "token"
            if not file.exists():
                atomic_write_text(file, secrets.token_urlsafe(24))
            if len(token := file.read_text("utf-8")) >= LEAST_TOKEN:
                return token
    return secrets.token_urlsafe(24)
