"""The nearest design without violated rules and failed checks, or the requirements that contradict each other."""
