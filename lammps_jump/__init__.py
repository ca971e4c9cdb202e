"""lammps-jump: free-surface flow with discs on LAMMPS, from a YAML case to a report."""
