"""What scripts/doctor looks at. Standard library alone: it must run where nothing else does."""
