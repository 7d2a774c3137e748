"""The instance tree: models with arguments bound, slots filled, loops and conditions expanded."""
