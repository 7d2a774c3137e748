"""Real time: the servo loop, its devices and its records."""
