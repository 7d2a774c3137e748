"""The graph of scalar expressions and the computations on it: values, derivatives, text."""
