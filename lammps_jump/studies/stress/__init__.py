"""Limits of stability, hard scenes and random cases."""
