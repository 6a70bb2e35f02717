"""The report of a session (scripts/session_report): one module for each part of the page. doc/report.md."""
