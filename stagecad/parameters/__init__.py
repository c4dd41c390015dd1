"""The parameter file and everything that is read off it without building a solid."""
