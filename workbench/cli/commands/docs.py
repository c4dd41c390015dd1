"""`stagecad docs`: the documentation, built by Sphinx (`docs/conf.py`) and served on this machine."""

from pathlib import Path

import click

from workbench.cli.options import OUT, port_option
from workbench.operations.site import build_site, documentation_server
from workbench.operations.templates import shared_folder


@click.command("docs")
@OUT
@port_option(8323)
@click.option("--serve/--no-serve", default=True, help="Serve the pages until Ctrl-C, or only build them.")
@click.option("--open/--no-open", "show", default=True, help="Open a browser.")
def command(out: Path, port: int, serve: bool, show: bool) -> None:
    """Build the documentation and serve it on this machine; broken links are errors."""
    html = build_site(out / "docs", shared_folder())
    click.echo(f"documentation: {html / 'index.html'}")
    if not serve:
        return
    with documentation_server(html, port) as server:
        address = f"http://127.0.0.1:{server.server_port}/"
        click.echo(f"served at {address} until Ctrl-C")
        if show:
            import webbrowser

            webbrowser.open(address)
        server.serve_forever()
