"""The loop: where to look, what was seen, what is done about it, and the journal of all that."""
