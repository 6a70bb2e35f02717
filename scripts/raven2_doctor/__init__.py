"""Checks of scripts/doctor. Standard library alone: it must run where nothing else does."""
