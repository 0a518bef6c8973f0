"""Small things that any other part may use."""
