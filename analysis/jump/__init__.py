"""The hydraulic jump."""
