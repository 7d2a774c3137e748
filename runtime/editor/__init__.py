"""The language server and the colours of the language for editors."""
