"""Several specimens beside each other: tables, figures, a noise sweep, one page and one PDF."""
