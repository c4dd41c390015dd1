"""The local web page: `stagecad workbench`."""
