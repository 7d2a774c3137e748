"""Linear models: state space, modes, frequency response; NumPy and SciPy alone."""
