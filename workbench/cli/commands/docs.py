"""`stagecad docs`: the documentation, built and served on this machine."""

from __future__ import annotations

from pathlib import Path

import click


@click.command("docs")
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("build"),
    show_default=True,
    help="Folder to build in.",
)
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=8323,
    show_default=True,
    help="Port to serve on; 0 for any free one.",
)
@click.option("--serve/--no-serve", default=True, help="Serve the pages until Ctrl-C, or only build them.")
@click.option("--open/--no-open", "show", default=True, help="Open a browser.")
@click.pass_context
def command(context: click.Context, out: Path, port: int, serve: bool, show: bool) -> None:
    """Build the documentation and serve it on this machine; broken links are errors."""
    from workbench.documentation.site import (
        build_site,
        commands_page,
        documentation_server,
        parameters_page,
        python_page,
    )

    group = context.find_root().command
    assert isinstance(group, click.Group)
    pages = {
        "reference_python": python_page(),
        "reference_commands": commands_page(group),
        "reference_parameters": parameters_page(),
    }
    html = build_site(out / "docs", pages)
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
