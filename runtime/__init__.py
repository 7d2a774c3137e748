"""The runtime: load, run, analyse and plot compiled models; the `bgc` command."""
