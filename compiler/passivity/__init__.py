"""What physics asks of the laws of elements: energies that exist, and nothing that makes power."""
