"""`bgc explain`."""

from __future__ import annotations

import click


@click.command()
@click.argument("code")
def explain(code: str) -> None:
    """Tell what a diagnostic means, why it is one, and the way out: bgc explain BG201."""
    from bgc.grammar.catalogue.pages import find_page

    page = find_page(code)
    if page is None:
        raise click.UsageError(f"there is no diagnostic {code}; codes look like BG201")
    click.echo(page)
