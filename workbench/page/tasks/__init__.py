"""Work that the page hands to processes of their own, one module for each kind."""
