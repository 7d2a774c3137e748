"""The runtime: compiled models loaded, run and plotted, and the `bgc` command."""
