"""What a person touches: command line, reports, demonstration records."""
