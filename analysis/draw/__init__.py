"""Figures and film of discs, walls and fields."""
