"""Drawings of fault trees, chains and assessments, as SVG that needs no other package."""
