"""Experiments with a hidden effect, second kind: other laws, machines, motions and loggers than the first generator's.

Set-valued friction in semi-implicit time steps, several Stribeck forms, memory by time or distance, rate-and-state
ageing, many bristles, cogging of three harmonics, Preisach relays, Voigt creep, second-order sensors. Nothing is shared
with the library that is judged.
"""

from .cases import make_case, make_cases

__all__ = ["make_case", "make_cases"]
