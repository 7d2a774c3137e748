"""From independent flows to assigned state equations."""
