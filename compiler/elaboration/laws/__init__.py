"""Laws: read arguments, law blocks and equations as nodes of the flat graph."""
