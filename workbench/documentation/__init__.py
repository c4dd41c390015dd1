"""The documentation as a site: pages of `docs/`, reference pages from the code, built by Sphinx and served locally."""
