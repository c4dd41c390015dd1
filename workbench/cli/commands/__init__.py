"""One file per command of `stagecad`."""
