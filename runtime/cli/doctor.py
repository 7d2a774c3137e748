"""`bgc doctor`."""

from __future__ import annotations

import click

from bgc.runtime.cli.app import AT_FAULT
from bgc.runtime.cli.machine import examine, is_well, report


@click.command()
@click.pass_context
def doctor(context: click.Context) -> None:
    """Check compiler, cache and packages of this machine.

    The exit status is 1 where something needed is missing.
    """
    findings = examine()
    click.echo(report(findings))
    if not is_well(findings):
        context.exit(AT_FAULT)
