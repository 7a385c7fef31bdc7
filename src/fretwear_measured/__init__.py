"""Surfaces and tables as instruments write them: roughness, profiles of indenters, recordings."""
