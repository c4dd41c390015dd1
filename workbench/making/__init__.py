"""`stagecad make`: its results in the store, and their making side by side."""
