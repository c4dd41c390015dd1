"""The thesis's machine as a simulation: its model from a design, and its studies."""
