"""Uncertainty of measurement by the GUM (JCGM 100:2008) and its supplement 1 (JCGM 101:2008)."""
