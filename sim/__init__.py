"""Physical effects, the model composed of them, integrators and the thesis's experiments."""
