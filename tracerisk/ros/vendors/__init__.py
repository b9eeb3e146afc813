"""Drivers of robot makers on the twin: a folder a maker, described as data where that can be."""
