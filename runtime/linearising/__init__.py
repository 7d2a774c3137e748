"""A scene linearised about an operating point."""
