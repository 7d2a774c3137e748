"""From state equations to C."""
