"""Frames to and from files."""
