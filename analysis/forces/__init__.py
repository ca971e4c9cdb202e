"""Force on structures, its impulse, the reflected wave."""
