"""Notes of diagnostics that name the instance where an error was found."""

from __future__ import annotations

from bgc.elaboration.instances.tree import Environment, Instance


def note_of(instance: Instance) -> str:
    """The note of a diagnostic that names the instance where the error was found."""
    return f"in `{instance.path}`" if instance.path else ""


def note(env: Environment) -> str:
    """The note that names the instance of an environment."""
    return note_of(env.instance) if env.instance else ""
