"""Documents made from Jinja2 templates, which stand in this folder."""
