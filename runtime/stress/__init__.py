"""A scene driven to its extremes: where it holds, where it degrades, where it fails."""
