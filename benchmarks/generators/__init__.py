"""Simulators of records with known hidden effects, which share no law and no integrator with the program."""
