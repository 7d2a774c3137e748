"""From files to the flat bond graph: names, instances, widths, laws and scenes."""
