"""`stagecad new KIND NAME`: templates of what a user makes."""

from __future__ import annotations

import click

from stagecad.parameters.errors import nearest


class Templates(click.Group):
    """A group of one command for each kind of template; an unknown kind is refused with the most similar one."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and not args[0].startswith("-") and args[0] not in self.commands:
            raise click.UsageError(f"new: no template of a '{args[0]}'{nearest(args[0], self.commands)}", ctx)
        return super().resolve_command(ctx, args)


@click.group("new", cls=Templates)
def command() -> None:
    """Write a template of KIND to start from."""
