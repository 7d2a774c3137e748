"""Analysis of texts for editors: names, completion, hover, hints, rename, colours."""
