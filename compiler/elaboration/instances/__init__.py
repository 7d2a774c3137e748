"""The tree of instances: models with their arguments, slots, loops and conditions expanded."""
