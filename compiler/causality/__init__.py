"""From the flat graph to its independent flows and causal strokes."""
