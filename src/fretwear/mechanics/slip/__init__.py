"""Loading along the surface, and slip in one direction or as a vector."""
