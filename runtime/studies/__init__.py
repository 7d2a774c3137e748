"""Studies of many runs: sweeps, estimation, clusters, operability."""
