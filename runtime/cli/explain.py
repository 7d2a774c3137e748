"""`bgc explain`."""

from __future__ import annotations

from collections.abc import Mapping

import click

from bgc.diagnostics.catalogue.pages import find_page, near_pages, topics


@click.command()
@click.argument("code", required=False)
def explain(code: str | None) -> None:
    """Tell what a diagnostic means, why it is one, and the way out: bgc explain BG201.

    Without a code, or with a word instead of one, list the diagnostics there are.
    """
    if code is None:
        blocks = (f"{title}\n{_listed(found)}" for title, found in topics())
        click.echo("\n".join(blocks), nl=False)
        return
    page = find_page(code)
    if page is not None:
        click.echo(page)
        return
    near = near_pages(code)
    if near and not any(char.isdigit() for char in code):
        click.echo(_listed(near), nl=False)
        return
    hint = f"; near it are\n\n{_listed(near)}" if near else "; codes look like BG201"
    raise click.UsageError(f"there is no diagnostic {code}{hint}".rstrip())


def _listed(pages: Mapping[str, str]) -> str:
    """List the code and the title of each page."""
    return "".join(f"  {page.partition(chr(10))[0]}\n" for page in pages.values())
