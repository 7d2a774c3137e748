"""Studies of speed against accuracy: measure configurations, and recommend one."""
