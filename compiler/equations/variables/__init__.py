"""Every variable of a causal graph, defined in terms of others."""
