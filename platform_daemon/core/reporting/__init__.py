"""Parts that the reports of all features share: numbers with errors, tables, pages, pictures."""
