"""Drawing sheets made from the dimension declarations that stand beside the solids."""
