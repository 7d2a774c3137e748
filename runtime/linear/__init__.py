"""Linear systems: state space, modes, frequency response."""
