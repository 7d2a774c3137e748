"""The trade between speed and accuracy, measured for a scene."""
