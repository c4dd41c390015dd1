"""Purchased parts as clean simplified solids: outer dimensions true, threads cosmetic."""
