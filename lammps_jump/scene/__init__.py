"""What is simulated, in SI numbers."""
