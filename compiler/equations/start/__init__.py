"""The start of storage that no closed formula gives: a system that the runtime solves."""
