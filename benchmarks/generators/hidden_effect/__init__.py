"""Experiments with a hidden effect, from a simulator that shares no law and no code with the library it judges.

Its laws are deliberately others: stop operators in parallel for bristles, a Lorentzian for the Stribeck curve, a power
for the load, play operators for piezo hysteresis, a logarithm of the time at rest for dwell. Rigid friction is solved
exactly, step by step, as a velocity complementarity (Moreau), where a model library would stretch a stiff bristle.
What is in the base model keeps the base model's own form: nothing hidden has to mean nothing left to find.
"""

from .case import Case, make_case
from .drawn import Plan
from .series import KINDS, make_cases

__all__ = ["KINDS", "Case", "Plan", "make_case", "make_cases"]
