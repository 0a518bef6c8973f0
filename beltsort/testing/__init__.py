"""Tools for authors of drivers: a reference controller, servers for it, and fault injection."""
