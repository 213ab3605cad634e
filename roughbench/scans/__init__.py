"""Measured surfaces: from a file to heights that the models can work with."""
