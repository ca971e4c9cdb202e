"""The engines: LAMMPS with stock styles or the plugin, and the native one."""
