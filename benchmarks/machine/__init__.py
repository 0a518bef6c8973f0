"""How fast planning and perception are on this machine."""
