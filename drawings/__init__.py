"""Drawing sheets made from the dimension declarations of the solids."""
