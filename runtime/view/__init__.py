"""The page of `bgc view`: live runs and recorded ones, their protocol and their server."""
