"""Records of a driven stage with something hidden in it, by laws and code of their own.

Nothing of the program is imported here. Where the program has a law, this has another: stacks follow Duhem's equation,
creep is three exponentials, pads are rigid, the contact's slip is a radial return, its Stribeck curve a Lorentzian, its
presliding elements spread geometrically. Two laws of hysteresis stand beside each other: one forgets by the path, the
other yields element by element.
"""

from .cases import HIDDEN, Hidden, write_case

__all__ = ["HIDDEN", "Hidden", "write_case"]
