"""Sessions in other programs' formats (scripts/export_dataset, export_session --format). doc/report.md."""
