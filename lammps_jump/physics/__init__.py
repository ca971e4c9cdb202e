"""Closed forms of contacts, jumps and waves."""
